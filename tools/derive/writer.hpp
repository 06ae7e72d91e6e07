#pragma once
// Writes recorded steps as C++: one statement per operation, in the order in which the text asked for them, so that few values
// are live at a time.
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include <tools/derive/steps.hpp>

namespace momentree::derive {

class Writer {
 public:
  Writer(const Recorder& in, const Derived& steps)
      : in_(in), steps_(steps), nodes_(in.expressions.nodes()), constant_(nodes_.size()), record_(nodes_.size(), -1) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const auto& n = nodes_[i];
      constant_[i] = n.operation == Operation::constant || n.operation == Operation::p ||
                     (unary(n.operation) && constant_[at(n.a)]) ||
                     (binary(n.operation) && constant_[at(n.a)] && constant_[at(n.b)]);
    }
    for (std::size_t i = 0; i < steps.record.size(); ++i) record_[at(steps.record[i])] = static_cast<int>(i);
  }

  std::string inboard() {
    std::vector<Store> stores = steps_.inboard.stores;
    for (const int node : steps_.record) stores.push_back({"w.x[" + std::to_string(record_[at(node)]) + ']', node, {}});
    return function(steps_.inboard, stores, false);
  }
  std::string outboard() { return function(steps_.outboard, steps_.outboard.stores, true); }
  /// Operations written so far.
  int operations() const { return operations_; }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  bool stops(std::size_t i) const { return named(static_cast<int>(i)) != nullptr || (reads_record_ && record_[i] >= 0); }

  /// The statements of a function: each number is stored as soon as it is known, and no input in the same memory is still to be
  /// read.
  std::string function(const Function& f, std::vector<Store> stores, bool reads_record) {
    text_.clear(), comments_ = &f.comments, comment_ = 0, reads_record_ = reads_record;
    std::vector<bool> needed(nodes_.size(), false);
    stores.insert(stores.end(), f.last.begin(), f.last.end());
    for (const Store& one : stores) needed[at(one.node)] = true;
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      if (!needed[i] || stops(i)) continue;
      const auto& n = nodes_[i];
      if (unary(n.operation) || binary(n.operation)) needed[at(n.a)] = true;
      if (binary(n.operation)) needed[at(n.b)] = true;
    }
    std::vector<std::size_t> due;  // by store: the statement after which it comes
    std::map<std::string, std::size_t> last_read;
    const auto reads = [&](int node, std::size_t statement) {
      const int x = magnitude(node);
      if (nodes_[at(x)].operation == Operation::q) last_read[in_.numbers[at(nodes_[at(x)].a)]] = statement;
    };
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (is_statement(i, needed)) reads(nodes_[i].a, i), reads(nodes_[i].b, i);
    for (const Store& one : stores) {
      std::size_t after = at(magnitude(one.node));
      if (one.to.starts_with("to.") || one.to.starts_with("out.")) {
        const std::string input = one.to.starts_with("to.") ? "a." + one.to.substr(3) : one.to;
        if (last_read.contains(input)) after = std::max(after, last_read[input]);
        for (const Store& other : stores)  // an input that another store copies
          if (&other != &one && nodes_[at(magnitude(other.node))].operation == Operation::q &&
              in_.numbers[at(nodes_[at(magnitude(other.node))].a)] == input)
            after = nodes_.size() - 1;
      }
      due.push_back(after);
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (is_statement(i, needed)) {
        comment(static_cast<int>(i));
        const char* const type = constant_[i] ? "double" : "T";
        text_ += std::string("    const ") + type + " x" + std::to_string(i) + " = " + operand(nodes_[i].a) +
                 symbol(nodes_[i].operation) + operand(nodes_[i].b) + ";\n";
        ++operations_;
      }
      for (std::size_t k = 0; k < stores.size(); ++k)
        if (due[k] == i) write(stores[k]);
    }
    return text_;
  }
  bool is_statement(std::size_t i, const std::vector<bool>& needed) const {
    return needed[i] && binary(nodes_[i].operation) && !stops(i);
  }
  /// A node without its changes of sign.
  int magnitude(int node) const {
    while (nodes_[at(node)].operation == Operation::negative) node = nodes_[at(node)].a;
    return node;
  }
  void write(const Store& one) {
    std::string value = operand(one.node);
    if (constant_[at(one.node)]) value = "T(" + value + ')';
    if (!one.guard.empty()) value = one.guard + " ? " + value + " : T(0)";
    text_ += one.to.starts_with("to.") ? "    contribute<Add, T>(" + one.to + ", " + value + ");\n"
                                       : "    " + one.to + " = " + value + ";\n";
  }
  void comment(int node) {
    const std::string* text = nullptr;
    while (comment_ < comments_->size() && (*comments_)[comment_].before <= node) text = &(*comments_)[comment_++].text;
    if (text != nullptr) text_ += "    // " + *text + '\n';
  }

  static const char* symbol(Operation operation) {
    switch (operation) {
      case Operation::sum: return " + ";
      case Operation::difference: return " - ";
      case Operation::product: return " * ";
      default: return " / ";
    }
  }
  const std::string* named(int i) const {
    for (const auto& [node, name] : in_.names)
      if (node == i) return &name;
    return nullptr;
  }
  std::string operand(int i) const {
    const auto& n = nodes_[at(i)];
    if (const std::string* name = named(i)) return *name;
    switch (n.operation) {
      case Operation::constant: return number(n.value);
      case Operation::q: return in_.numbers[at(n.a)];
      case Operation::p: return in_.constants[at(n.a)];
      case Operation::negative: return "-" + operand(n.a);
      default: break;
    }
    if (reads_record_ && record_[at(i)] >= 0) return "w.x[" + std::to_string(record_[at(i)]) + ']';
    return "x" + std::to_string(i);
  }
  static std::string number(double value) {
    char text[40];
    std::string s(text, std::to_chars(text, text + sizeof text, value).ptr);
    if (s.find_first_of(".e") == std::string::npos) s += ".0";
    return s;
  }

  const Recorder& in_;
  const Derived& steps_;
  const std::vector<Expressions::Node>& nodes_;
  std::vector<bool> constant_;
  std::vector<int> record_;
  std::string text_;
  const std::vector<Comment>* comments_ = nullptr;
  std::size_t comment_ = 0;
  bool reads_record_ = false;
  int operations_ = 0;
};

}  // namespace momentree::derive

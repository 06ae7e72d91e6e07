#pragma once
// Writes recorded steps as C++: one statement per operation, in the order in which the text asked for them, so that few values
// are live at a time.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include <momentree/derive/recorder.hpp>

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

  /// The statements of one of the functions.
  std::string function(std::size_t i) {
    const Function& f = steps_.functions[i];
    function_ = i;
    std::vector<Store> stores = f.stores;
    for (const int node : steps_.record)
      if (steps_.owner(node) == i) stores.push_back({"w.x[" + std::to_string(record_[at(node)]) + ']', node, {}});
    return function(f, stores);
  }
  /// Operations written so far.
  int operations() const { return operations_; }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  /// Whether a node is read from the record: it was stored there by a function that runs earlier.
  bool recorded(int i) const { return record_[at(i)] >= 0 && steps_.owner(i) < function_; }
  bool stops(std::size_t i) const { return named(static_cast<int>(i)) != nullptr || recorded(static_cast<int>(i)); }

  /// The statements of a function: each number is stored as soon as it is known, and no input in the same memory is still to be
  /// read.
  std::string function(const Function& f, std::vector<Store> stores) {
    text_.clear(), comments_ = &f.comments, comment_ = 0;
    std::vector<bool> needed(nodes_.size(), false);
    stores.insert(stores.end(), f.last.begin(), f.last.end());
    for (const Store& one : stores) needed[at(one.node)] = true;
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      if (!needed[i] || stops(i)) continue;
      const auto& n = nodes_[i];
      if (unary(n.operation) || binary(n.operation)) needed[at(n.a)] = true;
      if (binary(n.operation)) needed[at(n.b)] = true;
    }
    std::vector<std::size_t> order;  // of the statements: what comes first with all that it needs, then as recorded
    std::vector<std::size_t> place(nodes_.size(), 0);  // in this order, from one
    const auto visit = [&](auto&& self, std::size_t i) -> void {
      if (!needed[i] || place[i] != 0 || stops(i)) return;
      const auto& n = nodes_[i];
      if (unary(n.operation) || binary(n.operation)) self(self, at(n.a));
      if (binary(n.operation)) self(self, at(n.b));
      if (binary(n.operation)) order.push_back(i), place[i] = order.size();
    };
    for (const int node : f.first) visit(visit, at(magnitude(node)));
    const std::size_t first = order.size();
    for (std::size_t i = 0; i < nodes_.size(); ++i) visit(visit, i);
    const std::vector<std::size_t> due = when_due(stores, order, place);
    if (first > 0) text_ += "    // (24) first: 1 / Mj and G\n";
    for (std::size_t n = 0; n < order.size(); ++n) {
      if (n >= first) comment(static_cast<int>(order[n]));
      statement(order[n]);
      for (std::size_t k = 0; k < stores.size(); ++k)
        if (due[k] == n + 1 && n + 1 < order.size()) write(stores[k]);
    }
    last_stores(stores, due, order.size());
    return text_;
  }
  /// The stores at the end, copies of inputs by way of other variables, because the inputs may be overwritten there.
  void last_stores(std::vector<Store> stores, const std::vector<std::size_t>& due, std::size_t end) {
    std::vector<std::string> values;
    for (std::size_t k = 0; k < stores.size(); ++k) {
      values.emplace_back();
      if (due[k] != end || nodes_[at(magnitude(stores[k].node))].operation != Operation::q || stores[k].to.starts_with("w."))
        continue;
      values.back() = "y" + std::to_string(k);
      text_ += "    const T " + values.back() + " = " + operand(stores[k].node) + ";\n";
    }
    for (std::size_t k = 0; k < stores.size(); ++k)
      if (due[k] == end) write(stores[k], values[k]);
  }
  /// By store, the number of statements that come before it: its value, and the readers of an input in the same memory.
  std::vector<std::size_t> when_due(const std::vector<Store>& stores, const std::vector<std::size_t>& order,
                                    const std::vector<std::size_t>& place) const {
    std::map<std::string, std::size_t> last_read;
    const auto reads = [&](int node, std::size_t n) {
      const auto& one = nodes_[at(magnitude(node))];
      if (one.operation == Operation::q) last_read[in_.numbers[at(one.a)]] = n;
    };
    for (std::size_t n = 0; n < order.size(); ++n) reads(nodes_[order[n]].a, n + 1), reads(nodes_[order[n]].b, n + 1);
    for (const Store& one : stores) reads(one.node, order.size());  // a copy of an input
    std::vector<std::size_t> due;
    for (const Store& one : stores) {
      const std::string input = one.to.starts_with("to.") ? "a." + one.to.substr(3) : one.to;
      const auto read = last_read.find(input);
      const std::size_t after = std::max(place[at(magnitude(one.node))], read == last_read.end() ? 0 : read->second);
      due.push_back(after == 0 ? order.size() : after);  // constants at the end
    }
    return due;
  }
  void statement(std::size_t i) {
    text_ += std::string("    const ") + (constant_[i] ? "double" : "T") + " x" + std::to_string(i) + " = " +
             operand(nodes_[i].a) + symbol(nodes_[i].operation) + operand(nodes_[i].b) + ";\n";
    ++operations_;
  }
  /// A node without its changes of sign.
  int magnitude(int node) const {
    while (nodes_[at(node)].operation == Operation::negative) node = nodes_[at(node)].a;
    return node;
  }
  void write(const Store& one, std::string value = {}) {
    if (value.empty()) value = operand(one.node);
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
    if (recorded(i)) return "w.x[" + std::to_string(record_[at(i)]) + ']';
    switch (n.operation) {
      case Operation::constant: return number(n.value);
      case Operation::q: return in_.numbers[at(n.a)];
      case Operation::p: return in_.constants[at(n.a)];
      case Operation::negative: return "-" + operand(n.a);
      default: break;
    }
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
  std::size_t function_ = 0;
  int operations_ = 0;
};

}  // namespace momentree::derive

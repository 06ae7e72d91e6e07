#pragma once
// Writes recorded steps as C++: one statement per operation, in the order in which the text asked for them, so that few values are
// live at a time.
#include <charconv>
#include <cmath>
#include <cstdlib>
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
    begin(steps_.inboard);
    std::vector<Store> stores = steps_.inboard.stores;
    for (const int node : steps_.record) stores.push_back({"w.x[" + std::to_string(record_[at(node)]) + ']', node, {}});
    section(stores, true);
    text_ += "    if (root) return;\n";
    section(steps_.inboard.last, false);
    return text_;
  }
  std::string outboard() {
    begin(steps_.outboard);
    reads_record_ = true;
    section(steps_.outboard.stores, true);
    section(steps_.outboard.last, false);
    return text_;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  void begin(const Function& f) {
    text_.clear(), written_.assign(nodes_.size(), false), reads_record_ = false;
    comments_ = &f.comments, comment_ = 0;
  }

  bool stops(std::size_t i) const { return named(static_cast<int>(i)) != nullptr || (reads_record_ && record_[i] >= 0); }

  void section(const std::vector<Store>& stores, bool at_once) {
    std::vector<bool> needed(nodes_.size(), false);
    for (const Store& one : stores) needed[at(one.node)] = true;
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      if (!needed[i] || stops(i)) continue;
      const auto& n = nodes_[i];
      if (unary(n.operation) || binary(n.operation)) needed[at(n.a)] = true;
      if (binary(n.operation)) needed[at(n.b)] = true;
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (needed[i] && binary(nodes_[i].operation) && !stops(i) && !written_[i]) {
        comment(static_cast<int>(i));
        const char* const type = constant_[i] ? "double" : "T";
        text_ += std::string("    const ") + type + " x" + std::to_string(i) + " = " + operand(nodes_[i].a) +
                 symbol(nodes_[i].operation) + operand(nodes_[i].b) + ";\n";
        written_[i] = true;
      }
      if (!needed[i] || !at_once) continue;
      for (const Store& one : stores)
        if (at(one.node) == i) write(one);
    }
    if (!at_once)
      for (const Store& one : stores) write(one);
  }
  void write(const Store& one) {
    std::string value = operand(one.node);
    if (constant_[at(one.node)]) value = "T(" + value + ')';
    if (!one.guard.empty()) value = one.guard + " ? " + value + " : T(0)";
    text_ += "    " + one.to + " = " + value + ";\n";
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
  std::vector<bool> constant_, written_;
  std::vector<int> record_;
  std::string text_;
  const std::vector<Comment>* comments_ = nullptr;
  std::size_t comment_ = 0;
  bool reads_record_ = false;
};

}  // namespace momentree::derive

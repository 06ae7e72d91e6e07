// A step as text, for people.
#include <cstdio>

#include <momentree/derive/step.hpp>

namespace momentree::derive {

std::string Step::listing() const {
  const auto& nodes = in_->expressions.nodes();
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  std::vector<int> results = record_;
  for (const Function& f : steps_.functions)
    for (const auto* list : {&f.stores, &f.last})
      for (const Store& one : *list) results.push_back(one.node);
  const std::vector<bool> needed = in_->expressions.needed(results);
  const auto operand = [&](const auto& self, int i) -> std::string {
    const auto& n = nodes[at(i)];
    switch (n.operation) {
      case Operation::constant: {
        char number[32];
        std::snprintf(number, sizeof number, "%g", n.value);
        return number;
      }
      case Operation::q: return in_->numbers[at(n.a)];
      case Operation::p: return in_->constants[at(n.a)];
      case Operation::negative: return "-" + self(self, n.a);
      default: return "x" + std::to_string(i);
    }
  };
  std::string text;
  const auto line = [&](const std::string& to, const std::string& value) { text += "  " + to + " = " + value + '\n'; };
  const auto operations = [&](int begin, int end, Level level, const std::vector<Comment>& comments) {
    std::size_t next = 0;
    for (int i = begin; i < end; ++i) {
      const auto& n = nodes[at(i)];
      if (!needed[at(i)] || levels_[at(i)] != level || !binary(n.operation)) continue;
      std::size_t part = next;
      while (part < comments.size() && comments[part].before <= i) ++part;
      if (part > next) text += "  // " + comments[part - 1].text + '\n', next = part;
      const char* const sign = n.operation == Operation::sum          ? " + "
                               : n.operation == Operation::difference ? " - "
                               : n.operation == Operation::product    ? " * "
                                                                      : " / ";
      line("x" + std::to_string(i), operand(operand, n.a) + sign + operand(operand, n.b));
    }
  };
  const int all = static_cast<int>(nodes.size());
  const std::size_t before = text.size();
  operations(0, all, Level::link, {});
  if (text.size() > before) text.insert(before, "once for each link\n");
  int begin = 0;
  for (std::size_t pass = 0; pass < steps_.functions.size(); ++pass) {
    const Function& f = steps_.functions[pass];
    text += pass == inward() ? "inward\n"
            : passes() == 3  ? pass == 0 ? "outward, velocities\n" : "outward, accelerations\n"
                             : "outward\n";
    operations(begin, f.end, Level::state, f.comments);
    for (const auto* list : {&f.stores, &f.last})
      for (const Store& one : *list) line(one.to, operand(operand, one.node));
    begin = f.end;
  }
  return text;
}

}  // namespace momentree::derive

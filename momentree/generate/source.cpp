#include <momentree/generate/source.hpp>

#include <charconv>
#include <cmath>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/generate/comment.hpp>
#include <momentree/generate/sincos_text.hpp>

namespace momentree {

namespace {

using Node = Expressions::Node;

std::string number(double value) {
  if (std::isnan(value)) return "NAN";
  if (std::isinf(value)) return value > 0 ? "HUGE_VAL" : "-HUGE_VAL";
  char text[40];  // the shortest form that reads back to the same bits, independent of the locale
  std::string s(text, std::to_chars(text, text + sizeof text, value).ptr);
  if (s.find_first_of(".e") == std::string::npos) s += ".0";
  return s;
}

/// The statements of a kernel, in the order in which its recursions created them: related expressions are close together, so that
/// few values are live at a time.
class Writer {
 public:
  Writer(const KernelExpressions& kernel, std::string& text)
      : nodes_(kernel.expressions.nodes()), text_(text), y_(kernel.variables == Variables::momenta ? "p" : "u") {
    needed_.assign(nodes_.size(), false);
    angle_of_.assign(nodes_.size(), -1);
    results_.resize(nodes_.size());
    for (const int result : kernel.results()) needed_[at(result)] = true;
    for (std::size_t i = nodes_.size(); i-- > 0;) need_operands(nodes_[i], needed_[i]);
    collect("v", kernel.v), collect("qdot", kernel.qdot), collect("pdot", kernel.pdot), collect("udot", kernel.udot);
  }

  void write() {
    write_angles();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!needed_[i]) continue;
      const Node& node = nodes_[i];
      if (binary(node.operation))
        text_ += "  const double " + operand(static_cast<int>(i)) + " = " + operand(node.a) + symbol(node.operation) +
                 operand(node.b) + ";\n";
      if (!results_[i].empty()) text_ += "  " + results_[i] + operand(static_cast<int>(i)) + ";\n";
    }
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static bool trigonometric(Operation o) { return o == Operation::sine || o == Operation::cosine; }
  static const char* symbol(Operation operation) {
    switch (operation) {
      case Operation::sum: return " + ";
      case Operation::difference: return " - ";
      case Operation::product: return " * ";
      default: return " / ";
    }
  }
  static std::string element(const char* array, int i) { return array + ("[" + std::to_string(i) + "]"); }

  void need_operands(const Node& node, bool needed) {
    if (!needed || trigonometric(node.operation)) return;  // angles are written separately
    if (unary(node.operation) || binary(node.operation)) needed_[at(node.a)] = true;
    if (binary(node.operation)) needed_[at(node.b)] = true;
  }

  std::string operand(int i) const {
    const Node& node = nodes_[at(i)];
    switch (node.operation) {
      case Operation::constant: return number(node.value);
      case Operation::q: return element("q", node.a);
      case Operation::p: return element(y_, node.a);
      case Operation::tau: return element("tau", node.a);
      case Operation::sine: return element("s", angle_of_[at(node.a)]);
      case Operation::cosine: return element("c", angle_of_[at(node.a)]);
      case Operation::negative: return "-" + operand(node.a);
      default: return "x" + std::to_string(i);
    }
  }

  // All sines and cosines at once, as in the kernels: many angles vectorise.
  void write_angles() {
    std::vector<int> all;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!needed_[i] || !trigonometric(nodes_[i].operation) || angle_of_[at(nodes_[i].a)] >= 0) continue;
      angle_of_[at(nodes_[i].a)] = static_cast<int>(all.size());
      all.push_back(nodes_[i].a);
    }
    if (all.empty()) return;
    const std::string n = std::to_string(all.size());
    text_ += "  double angle[" + n + "], s[" + n + "], c[" + n + "];\n";
    for (std::size_t i = 0; i < all.size(); ++i)
      text_ += "  " + element("angle", static_cast<int>(i)) + " = " + angle(all[i], static_cast<int>(i)) + ";\n";
    text_ += "  sincos(" + n + ", angle, s, c);\n";
  }
  // An angle as a sum of coordinates and offsets, or of these and an angle with a number below `known`.
  std::string angle(int i, int known) const {
    const Node& node = nodes_[at(i)];
    if (angle_of_[at(i)] >= 0 && angle_of_[at(i)] < known) return element("angle", angle_of_[at(i)]);
    if (node.operation == Operation::negative) return "-(" + angle(node.a, known) + ")";
    if (!binary(node.operation)) return operand(i);
    return "(" + angle(node.a, known) + symbol(node.operation) + angle(node.b, known) + ")";
  }

  // Results are stored as soon as they are known; several with the same value in one statement.
  void collect(const char* array, const std::vector<int>& nodes) {
    for (std::size_t i = 0; i < nodes.size(); ++i) results_[at(nodes[i])] += element(array, static_cast<int>(i)) + " = ";
  }

  const std::vector<Node>& nodes_;
  std::string& text_;
  const char* const y_;  // the array of momenta or velocities
  std::vector<bool> needed_;
  std::vector<int> angle_of_;         // by node: its number among the angles, −1: none
  std::vector<std::string> results_;  // by node: the results that it is assigned to, "v[0] = qdot[0] = "
};

// The engine's sincos, without the parts that belong to a header.
std::string sincos_source() {
  const std::string_view text = momentree_sincos_text;
  std::string all;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    std::string line(text.substr(begin, end - begin));
    begin = end + 1;
    if (line.starts_with('#')) continue;
    const std::string_view own = "namespace momentree";
    if (const std::size_t place = line.find(own); place != std::string::npos) line.replace(place, own.size(), "namespace");
    all += line + '\n';
  }
  return all;
}

}  // namespace

std::string kernel_source(const KernelExpressions& kernel, const SourceText& how) {
  MT_REQUIRE(how.name == identifier(how.name), "a name that is an identifier: see identifier()");
  const Operations o = kernel.operations();
  const bool momenta = kernel.variables == Variables::momenta;
  const std::string nq = std::to_string(kernel.qdot.size()), nv = std::to_string(momenta ? kernel.v.size() : kernel.udot.size());
  std::string text = comment(how.about);
  text += comment("Generated by momentree: do not edit, generate it again. One evaluation takes " + std::to_string(o.additions) +
                  " additions, " + std::to_string(o.multiplications) + " multiplications,\n" + std::to_string(o.divisions) +
                  " divisions, and " + std::to_string(o.sincos) + " times a sine and a cosine. Fast with -O3 -march=native.\n");
  text += "#include <bit>\n#include <cmath>\n#include <cstdint>\n\n" + sincos_source() + '\n';
  text += "extern \"C\" {\n\nextern const int " + how.name + "_nq, " + how.name + "_nv;\n";
  text += "const int " + how.name + "_nq = " + nq + ";  // numbers of q and qdot\n";
  text += "const int " + how.name + "_nv = " + nv +
          (momenta ? ";  // numbers of p, v and pdot\n\n" : ";  // numbers of u, tau and udot\n\n");
  if (momenta) {
    text += comment(
        "Rates of a mechanism with coordinates q and canonical momenta p. In: q (nq numbers) and p (nv). Out: the velocities\n"
        "v (nv), which belong to these momenta, and the rates of q (nq) and of p (nv). SI units. Arrays must not overlap.\n");
    text += "void " + how.name +
            "_rates([[maybe_unused]] const double* q, [[maybe_unused]] const double* p, "
            "[[maybe_unused]] double* v,\n    [[maybe_unused]] double* qdot, [[maybe_unused]] double* pdot) noexcept {\n";
  } else {
    text += comment(
        "Accelerations of a mechanism with coordinates q and velocities u. In: q (nq numbers), u (nv) and further joint forces\n"
        "tau (nv). Out: the rates of q (nq) and of u (nv). SI units. Arrays must not overlap.\n");
    text += "void " + how.name +
            "_accelerations([[maybe_unused]] const double* q, [[maybe_unused]] const double* u, [[maybe_unused]] const double* "
            "tau,\n    [[maybe_unused]] double* qdot, [[maybe_unused]] double* udot) noexcept {\n";
  }
  Writer(kernel, text).write();
  return text + "}\n\n}  // extern \"C\"\n";
}

std::string identifier(std::string_view name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string id;
  for (const char c : name) id += letter(c) || digit(c) ? c : '_';
  if (id.empty() || !letter(id[0])) id.insert(0, "k");
  return id;
}

}  // namespace momentree

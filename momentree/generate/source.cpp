#include <momentree/generate/source.hpp>

#include <charconv>
#include <cmath>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/generate/comment.hpp>
#include <momentree/generate/kernel_texts.hpp>

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
      : expressions_(kernel.expressions),
        nodes_(kernel.expressions.nodes()),
        text_(text),
        y_(kernel.variables == Variables::momenta ? "p" : "u") {
    needed_.assign(nodes_.size(), false);
    angle_of_.assign(nodes_.size(), -1);
    results_.resize(nodes_.size());
    for (const int result : kernel.results()) needed_[at(result)] = true;
    for (std::size_t i = nodes_.size(); i-- > 0;) need_operands(nodes_[i], needed_[i]);
    collect("v", kernel.v), collect("qdot", kernel.qdot), collect("pdot", kernel.pdot), collect("udot", kernel.udot);
    collect("calls->lambda", kernel.lambda), collect("calls->effort", kernel.effort);
  }

  void write() {
    write_angles();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!needed_[i]) continue;
      const Node& node = nodes_[i];
      if (node.operation == Operation::answer) write_call(expressions_.call_of(node.a));
      if (node.operation == Operation::inverse_pivot)
        text_ += "  const double " + operand(static_cast<int>(i)) + " = inverse_pivot(" + operand(node.a) + ", least_pivots[" +
                 std::to_string(node.b) + "]);\n";
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
    if (node.operation == Operation::answer)
      for (const int argument : expressions_.calls()[at(expressions_.call_of(node.a))].arguments) needed_[at(argument)] = true;
  }

  void write_call(int number) {
    if (number < called_) return;  // for another of its answers
    called_ = number + 1;
    const Expressions::Call& call = expressions_.calls()[at(number)];
    const std::string n = std::to_string(number);
    text_ += "  double y" + n + "[" + std::to_string(call.answers) + "];\n  {\n    ";
    text_ += call.loop < 0 ? "double A[] = {" : "const double place[] = {";
    for (std::size_t i = 0; i < call.arguments.size(); ++i)
      text_ += (i == 0 ? "" : i % 10 == 0 ? ",\n        " : ", ") + operand(call.arguments[i]);
    text_ += "};\n    ";
    if (call.loop < 0)
      text_ += "solve_rows(" + std::to_string(call.answers) + ", begin, row, least_pivots, A, A + " +
               std::to_string(call.arguments.size() - at(call.answers)) + ", y" + n + ");\n  }\n";
    else
      text_ += "calls->joint(calls, " + std::to_string(call.loop) + ", place, " + std::to_string(call.answers) + ", y" + n +
               ");\n  }\n";
  }

  std::string operand(int i) const {
    const Node& node = nodes_[at(i)];
    switch (node.operation) {
      case Operation::constant: return number(node.value);
      case Operation::q: return element("q", node.a);
      case Operation::p: return element(y_, node.a);
      case Operation::tau: return element("tau", node.a);
      case Operation::answer: {
        const int call = expressions_.call_of(node.a);
        return element(("y" + std::to_string(call)).c_str(), node.a - expressions_.calls()[at(call)].first_answer);
      }
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

  const Expressions& expressions_;
  const std::vector<Node>& nodes_;
  std::string& text_;
  int called_ = 0;       // calls written so far
  const char* const y_;  // the array of momenta or velocities
  std::vector<bool> needed_;
  std::vector<int> angle_of_;         // by node: its number among the angles, −1: none
  std::vector<std::string> results_;  // by node: the results that it is assigned to, "v[0] = qdot[0] = "
};

template <class T, class F>
std::string list(const std::vector<T>& all, const F& as_text) {
  std::string text;
  for (std::size_t i = 0; i < all.size(); ++i) text += (i == 0 ? "" : i % 20 == 0 ? ",\n    " : ", ") + as_text(all[i]);
  return text;
}

// The text of a header for the generated file: without its includes, and with an unnamed namespace.
std::string source_of(std::string_view text) {
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

// What the code of closed loops uses.
std::string loops_source(const KernelExpressions& kernel) {
  std::string text;
  if (kernel.loops) {
    text += comment("What the caller of code with closed loops gives it: see momentree/dynamics/steps/rates_function.hpp.");
    text +=
        "struct LoopCalls {\n  const double* least_pivots;\n  double *lambda, *effort;\n"
        "  void (*joint)(const LoopCalls*, int loop, const double* place, int answers, double* answer) noexcept;\n};\n\n";
  }
  text += source_of(momentree_solve_rows_text) + "\nnamespace {\n\n";
  if (!kernel.loops) text += "const double least_pivots[] = {" + list(kernel.least_pivots, number) + "};\n";
  bool called = false;
  for (const Expressions::Call& call : kernel.expressions.calls()) called = called || call.loop < 0;
  if (called) {
    const auto integer = [](int i) { return std::to_string(i); };
    text += "const int begin[] = {" + list(kernel.begin, integer) + "};\n";
    text += "const int row[] = {" + list(kernel.rows(), integer) + "};\n";
  }
  return text + "\n}  // namespace\n\n";
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
  text += "#include <bit>\n#include <cmath>\n#include <cstdint>\n\n" + source_of(momentree_sincos_text) + '\n';
  const bool rows = kernel.loops || !kernel.begin.empty();
  if (rows) text += loops_source(kernel);
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
            "tau,\n    " +
            (kernel.loops ? "[[maybe_unused]] const LoopCalls* calls, " : "") +
            "[[maybe_unused]] double* qdot, [[maybe_unused]] double* udot) noexcept {\n";
    if (kernel.loops) text += "  [[maybe_unused]] const double* const least_pivots = calls->least_pivots;\n";
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

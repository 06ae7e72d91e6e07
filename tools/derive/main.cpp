// Writes the steps of joints that are derived from the kinds' own functions: momentree/joint/derived/KIND.hpp.
//   momentree-derive FOLDER          writes them
//   momentree-derive FOLDER --check  fails if one of them differs
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <momentree/joint/kinds.hpp>
#include <tools/derive/writer.hpp>

namespace {

using namespace momentree;
using namespace momentree::derive;

template <class Kind>
std::string step(const Traits& traits, bool aligned, bool leaf) {
  using K = typename Kind::Kernels;
  Recorder in;
  const Derived steps = Text<K, Kind::info.nq, Kind::info.nv>(traits, aligned, leaf, in).run();
  Writer writer(in, steps);
  const auto word = [](bool yes) { return yes ? "true" : "false"; };
  std::string s = std::string("/// ") + (K::rotates_about_z && aligned ? "Link with β = 0, " : "") +
                  (leaf ? "body without children.\n" : "body with children.\n");
  s += "template <>\nstruct DerivedSteps<" + traits.kernels + ", " + word(aligned) + ", " + word(leaf) + "> {\n";
  s += "  template <class T>\n  using Record = DerivedRecord<T, " + std::to_string(steps.record.size()) + ">;\n";
  s += "  template <class T>\n  MOMENTREE_INLINE static void inboard([[maybe_unused]] const LinkConstants& k,\n"
       "                                       [[maybe_unused]] double mass, bool gravity, bool root,\n"
       "                                       [[maybe_unused]] const JointState<T>& j,\n"
       "                                       const T* p, Inboard<T>& a, Record<T>& w) {\n";
  s += writer.inboard() + "  }\n";
  s += "  template <class T>\n  MOMENTREE_INLINE static void outboard([[maybe_unused]] const LinkConstants& k, [[maybe_unused]] double mass,\n"
       "                                        [[maybe_unused]] const JointState<T>& j,\n"
       "                                        [[maybe_unused]] const T* p, const Record<T>& w, Outboard<T>& out, T* u,\n"
       "                                        T* pdot, T* qdot) {\n";
  return s + writer.outboard() + "  }\n};\n";
}

template <class Kind>
std::string header(const Traits& traits) {
  std::string s =
      "#pragma once\n// Steps of a " + traits.name +
      " joint. Written by momentree-derive from the functions of the kind: do not edit, write it again.\n"
      "// clang-format off\n#include <momentree/joint/derived_steps.hpp>\n\nnamespace momentree {\n\nstruct " + traits.kernels +
      ";\ntemplate <>\ninline constexpr bool has_derived_steps<" + traits.kernels + "> = true;\n\n";
  for (const bool aligned : {false, true})
    for (const bool leaf : {false, true})
      if (!aligned || Kind::Kernels::rotates_about_z) s += step<Kind>(traits, aligned, leaf) + '\n';
  return s + "}  // namespace momentree\n";
}

}  // namespace

int main(int arguments, char** words) {
  if (arguments < 2 || (arguments == 3 && std::string(words[2]) != "--check") || arguments > 3)
    return std::fprintf(stderr, "usage: %s FOLDER [--check]\n", words[0]), 2;
  const std::filesystem::path folder = words[1];
  // The list of the kinds with derived steps.
  const std::pair<std::string, std::string> files[] = {
      {"ball", header<Ball>({"ball", "BallKernels"})},
      {"cylindrical", header<Cylindrical>({"cylindrical", "CylindricalKernels"})},
      {"free", header<Free>({"free", "FreeKernels"})},
      {"helical", header<Helical>({"helical", "HelicalKernels"})},
      {"planar", header<Planar>({"planar", "PlanarKernels", 0, 2})},
      {"universal", header<Universal>({"universal", "UniversalKernels", 1, 1})},
  };
  int differ = 0;
  for (const auto& [name, text] : files) {
    const std::filesystem::path file = folder / (name + ".hpp");
    if (arguments == 2) {
      if (!(std::ofstream(file, std::ios::binary) << text)) return std::fprintf(stderr, "%s: cannot be written\n", file.c_str()), 1;
      continue;
    }
    std::ifstream in(file, std::ios::binary);
    const std::string now{std::istreambuf_iterator<char>(in), {}};
    if (now != text)
      ++differ, std::fprintf(stderr, "%s:1:1: error: is not what tools/derive writes: run ./dev derive\n", file.c_str());
  }
  return differ == 0 ? 0 : 1;
}

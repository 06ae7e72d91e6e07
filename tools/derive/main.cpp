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

struct Written {
  std::string record, inboard, outboard;
  int operations = 0;
};

template <class Kind>
Written write(const Traits& traits, LinkRotation rotation, Place place, const Order& order) {
  Recorder in;
  const Derived steps = Text<typename Kind::Kernels, Kind::info.nq, Kind::info.nv>(traits, rotation, place, order, in).run();
  Writer writer(in, steps);
  Written written{std::to_string(steps.record.size()), writer.inboard(), writer.outboard(), 0};
  written.operations = writer.operations();
  return written;
}

/// In the order with the fewest operations.
template <class Kind>
Written best(const Traits& traits, LinkRotation rotation, Place place) {
  Written least = write<Kind>(traits, rotation, place, {});
  if (!Kind::Kernels::rotates_about_z) return least;
  for (const Order::Frame frame : {Order::child, Order::before_rotation, Order::before_displacement})
    for (const bool one_shift : {false, true})
      if (!one_shift || frame != Order::before_displacement) {
        Written other = write<Kind>(traits, rotation, place, {frame, one_shift});
        if (other.operations < least.operations) least = std::move(other);
      }
  return least;
}

template <class Kind>
std::string step(const Traits& traits, LinkRotation rotation, Place place) {
  static const char* const rotations[] = {"any", "tilted", "about_z", "none"};
  static const char* const places[] = {"inner", "leaf", "root", "single"};
  const Written written = best<Kind>(traits, rotation, place);
  std::string s = "/// " + std::to_string(written.operations) + " operations.\ntemplate <>\nstruct DerivedSteps<" +
                  traits.kernels + ", LinkRotation::" + rotations[static_cast<int>(rotation)] +
                  ", Place::" + places[static_cast<int>(place)] + "> {\n";
  s += std::string("  static constexpr Place place = Place::") + places[static_cast<int>(place)] +
       ";\n  template <class T>\n  using Record = DerivedRecord<T, " + written.record + ">;\n";
  s += "  template <bool Add, class T>\n  MOMENTREE_INLINE static void inboard([[maybe_unused]] const LinkConstants& k,\n"
       "                                       [[maybe_unused]] double mass, bool gravity,\n"
       "                                       [[maybe_unused]] const JointState<T>& j, const T* p,\n"
       "                                       [[maybe_unused]] const Inboard<T>& a, Record<T>& w,\n"
       "                                       [[maybe_unused]] Inboard<T>& to) {\n";
  s += written.inboard + "  }\n";
  s += "  template <class T>\n  MOMENTREE_INLINE static void outboard([[maybe_unused]] const LinkConstants& k, [[maybe_unused]] "
       "double mass,\n"
       "                                        [[maybe_unused]] const JointState<T>& j,\n"
       "                                        [[maybe_unused]] const T* p, const Record<T>& w, Outboard<T>& out, T* u,\n"
       "                                        T* pdot, T* qdot) {\n";
  return s + written.outboard + "  }\n};\n";
}

template <class Kind>
std::string header(const Traits& traits) {
  unsigned bits = 0;
  for (const LinkRotation rotation : traits.rotations) bits |= 1u << static_cast<unsigned>(rotation);
  std::string s = "#pragma once\n// Steps of a " + traits.name +
                  " joint. Written by momentree-derive from the functions of the kind: do not edit, run ./dev derive.\n"
                  "// clang-format off\n#include <momentree/joint/derived_steps.hpp>\n\nnamespace momentree {\n\nstruct " +
                  traits.kernels + ";\ntemplate <>\ninline constexpr unsigned derived_rotations<" + traits.kernels +
                  "> = " + std::to_string(bits) + ";\n\n";
  for (const LinkRotation rotation : traits.rotations)
    for (const Place place : {Place::inner, Place::leaf}) s += step<Kind>(traits, rotation, place) + '\n';
  for (const Place place : {Place::root, Place::single}) s += step<Kind>(traits, LinkRotation::any, place) + '\n';
  return s + "}  // namespace momentree\n";
}

}  // namespace

int main(int arguments, char** words) {
  if (arguments < 2 || (arguments == 3 && std::string(words[2]) != "--check") || arguments > 3)
    return std::fprintf(stderr, "usage: %s FOLDER [--check]\n", words[0]), 2;
  const std::filesystem::path folder = words[1];
  using enum LinkRotation;
  // The list of the kinds with derived steps, and of the rotations of links that have their own.
  const std::pair<std::string, std::string> files[] = {
      {"ball", header<Ball>({"ball", "BallKernels", {any, none}})},
      {"cylindrical", header<Cylindrical>({"cylindrical", "CylindricalKernels", {any, tilted, about_z}})},
      {"free", header<Free>({"free", "FreeKernels", {any, none}})},
      {"helical", header<Helical>({"helical", "HelicalKernels", {any, tilted, about_z}})},
      {"planar", header<Planar>({"planar", "PlanarKernels", {any, about_z}, 0, 2})},
      {"prismatic", header<Prismatic>({"prismatic", "PrismaticKernels", {any, tilted, about_z}})},
      {"universal", header<Universal>({"universal", "UniversalKernels", {any, none}, 1, 1})},
  };
  int differ = 0;
  for (const auto& [name, text] : files) {
    const std::filesystem::path file = folder / (name + ".hpp");
    if (arguments == 2) {
      if (!(std::ofstream(file, std::ios::binary) << text))
        return std::fprintf(stderr, "%s: cannot be written\n", file.c_str()), 1;
      continue;
    }
    std::ifstream in(file, std::ios::binary);
    const std::string now{std::istreambuf_iterator<char>(in), {}};
    if (now != text)
      ++differ, std::fprintf(stderr, "%s:1:1: error: is not what tools/derive writes: run ./dev derive\n", file.c_str());
  }
  return differ == 0 ? 0 : 1;
}

// Writes the steps of joints that are derived from the kinds' own functions: KIND.hpp in derived/, for momenta, and in
// derived_velocity/.
//   momentree-derive FOLDER          writes them into folders of momentree/joint
//   momentree-derive FOLDER --check  fails if one of them differs
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <momentree/derive/momentum_steps.hpp>
#include <momentree/derive/velocity_steps.hpp>
#include <momentree/joint/kinds.hpp>
#include <tools/derive/writer.hpp>

namespace {

using namespace momentree;
using namespace momentree::derive;

/// What differs between steps in momenta and in velocities: their names and the signatures of their functions.
struct Signatures {
  const char *steps, *forms, *record;
  std::vector<const char*> functions;
};
const Signatures momentum_signatures{
    "DerivedSteps",
    "momentum_forms",
    "DerivedRecord",
    {"  template <bool Add, class T>\n  MOMENTREE_INLINE static void inboard([[maybe_unused]] const LinkConstants& k,\n"
     "                                       [[maybe_unused]] double mass, bool gravity,\n"
     "                                       [[maybe_unused]] const JointState<T>& j, const T* p,\n"
     "                                       [[maybe_unused]] const Inboard<T>& a, Record<T>& w,\n"
     "                                       [[maybe_unused]] Inboard<T>& to) {\n",
     "  template <class T>\n  MOMENTREE_INLINE static void outboard([[maybe_unused]] const LinkConstants& k, [[maybe_unused]] "
     "double mass,\n"
     "                                        [[maybe_unused]] const JointState<T>& j,\n"
     "                                        [[maybe_unused]] const T* p, const Record<T>& w, Outboard<T>& out, T* u,\n"
     "                                        T* pdot, T* qdot) {\n"}};
const Signatures velocity_signatures{
    "DerivedVelocitySteps",
    "velocity_forms",
    "DerivedVelocityRecord",
    {"  template <class T>\n  MOMENTREE_INLINE static void velocities([[maybe_unused]] const LinkConstants& k,\n"
     "                                          [[maybe_unused]] const JointState<T>& j, [[maybe_unused]] const T* u,\n"
     "                                          [[maybe_unused]] Record<T>& w,\n"
     "                                          [[maybe_unused]] Motion<T>& velocity, T* qdot) {\n",
     "  template <bool Add, class T>\n  MOMENTREE_INLINE static void inboard([[maybe_unused]] const LinkConstants& k,\n"
     "                                       [[maybe_unused]] double armature,\n"
     "                                       [[maybe_unused]] const JointState<T>& j, const T* tau,\n"
     "                                       [[maybe_unused]] const Inboard<T>& a, Record<T>& w,\n"
     "                                       [[maybe_unused]] Inboard<T>& to) {\n",
     "  template <class T>\n  MOMENTREE_INLINE static void outboard([[maybe_unused]] const LinkConstants& k,\n"
     "                                        [[maybe_unused]] const JointState<T>& j, const Record<T>& w, Motion<T>& a,\n"
     "                                        T* udot) {\n"}};

struct Written {
  std::string text;
  int operations = 0;
};

template <class Text>
Written write(const Signatures& names, const Traits& traits, const Form& form, BodyPlace place, const Order& order) {
  Recorder in;
  const Derived steps = Text(traits, form, place, order, in).run();
  Writer writer(in, steps);
  Written written{std::string("  template <class T>\n  using Record = ") + names.record + "<T, " +
                      std::to_string(steps.record.size()) + ">;\n",
                  0};
  for (std::size_t i = 0; i < names.functions.size(); ++i) written.text += names.functions[i] + writer.function(i) + "  }\n";
  written.operations = writer.operations();
  return written;
}

template <class Kind, bool Velocities>
using TextOf = std::conditional_t<Velocities, VelocitySteps<typename Kind::Kernels, Kind::info.nq, Kind::info.nv>,
                                  MomentumSteps<typename Kind::Kernels, Kind::info.nq, Kind::info.nv>>;

/// Momenta: in the order with the fewest operations. Velocities: in that which takes the least time for a single world; see
/// docs/adr/0020-derived-steps.md.
template <class Kind, bool Velocities>
Written best(const Signatures& names, const Traits& traits, const Form& form, BodyPlace place) {
  using Text = TextOf<Kind, Velocities>;
  constexpr Order::Frame frames[] = {Order::child, Order::before_rotation, Order::before_displacement};
  Written least;
  for (const Order::Frame frame : frames)
    for (const bool one_shift : {false, true}) {
      if (!Kind::Kernels::rotates_about_z ? frame != Order::child || one_shift : frame == Order::before_displacement && one_shift)
        continue;
      if (Velocities && Kind::Kernels::rotates_about_z && frame != traits.frame_in_velocities) continue;
      Written other = write<Text>(names, traits, form, place, {frame, one_shift});
      if (least.text.empty() || other.operations < least.operations) least = std::move(other);
    }
  return least;
}

std::string name_of(const Form& form) {
  static const char* const rotations[] = {"any", "tilted", "about_z", "none"};
  static const char* const shapes[] = {"general", "tilted",  "screw",         "screw_a",  "screw_d",   "right",
                                       "right_a", "right_d", "right_meeting", "parallel", "parallel_a"};
  return form.shape ? std::string("PlacementShape::") + shapes[static_cast<int>(*form.shape)]
                    : std::string("LinkRotation::") + rotations[static_cast<int>(form.rotation)];
}

template <class Kind, bool Velocities>
std::string step(const Signatures& names, const Traits& traits, const Form& form, BodyPlace place) {
  static const char* const places[] = {"inner", "leaf", "root", "single"};
  const Written written = best<Kind, Velocities>(names, traits, form, place);
  return "/// " + std::to_string(written.operations) + " operations.\ntemplate <>\nstruct " + names.steps + "<" + traits.kernels +
         ", " + name_of(form) + ", BodyPlace::" + places[static_cast<int>(place)] +
         "> {\n  static constexpr BodyPlace place = BodyPlace::" + places[static_cast<int>(place)] + ";\n" + written.text +
         "};\n";
}

template <class Kind, bool Velocities>
std::string steps(const Traits& traits) {
  const Signatures& names = Velocities ? velocity_signatures : momentum_signatures;
  unsigned rotations = 0, shapes = 0;
  for (const Form& form : traits.forms) {
    if (form.shape)
      shapes |= 1u << static_cast<unsigned>(*form.shape);
    else
      rotations |= 1u << static_cast<unsigned>(form.rotation);
  }
  std::string s = std::string("template <>\ninline constexpr DerivedForms ") + names.forms + "<" + traits.kernels + ">{" +
                  std::to_string(rotations) + ", " + std::to_string(shapes) + "};\n\n";
  for (const Form& form : traits.forms)
    for (const BodyPlace place : {BodyPlace::inner, BodyPlace::leaf})
      s += step<Kind, Velocities>(names, traits, form, place) + '\n';
  for (const BodyPlace place : {BodyPlace::root, BodyPlace::single})
    s += step<Kind, Velocities>(names, traits, traits.forms.front(), place) + '\n';
  return s;
}

std::string file(const Traits& traits, const std::string& steps) {
  const std::string declaration = traits.shared_kernels ? "" : "struct " + traits.kernels + ";\n";
  return "#pragma once\n// Steps of a " + traits.name +
         " joint. Written by momentree-derive from the functions of the kind: do not edit, run ./dev derive.\n"
         "// clang-format off\n#include <momentree/joint/derived_steps.hpp>\n" +
         (traits.shared_kernels ? "#include <momentree/joint/kinds/" + traits.name + ".hpp>\n" : "") +
         "\nnamespace momentree {\n\n" + declaration + steps + "}  // namespace momentree\n";
}

using Files = std::vector<std::pair<std::string, std::string>>;

template <class Kind>
void add(Files& files, const Traits& traits) {
  files.emplace_back("derived/" + traits.name, file(traits, steps<Kind, false>(traits)));
  files.emplace_back("derived_velocity/" + traits.name, file(traits, steps<Kind, true>(traits)));
}

/// Revolute joints, with and without armature, by the shape of the link.
void add_revolute(Files& files) {
  using enum PlacementShape;
  const auto of = [](std::initializer_list<PlacementShape> shapes) {
    std::vector<Form> forms;
    for (const PlacementShape shape : shapes)
      forms.push_back({shape == general    ? LinkRotation::any
                       : shape >= parallel ? LinkRotation::about_z
                                           : LinkRotation::tilted,
                       shape});
    return forms;
  };
  Traits plain{"revolute", "RevoluteKernels",
               of({general, tilted, screw, screw_a, screw_d, right, right_a, right_d, right_meeting, parallel, parallel_a})};
  Traits with_armature{"revolute", "ArmatureKernels", of({general, screw, right})};
  plain.frame_in_velocities = with_armature.frame_in_velocities = Order::before_displacement;
  plain.shared_kernels = with_armature.shared_kernels = with_armature.armature = true;
  files.emplace_back("derived_velocity/revolute",
                     file(plain, steps<Revolute, true>(plain) + steps<Revolute, true>(with_armature)));
}

}  // namespace

int main(int arguments, char** words) {
  if (arguments < 2 || (arguments == 3 && std::string(words[2]) != "--check") || arguments > 3)
    return std::fprintf(stderr, "usage: %s FOLDER [--check]\n", words[0]), 2;
  const std::filesystem::path folder = words[1];
  using enum LinkRotation;
  // The list of the kinds with derived steps, and of the rotations of links that have their own.
  Files files;
  add<Ball>(files, {"ball", "BallKernels", {{any}, {none}}});
  add<Cylindrical>(files, {"cylindrical", "CylindricalKernels", {{any}, {tilted}, {about_z}}});
  add<Free>(files, {"free", "FreeKernels", {{any}, {none}}});
  add<Helical>(files, {"helical", "HelicalKernels", {{any}, {tilted}, {about_z}}});
  add<Planar>(files, {"planar", "PlanarKernels", {{any}, {about_z}}, 0, 2});
  add<Prismatic>(files, {"prismatic", "PrismaticKernels", {{any}, {tilted}, {about_z}}});
  add<Universal>(files, {"universal", "UniversalKernels", {{any}, {none}}, 1, 1});
  add_revolute(files);
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

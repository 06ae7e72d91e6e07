// The form of a model that its trees share.
#include <momentree/tree/declared.hpp>

#include <bit>
#include <cstdint>
#include <functional>

#include <momentree/model/model.hpp>
#include <momentree/tree/kernel_run.hpp>

namespace momentree::detail {

namespace {

std::uint64_t pair(int high, int low) {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(high)) << 32 | static_cast<std::uint32_t>(low);
}

// Numbers as their bits: values are equal only if nothing computed from them could differ.
template <std::size_t N>
class Words {
 public:
  Words& operator()(double x) { return (*this)(std::bit_cast<std::uint64_t>(x)); }
  Words& operator()(std::uint64_t x) {
    MT_REQUIRE(count_ < N, "as many words as there is room for");
    words_[count_++] = x;
    return *this;
  }
  Words& operator()(const Vec3& a) { return (*this)(a.x)(a.y)(a.z); }
  Words& operator()(const Sym3& a) { return (*this)(a.xx)(a.yy)(a.zz)(a.xy)(a.xz)(a.yz); }
  Words& operator()(const Pose& a) { return (*this)(a.position)(a.rotation.w)(a.rotation.x)(a.rotation.y)(a.rotation.z); }
  Words& operator()(const Mat3& a) { return (*this)(a.xx)(a.xy)(a.xz)(a.yx)(a.yy)(a.yz)(a.zx)(a.zy)(a.zz); }
  Words& operator()(bool x) { return (*this)(std::uint64_t{x}); }
  Words& operator()(const std::optional<double>& x) { return (*this)(x.value_or(0)); }
  Words& operator()(JointId joint) { return (*this)(pair(joint.index, 0)); }
  Words& operator()(const SpringEnd& end) { return (*this)(pair(end.body.index, 0))(end.point); }
  /// A member of a described type.
  Words& operator()(const char*, const auto& member, const Field&) {
    if constexpr (!Like<std::decay_t<decltype(member)>, std::string>) (*this)(member);
    return *this;
  }
  const std::array<std::uint64_t, N>& all() const { return words_; }

 private:
  std::array<std::uint64_t, N> words_{};
  std::size_t count_ = 0;
};

auto words(const Joint& j) {
  return Words<24>()(j.at)(j.child_at)(j.axis)(j.axis2)(j.pitch)(pair(static_cast<int>(j.kind), j.parameters))(
             pair(static_cast<int>(j.locked), j.function))(std::uint64_t{j.created_by_event})
      .all();
}
auto words(const MassProperties& m) { return Words<10>()(m.mass)(m.com)(m.inertia).all(); }

auto words(const LinkConstants& k, const KernelFrame& frame) {
  return Words<39>()(k.cos_a)(k.sin_a)(k.cs_a)(k.ss_a)(k.r)(k.d)(k.cos_b)(k.sin_b)(k.body.m)(k.body.mc)(k.body.J)(
             pair(static_cast<int>(k.shape), k.locked << 8 | k.driven))(k.cos_0)(k.sin_0)(k.angle_0)(k.geometry[0])(
             k.geometry[1])(k.geometry[2])(frame.R)(frame.r)
      .all();
}

// Equal parameters have equal words; different ones rarely do.
auto words(const JointParameters& p) {
  Words<14> some;
  for (const Values* v : {&p.damping, &p.stiffness, &p.rest, &p.armature, &p.effort, &p.limits.lower})
    some(static_cast<std::uint64_t>(v->size()))(v->of(0) + 0.0);  // −0 equals 0
  return some(p.limits.upper.of(0) + 0.0)(p.friction.coulomb.of(0) + 0.0).all();
}

auto words(const Spring& s) {
  Words<24> some;
  describe(some, s);
  return some(std::uint64_t{s.inextensible})(s.restitution).all();
}

auto words(const Coupling& c) {
  return Words<6>()(pair(c.joint.index, c.follows.index))(c.multiplier)(c.offset)(c.higher[0])(c.higher[1])(c.higher[2]).all();
}

// FNV-1a over whole words.
struct Fingerprint {
  std::uint64_t value = 14695981039346656037u;
  void add(std::uint64_t word) { value = (value ^ word) * 1099511628211u; }
  void add(const auto& words) requires requires { words.begin(); }
  {
    for (const std::uint64_t word : words) add(word);
  }
};

auto words(const JointElement& element) {
  Words<24> some;
  some(std::uint64_t{element.index()});
  with_kind(element, [&some](const auto& kind) { describe(some, kind); });
  return some.all();
}

std::uint64_t fingerprint_of(const Declared& d, const std::vector<JointElement>& elements) {
  Fingerprint all;
  for (const Declared::Body& b : d.bodies) all.add(pair(b.parent, b.joint)), all.add(static_cast<std::uint64_t>(b.mass));
  for (const Joint& joint : d.joints) all.add(words(joint));
  for (const MassProperties& mass : d.masses) all.add(words(mass));
  for (const JointParameters& p : d.parameters) all.add(words(p));
  for (const Spring& s : d.springs) all.add(words(s));
  for (const Coupling& c : d.couplings) all.add(words(c));
  for (const JointElement& element : elements) all.add(words(element));
  return all.value;
}

// Releases excess capacity.
template <class T>
bool shrink(std::vector<T>& list) {
  if (2 * list.size() >= list.capacity()) return false;
  list.shrink_to_fit();
  return true;
}

// Index of a value in a list of distinct values; appends it if it is new.
template <class T, class Same>
int number_in(std::vector<T>& list, Distinct& numbers, const T& value, const Same& same) {
  return numbers.number(
      words(value), [&](std::size_t i) { return same(list[i], value); }, [&] { list.push_back(value); });
}

}  // namespace

DofParameters spread(const JointParameters& parameters) {
  DofParameters f;
  for (std::size_t i = 0; i < 6; ++i) {
    const int dof = static_cast<int>(i);
    f.armature[i] = parameters.armature.of(dof);
    f.damping[i] = parameters.damping.of(dof);
    f.effort[i] = parameters.effort.of(dof);
  }
  f.has_armature = parameters.armature.any();
  f.spring = parameters.stiffness.any();
  f.force = parameters.damping.any() || parameters.effort.any();
  const JointDrive* drive = parameters.drive.get();
  f.motion = drive != nullptr && drive->moves();
  f.drive = parameters.friction.any() || parameters.limits.soft() || (drive != nullptr && !f.motion);
  f.strength = parameters.strength.any();
  return f;
}

std::shared_ptr<Declared> declare(const Model& model) {
  const auto same_words = [](const auto& a, const auto& b) { return words(a) == words(b); };
  auto declared = std::make_shared<Declared>();
  Declared& d = *declared;
  d.forces = model.forces();
  d.springs = model.springs();
  d.couplings = model.couplings();
  d.bodies.resize(static_cast<std::size_t>(model.size()));
  d.joints.reserve(d.bodies.size()), d.masses.reserve(d.bodies.size());
  Distinct joints, masses, parameters;
  for (std::size_t b = 0; b < d.bodies.size(); ++b) {
    const BodySpec& s = model.bodies()[b];
    Joint joint = joint_of(s);
    if (s.joint.parameters.any()) joint.parameters = number_in(d.parameters, parameters, s.joint.parameters, std::equal_to<>());
    d.bodies[b] = {s.parent.index, -1, number_in(d.joints, joints, joint, same_words),
                   number_in(d.masses, masses, {s.mass, s.com, s.inertia}, same_words), -1};
  }
  shrink(d.joints), shrink(d.masses);
  d.dofs.reserve(d.parameters.size());
  for (const JointParameters& p : d.parameters) d.dofs.push_back(spread(p));
  d.fingerprint = fingerprint_of(d, model.elements());
  return declared;
}

Joint joint_of(const BodySpec& s) {
  return {s.joint.kind, -1, s.at, s.child_at, s.joint.axis, s.joint.axis2, s.joint.pitch, 0, false, -1};
}

Joint joint_of(const LoopSpec& s) {
  return {s.joint.kind, -1, s.at, s.child_at, s.joint.axis, s.joint.axis2, s.joint.pitch, 0, false, -1};
}

LinkCollector::LinkCollector(Declared& declared) : declared_(declared) {
  declared.links.links.reserve(declared.bodies.size());
  declared.links.frames.reserve(declared.bodies.size());
}

int LinkCollector::take(int body, int first_child, const LinkConstants& link, const KernelFrame& frame) {
  SharedLinks& list = declared_.links;
  const auto own = words(link, frame);
  const int number = numbers_.number(
      own, [&](std::size_t i) { return words(list.links[i], list.frames[i]) == own; },
      [&] { list.links.push_back(link), list.frames.push_back(frame); });
  Declared::Body& entry = declared_.bodies[static_cast<std::size_t>(body)];
  entry.first_child = first_child, entry.link = number;
  return number;
}

bool LinkCollector::finish() {
  SharedLinks& list = declared_.links;
  const bool fewer_links = shrink(list.links), fewer_frames = shrink(list.frames);
  return fewer_links || fewer_frames;
}

}  // namespace momentree::detail

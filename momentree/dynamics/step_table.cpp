#include <momentree/dynamics/step_table.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

#ifndef __wasm__
#include <momentree/dynamics/step_library.hpp>
#endif
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

namespace {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr std::size_t sum_size = sizeof(Inboard<double>) / sizeof(double);
/// Of what bodies hand to their children; and where the vector that roots are given begins there.
constexpr std::size_t motion_size(bool momenta) {
  return (momenta ? sizeof(Outboard<double>) : sizeof(Motion<double>)) / sizeof(double);
}
constexpr std::size_t base_place(bool momenta) { return momenta ? offsetof(Outboard<double>, gravity) / sizeof(double) : 0; }
/// With more different steps, their code would not stay in the instruction cache: those that serve any link are then faster.
constexpr std::size_t most_steps = 40;

derive::BodyPlace place_of_body(bool leaf, bool root) {
  return leaf   ? root ? derive::BodyPlace::single : derive::BodyPlace::leaf
         : root ? derive::BodyPlace::root
                : derive::BodyPlace::inner;
}

}  // namespace

StepTable::StepTable(const StepScalar& scalar) : scalar_(scalar), links_(scalar) {}

std::unique_ptr<StepTable, void (*)(StepTable*)> detail::make_step_table(const StepScalar& scalar) {
  return {new StepTable(scalar), [](StepTable* table) { delete table; }};
}

void StepTable::velocities(const StepArrays& arrays) const noexcept { run(velocities_, arrays); }

void StepTable::inboard(const StepArrays& arrays) const noexcept { run(inboard_, arrays); }

void StepTable::outboard(const StepArrays& arrays, const void* base) const noexcept {
  const std::size_t size = motion_size(scalar_.momenta), place = base_place(scalar_.momenta);
  for (const int root : roots_)
    std::memcpy(static_cast<char*>(arrays.motions) + scalar_.size * (size * at(root) + place), base, 3 * scalar_.size);
  run(outboard_, arrays);
}

void StepTable::prepare(void* records, std::uint64_t& made_for) const noexcept {
  if (std::exchange(made_for, version_) == version_) return;
  for (const Mass& one : masses_) scalar_.put(static_cast<char*>(records) + one.record, one.mass);
}

const derive::Step* StepTable::step_of(int body) const noexcept {
  if (std::ranges::find(moving_, body) == moving_.end()) return nullptr;
  const int link = bodies_[at(body)].link;
  return link < 0 ? nullptr : links_.step(link);
}

void StepTable::run(const std::vector<StepEntry>& entries, const StepArrays& arrays) const noexcept {
#ifndef __wasm__
  if (in_machine_code_) return StepLibrary::of_process().run(entries, arrays);
#endif
  for (const StepEntry& entry : entries) entry.step(entry, arrays);
}

bool StepTable::follow(const Tree& tree) noexcept {
  if (revision_ == tree.revision()) return serves_;
  revision_ = tree.revision(), serves_ = false;
  const std::size_t most_bytes = tree.record_capacity() * scalar_.size;
  if (most_bytes > std::numeric_limits<std::int32_t>::max()) return false;
  static std::atomic<std::uint64_t> versions = 0;
  version_ = ++versions;
#ifdef __cpp_exceptions
  try {
    rebuild(tree);
  } catch (const std::bad_alloc&) {
    return false;
  }
#else
  rebuild(tree);  // an error ends the program
#endif
  return serves_ = true;
}

void StepTable::rebuild(const Tree& tree) {
  find_bodies(tree);
  in_machine_code_ = scalar_.width != StepWidth::none && links_.available();
  find_links(tree, false);
  if (in_machine_code_ && links_.different() > most_steps) find_links(tree, true);
  share_memory();
  if (add_entries(tree)) return;
  in_machine_code_ = false;  // the system refused more executable memory
  for (const int b : moving_) bodies_[at(b)].link = -1;
  MT_REQUIRE(add_entries(tree), "generic steps need no executable memory");
}

void StepTable::find_bodies(const Tree& tree) {
  const UncheckedTree all(tree);
  const auto order = all.order();
  bodies_.resize(at(tree.bodies()));
  moving_.clear(), moving_.reserve(at(tree.bodies()));
  bool any_weld = false;
  for (const KernelRun& run : all.kernel_runs()) {
    if (run.planar) continue;
    const bool weld = info(run.kind).nv == 0;
    for (int i = run.begin; i < run.end; ++i) {
      const int b = order[at(i)], parent = all.parent(b);
      Body& body = bodies_[at(b)];
      // A welded body is seen as that to which it is welded: `sum` says which one; −1: the ground.
      const int outer = parent < 0 ? -1 : bodies_[at(parent)].sum;
      body.parent = outer, body.children = 0, body.sum = weld ? outer : b, body.motion = b;
      if (weld) {
        any_weld = true;
        continue;
      }
      if (outer >= 0) ++bodies_[at(outer)].children;
      moving_.push_back(b);
    }
  }
  welded_.clear();
  if (!any_weld) return;
  welded_.resize(at(tree.bodies()));
  for (const KernelRun& run : all.kernel_runs())
    for (int i = run.begin; i < run.end && !run.planar && info(run.kind).nv == 0; ++i) {
      const int b = order[at(i)], to = bodies_[at(b)].sum;
      if (to < 0) continue;
      RigidMass& sum = welded_[at(to)];
      const RigidMass& own = all.link(b).body;
      sum.m += own.m, sum.mc = sum.mc + own.mc, sum.J = sum.J + own.J;
    }
}

/// The constants of a body with those that are welded to it.
const LinkConstants& StepTable::link_of(const Tree& tree, int b, LinkConstants& merged) const {
  const LinkConstants& own = UncheckedTree(tree).link(b);
  if (welded_.empty()) return own;
  const RigidMass& more = welded_[at(b)];
  merged = own;
  merged.body.m += more.m, merged.body.mc = merged.body.mc + more.mc, merged.body.J = merged.body.J + more.J;
  return merged;
}

void StepTable::find_links(const Tree& tree, bool general) {
  const UncheckedTree all(tree);
  const Vec3& g = tree.gravity();
  bool gravity = g.x != 0 || g.y != 0 || g.z != 0;  // generic steps hand it on in any case
  for (const int b : moving_) gravity = gravity || !links_.serves(all.kind(b), all.variant(b));
  links_.begin(moving_.size(), general, gravity);
  LinkConstants merged;
  for (const int b : moving_) {
    Body& body = bodies_[at(b)];
    if (!links_.serves(all.kind(b), all.variant(b))) {
      body.link = -1;
      continue;
    }
    const derive::BodyPlace place = place_of_body(body.children == 0, body.parent < 0);
    body.link = links_.find(all.kind(b), all.variant(b), place, link_of(tree, b, merged), body.link);
  }
}

/// Along a chain all bodies share the memory of one sum and one motion, which then stay in the cache. Of several children the
/// one that comes first inward starts the sum.
void StepTable::share_memory() {
  const std::size_t n = moving_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const int b = moving_[i];
    Body& body = bodies_[at(b)];
    const bool only = body.parent >= 0 && bodies_[at(body.parent)].children == 1;
    body.motion = only ? bodies_[at(body.parent)].motion : b;
    body.sum = b, body.started = false;
  }
  for (std::size_t i = n; i-- > 0;) {
    Body& body = bodies_[at(moving_[i])];
    if (body.parent < 0) continue;
    Body& parent = bodies_[at(body.parent)];
    if (parent.children == 1 && body.children > 0) parent.sum = body.sum;
    body.adds = parent.started;
    parent.started = true;
  }
}

bool StepTable::add_entries(const Tree& tree) {
  const UncheckedTree all(tree);
  const std::size_t n = moving_.size();
  const auto bytes = [&](std::size_t numbers) { return static_cast<std::int32_t>(numbers * scalar_.size); };
  inboard_.resize(n), outboard_.resize(n), velocities_.resize(scalar_.momenta ? 0 : n);
  roots_.clear(), roots_.reserve(n);
  generic_.clear(), generic_.reserve(n);  // entries point to them
  masses_.clear(), masses_.reserve(scalar_.momenta ? n : 0);
  const std::size_t motion = motion_size(scalar_.momenta), inward_pass = scalar_.momenta ? 0 : 1;
  std::size_t record = 0;
  // Registers hand on numbers between two steps of machine code.
  const auto follows_in_registers = [&](std::size_t i) {
    if (i == 0 || i >= n) return false;
    const Body& body = bodies_[at(moving_[i])];
    return body.parent == moving_[i - 1] && body.link >= 0 && bodies_[at(body.parent)].link >= 0;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const int b = moving_[i];
    const Body& body = bodies_[at(b)];
    StepEntry entry;
    entry.q = bytes(at(all.first_q(b))), entry.angle = bytes(at(all.first_angle(b))), entry.dof = bytes(at(all.first_p(b)));
    entry.record = bytes(record);
    StepFunctions passes;
    if (body.link < 0) {
      const GenericStep step = scalar_.generic(all.kind(b), all.variant(b), body.adds);
      GenericBody& own = generic_.emplace_back();
      LinkConstants merged;
      own = {step.passes, link_of(tree, b, merged), all.subtree_mass(b), b};
      if (body.children == 0) own.flags |= node::leaf;
      if (body.parent < 0) own.flags |= node::root | node::grounded;
      if (aligned(own.link)) own.flags |= node::aligned;
      entry.constants = &own;
      record += step.record;
      passes = step.passes;
#ifndef __wasm__
      if (in_machine_code_)
        for (std::size_t pass = 0; pass < passes.size(); ++pass) passes[pass] = StepLibrary::of_process().call_of(pass);
#endif
    } else {
      if (scalar_.momenta) masses_.push_back({entry.record, all.subtree_mass(b)});
      record += links_.record(body.link);
      const bool parent = follows_in_registers(i), child = follows_in_registers(i + 1);
      const derive::Handing outward{false, parent, child, body.children > (child ? 1 : 0)},
          inward{body.adds, child, parent, false};
      if (!links_.functions(body.link, outward, inward, passes, entry.constants)) return false;
    }
    if (body.parent < 0) roots_.push_back(b);
    entry.in = bytes(motion * at(body.parent < 0 ? b : bodies_[at(body.parent)].motion));
    entry.to = bytes(motion * at(body.motion));
    if (!scalar_.momenta) entry.step = passes[0], velocities_[i] = entry;
    entry.step = passes[inward_pass + 1], outboard_[i] = entry;
    entry.in = bytes(sum_size * at(body.sum));
    entry.to = bytes(sum_size * at(body.parent < 0 ? b : bodies_[at(body.parent)].sum));
    entry.step = passes[inward_pass], inboard_[n - 1 - i] = entry;
  }
  MT_REQUIRE(record <= tree.record_capacity(), "the records of steps fit into the memory for those of the kinds");
  return true;
}

}  // namespace momentree

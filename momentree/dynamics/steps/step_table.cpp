#include <momentree/dynamics/steps/step_table.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

#ifndef __wasm__
#include <momentree/dynamics/steps/step_library.hpp>
#endif
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

namespace {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Where the vector that roots are given begins in what bodies hand to their children.
constexpr std::size_t base_place(Passes passes) {
  return in_momenta(passes) ? offsetof(Outboard<double>, gravity) / sizeof(double) : 0;
}
/// With more different steps, their code would not stay in the instruction cache: those that serve any link are then faster.
constexpr std::size_t most_steps = 40;

bool has_gravity(const Tree& tree) {
  const Vec3& g = tree.gravity();
  return g.x != 0 || g.y != 0 || g.z != 0;
}
/// It carries no other and is attached to the ground, directly or by welds.
bool is_alone(const Tree& tree, int b) {
  const unsigned flags = tree.tables().node_flags[at(tree.place(b))];
  return (flags & node::grounded) != 0 && (flags & node::leaf) != 0;
}
derive::BodyPlace place_of_body(bool leaf, bool root) {
  return leaf   ? root ? derive::BodyPlace::single : derive::BodyPlace::leaf
         : root ? derive::BodyPlace::root
                : derive::BodyPlace::inner;
}

}  // namespace

StepTable::StepTable(const StepScalar& scalar, int bodies) : scalar_(scalar), links_(scalar) {
  const std::size_t n = at(bodies);
  bodies_.reserve(n), moving_.reserve(n), generic_.reserve(n), roots_.reserve(n);
  inboard_.reserve(n), outboard_.reserve(n), velocities_.reserve(in_velocities(scalar.passes) ? n : 0);
}

OwnStepTable detail::make_step_table(const StepScalar& scalar, int bodies) { return OwnStepTable(new StepTable(scalar, bodies)); }
void DeleteStepTable::operator()(StepTable* table) const noexcept { delete table; }

void StepTable::velocities(const StepArrays& arrays) const noexcept { run(velocities_, arrays); }

void StepTable::inboard(const StepArrays& arrays, int begin, int end) const noexcept {
  const std::size_t n = inboard_.size(), last = std::min(at(end), n);
  run(std::span(inboard_).subspan(n - last, last - at(begin)), arrays);
}

void StepTable::outboard(const StepArrays& arrays, const void* base, int begin, int end) const noexcept {
  const std::size_t size = at(numbers_of_motion(scalar_.passes)), place = base_place(scalar_.passes);
  for (auto root = std::ranges::lower_bound(roots_, begin, {}, &Root::place); root != roots_.end() && root->place < end; ++root)
    std::memcpy(static_cast<char*>(arrays.motions) + scalar_.size * (size * at(root->body) + place), base, 3 * scalar_.size);
  run(std::span(outboard_).subspan(at(begin), std::min(at(end), outboard_.size()) - at(begin)), arrays);
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

void StepTable::run(std::span<const StepEntry> entries, const StepArrays& arrays) const noexcept {
#ifndef __wasm__
  if (in_machine_code_) return StepLibrary::of_process().run(entries, arrays);
#endif
  for (const StepEntry& entry : entries) entry.step(entry, arrays);
}

bool StepTable::follow(const Tree& tree) noexcept {
  if (revision_ == tree.revision()) return serves_;
  revision_ = tree.revision(), serves_ = false;
  const std::size_t farthest = tree.tables().record_capacity * (keeps_results(scalar_.passes) ? 1 : scalar_.size);
  if (farthest > std::numeric_limits<std::int32_t>::max()) return false;
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
  share_memory();
  // Once more if memory ran out: by generic functions, which need none, results have other last bits.
  if (add_steps(tree) || add_steps(tree)) return;
  in_machine_code_ = false;
  for (const int b : moving_) bodies_[at(b)].link = -1;
  MT_REQUIRE(add_entries(tree), "generic steps need no executable memory");
}

bool StepTable::add_steps(const Tree& tree) {
#ifdef __cpp_exceptions
  try {
#endif
    in_machine_code_ = scalar_.width != StepWidth::none && links_.available();
    find_links(tree, false);
    if (in_machine_code_ && links_.different() > most_steps) find_links(tree, true);
    return add_entries(tree);
#ifdef __cpp_exceptions
  } catch (const std::bad_alloc&) {
    return false;
  }
#endif
}

void StepTable::find_bodies(const Tree& tree) {
  const UncheckedTree all(tree);
  const auto order = all.order();
  bodies_.resize(at(tree.bodies()));
  moving_.clear(), moving_.reserve(at(tree.bodies()));
  bool any_weld = false;
  for (const KernelRun& run : all.tables().runs) {
    if (run.planar && !keeps_results(scalar_.passes)) continue;
    const bool weld = info(run.kind).nv == 0 && !keeps_results(scalar_.passes);
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
  for (const KernelRun& run : all.tables().runs)
    for (int i = run.begin; i < run.end && !(run.planar || info(run.kind).nv > 0); ++i) {
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
  const auto serves = [&](int b) {
    const bool alone_on_weld = keeps_results(scalar_.passes) && bodies_[at(b)].parent >= 0 && is_alone(tree, b);
    return links_.serves(all.kind(b), all.variant(b)) && !alone_on_weld;
  };
  bool gravity = has_gravity(tree);  // generic steps hand it on in any case
  for (const int b : moving_) gravity = gravity || !serves(b);
  links_.begin(moving_.size(), general, gravity);
  LinkConstants merged;
  for (const int b : moving_) {
    Body& body = bodies_[at(b)];
    if (!serves(b)) {
      if (body.link >= 0) body.former = body.link;
      body.link = -1;
      continue;
    }
    const derive::BodyPlace place = place_of_body(body.children == 0, body.parent < 0);
    const int before = body.link;
    body.link = links_.find(all.kind(b), all.variant(b), place, link_of(tree, b, merged), before, body.former);
    if (before >= 0 && before != body.link) body.former = before;
  }
}

/// Along a chain all bodies share the memory of one sum and one motion, which then stay in the cache. Of several children the
/// one that comes first inward starts the sum.
void StepTable::share_memory() {
  const std::size_t n = moving_.size();
  const bool shares = !keeps_results(scalar_.passes);
  for (std::size_t i = 0; i < n; ++i) {
    const int b = moving_[i];
    Body& body = bodies_[at(b)];
    const bool only = shares && body.parent >= 0 && bodies_[at(body.parent)].children == 1;
    body.motion = only ? bodies_[at(body.parent)].motion : b;
    body.sum = b, body.started = false;
  }
  for (std::size_t i = n; i-- > 0;) {
    Body& body = bodies_[at(moving_[i])];
    if (body.parent < 0) continue;
    Body& parent = bodies_[at(body.parent)];
    if (shares && parent.children == 1 && body.children > 0) parent.sum = body.sum;
    body.adds = parent.started;
    parent.started = true;
  }
}

bool StepTable::add_entries(const Tree& tree) {
  const UncheckedTree all(tree);
  const std::size_t n = moving_.size();
  const auto bytes = [&](std::size_t numbers) { return static_cast<std::int32_t>(numbers * scalar_.size); };
  const Passes passes_of = scalar_.passes;
  inboard_.resize(n), outboard_.resize(n), velocities_.resize(in_velocities(passes_of) ? n : 0);
  roots_.clear(), roots_.reserve(n);
  generic_.clear(), generic_.reserve(n);  // entries point to them
  masses_.clear(), masses_.reserve(passes_of == Passes::stage_momenta ? n : 0);
  const std::size_t inward_pass = count_of(passes_of) - 2;
  // Where a body's numbers are in an array, or its number.
  const auto place = [&](int numbers, int b) { return keeps_results(passes_of) ? b : bytes(at(numbers) * at(b)); };
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
    entry.record = keeps_results(passes_of) ? static_cast<std::int32_t>(all.record(b)) : bytes(record);
    StepFunctions passes;
    if (body.link < 0) {
      const GenericStep step = scalar_.generic(all.kind(b), all.variant(b), body.adds);
      GenericBody& own = generic_.emplace_back();
      LinkConstants merged;
      own = {step.passes, link_of(tree, b, merged), all.subtree_mass(b), b};
      own.leaf = body.children == 0, own.root = body.parent < 0, own.aligned = aligned(own.link);
      own.alone = keeps_results(passes_of) ? is_alone(tree, b) : own.leaf && own.root;
      entry.constants = &own;
      record += step.record;
      passes = step.passes;
#ifndef __wasm__
      if (in_machine_code_)
        for (std::size_t pass = 0; pass < passes.size(); ++pass) passes[pass] = StepLibrary::of_process().call_of(pass);
#endif
    } else {
      if (passes_of == Passes::stage_momenta) masses_.push_back({entry.record, all.subtree_mass(b)});
      record += links_.record(body.link);
      const bool parent = follows_in_registers(i), child = follows_in_registers(i + 1);
      const derive::Handing outward{false, parent, child, body.children > (child ? 1 : 0)},
          inward{body.adds, child, parent, false};
      if (!links_.functions(body.link, outward, inward, passes, entry.constants)) return false;
    }
    if (body.parent < 0) roots_.push_back({static_cast<int>(i), b});
    const int motion = numbers_of_motion(passes_of), sum = numbers_of_sum(passes_of);
    entry.in = place(motion, body.parent < 0 ? b : bodies_[at(body.parent)].motion);
    entry.to = place(motion, body.motion);
    if (in_velocities(passes_of)) entry.step = passes[0], velocities_[i] = entry;
    entry.step = passes[inward_pass + 1], outboard_[i] = entry;
    entry.in = place(sum, body.sum);
    entry.to = place(sum, body.parent < 0 ? b : bodies_[at(body.parent)].sum);
    entry.step = passes[inward_pass], inboard_[n - 1 - i] = entry;
  }
  MT_REQUIRE(keeps_results(passes_of) || record <= tree.tables().record_capacity,
             "the records of steps fit into the memory for those of the kinds");
  return true;
}

}  // namespace momentree

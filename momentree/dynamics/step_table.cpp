#include <momentree/dynamics/step_table.hpp>

#include <momentree/dynamics/workspace_data.hpp>

#ifndef __wasm__
#include <algorithm>
#include <new>

#include <momentree/dynamics/step_library.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/tree/unchecked_tree.hpp>
#endif

namespace momentree {

std::unique_ptr<StepTable, void (*)(StepTable*)> detail::make_step_table() {
  return {new StepTable, [](StepTable* table) { delete table; }};
}

#ifdef __wasm__  // browsers have no machine code

bool StepTable::follow(const Tree&) noexcept { return false; }
void StepTable::velocities(const StepArrays&) const noexcept {}
void StepTable::inboard(const StepArrays&) const noexcept {}
void StepTable::outboard(const StepArrays&, const Vec3&) const noexcept {}

#else

namespace {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr std::int32_t bytes(std::size_t numbers) { return static_cast<std::int32_t>(numbers * sizeof(double)); }

constexpr std::size_t sum_size = sizeof(Inboard<double>) / sizeof(double), motion_size = sizeof(Motion<double>) / sizeof(double);
/// With more different steps, their code would not stay in the instruction cache: the compiled steps are then faster.
constexpr std::size_t most_steps = 40;
/// More bodies would have places that 32 bits don't reach.
constexpr int most_bodies = 1 << 20;

BodyPlace place_of_body(bool leaf, bool root) {
  return leaf ? root ? BodyPlace::single : BodyPlace::leaf : root ? BodyPlace::root : BodyPlace::inner;
}

}  // namespace

bool StepTable::follow(const Tree& tree) noexcept try {
  if (revision_ == tree.revision()) return serves_;
  revision_ = tree.revision();
  return serves_ = StepLibrary::of_process().available() && tree.bodies() <= most_bodies && rebuild(tree);
} catch (const std::bad_alloc&) {
  return serves_ = false;
}

bool StepTable::rebuild(const Tree& tree) {
  find_bodies(tree);
  if (links_.size() > 2 * moving_.size() + 64) {  // mostly those of earlier topologies
    links_.clear(), constants_.clear();
    for (Body& body : bodies_) body.link = -1;
  }
  ++rebuilt_, steps_.clear();
  int previous = -1;
  generic_.clear();
  for (const int b : moving_)
    if (!find_link(tree, b, previous)) return false;
  share_memory();
  return add_entries(tree);
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
LinkConstants StepTable::link_of(const Tree& tree, int b) const {
  LinkConstants link = UncheckedTree(tree).link(b);
  if (welded_.empty()) return link;
  const RigidMass& more = welded_[at(b)];
  link.body.m += more.m, link.body.mc = link.body.mc + more.mc, link.body.J = link.body.J + more.J;
  return link;
}

/// Keeps the link of a body if it is still the same; takes that of the body before if it is equal; or makes its own.
bool StepTable::find_link(const Tree& tree, int b, int& previous) {
  const UncheckedTree all(tree);
  Body& body = bodies_[at(b)];
  const bool leaf = body.children == 0, root = body.parent < 0;
  if (!derive::has_steps(all.kind(b), all.variant(b))) {
    generic_.push_back({{}, link_of(tree, b), b, leaf, root});
    body.link = -1;
    return true;
  }
  LinkConstants merged;
  const LinkConstants* constants = &all.link(b);
  if (!welded_.empty()) merged = link_of(tree, b), constants = &merged;
  const bool has_armature = all.variant(b) == Variant::armature;
  const derive::StepKey form = derive::key_of(all.kind(b), has_armature, place_of_body(leaf, root), *constants);
  const auto fits = [&](int other) {
    return other >= 0 && links_[at(other)].form == form && derive::same_numbers(links_[at(other)].numbers, *constants);
  };
  if (!fits(body.link)) body.link = previous;
  if (!fits(body.link)) {
    Link link{derive::numbers_of(*constants), form};
    derive::StepKey key = link.form;
    derive::add_pattern(link.numbers, key);
    CompiledStep* const compiled = StepLibrary::of_process().get(key);
    if (compiled == nullptr) return false;
    MT_REQUIRE(at(compiled->step.record()) <= shape(key.kind).record[static_cast<std::size_t>(all.variant(b))],
               "the record of a step fits into that of the kind");
    link.step = compiled;
    link.constants = constants_.size();
    constants_.resize(constants_.size() + compiled->step.constants());
    compiled->step.evaluate_constants(link.numbers, constants_.data() + link.constants);
    links_.push_back(link);
    body.link = static_cast<int>(links_.size()) - 1;
  }
  previous = body.link;
  Link& link = links_[at(body.link)];
  if (link.used == rebuilt_) return true;
  link.used = rebuilt_;
  if (std::ranges::find(steps_, link.step) == steps_.end()) steps_.push_back(link.step);
  return steps_.size() <= most_steps;
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
  StepLibrary& library = StepLibrary::of_process();
  const std::size_t n = moving_.size();
  velocities_.resize(n), inboard_.resize(n), outboard_.resize(n);
  roots_.clear(), roots_.reserve(n);
  std::size_t next_generic = 0;
  // Registers hand on numbers between two steps of machine code.
  const auto follows_in_registers = [&](std::size_t i) {
    if (i == 0 || i >= n) return false;
    const Body& body = bodies_[at(moving_[i])];
    return body.parent == moving_[i - 1] && body.link >= 0 && bodies_[at(body.parent)].link >= 0;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const int b = moving_[i];
    const Body& body = bodies_[at(b)];
    StepEntry entry{nullptr,
                    nullptr,
                    bytes(at(all.first_q(b))),
                    bytes(at(all.first_angle(b))),
                    bytes(at(all.first_p(b))),
                    bytes(all.record(b)),
                    0,
                    0};
    std::array<StepFunction, derive::Step::passes> passes;
    if (body.link < 0) {
      GenericBody& own = generic_[next_generic++];
      own.passes = generic_steps(all.kind(b), all.variant(b), body.adds);
      MT_REQUIRE(own.passes[0] != nullptr, "kernels without machine code have generic steps");
      entry.constants = &own;
      for (std::size_t pass = 0; pass < passes.size(); ++pass) passes[pass] = library.call_of(pass);
    } else {
      const Link& link = links_[at(body.link)];
      entry.constants = constants_.data() + link.constants;
      const bool parent = follows_in_registers(i), child = follows_in_registers(i + 1);
      const derive::Handing outward{false, parent, child, body.children > (child ? 1 : 0)},
          inward{body.adds, child, parent, false};
      for (std::size_t pass = 0; pass < passes.size(); ++pass) {
        passes[pass] = library.function(*link.step, pass, pass == 1 ? inward : outward);
        if (passes[pass] == nullptr) return false;
      }
    }
    if (body.parent < 0) roots_.push_back(b);
    entry.in = bytes(motion_size * at(body.parent < 0 ? b : bodies_[at(body.parent)].motion));
    entry.to = bytes(motion_size * at(body.motion));
    entry.step = passes[0], velocities_[i] = entry;
    entry.step = passes[2], outboard_[i] = entry;
    entry.in = bytes(sum_size * at(body.sum));
    entry.to = bytes(sum_size * at(body.parent < 0 ? b : bodies_[at(body.parent)].sum));
    entry.step = passes[1], inboard_[n - 1 - i] = entry;
  }
  return true;
}

void StepTable::velocities(const StepArrays& arrays) const noexcept { StepLibrary::of_process().run(velocities_, arrays); }

void StepTable::inboard(const StepArrays& arrays) const noexcept { StepLibrary::of_process().run(inboard_, arrays); }

void StepTable::outboard(const StepArrays& arrays, const Vec3& acceleration) const noexcept {
  for (const int root : roots_) {
    double* const motion = arrays.motions + motion_size * at(root);
    motion[0] = acceleration.x, motion[1] = acceleration.y, motion[2] = acceleration.z;
  }
  StepLibrary::of_process().run(outboard_, arrays);
}

#endif

}  // namespace momentree

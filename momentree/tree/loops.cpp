// Loop joints of a tree, and what follows from them and the present topology.
#include <algorithm>

#include <momentree/joint/motion.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {

// A frame given in a body's user frame, in its kernel frame.
KernelFrame in_kernel_frame(const KernelFrame& kernel, const Pose& at) {
  return {transpose(kernel.R) * rotation_matrix(at.rotation), transpose_times(kernel.R, at.position - kernel.r)};
}

// `by_rows`: the closure leaves the locked DoFs free. An armature whose DoF follows a motion needs no row: its speed is known.
void list_dof_rows(const Loop& loop, bool by_rows, LoopLink& link) {
  const auto add = [&](const DofRow& row) { link.dof_rows[static_cast<std::size_t>(link.dof_row_count++)] = row; };
  if (loop.driven()) return add({0, DofRow::Use::motion, 0});
  for (int i = 0; i < info(loop.joint.kind).nv; ++i) {
    const double armature = loop.parameters.armature.of(i);
    if (by_rows && (loop.joint.locked >> i & 1u) != 0) add({i, DofRow::Use::lock, 0});
    if (armature > 0 && (loop.joint.locked >> i & 1u) == 0) add({i, DofRow::Use::armature, armature});
  }
}

}  // namespace

int Tree::add_loop(Loop loop) {
  MT_REQUIRE(alive(loop.body) && (loop.to == ground.index || alive(loop.to)) && loop.body != loop.to,
             "a loop joint joins two different bodies, or a body and the ground");
  MT_REQUIRE(loop.joint.kind != Kind::free, "a loop joint constrains something");
  if (loop.number < 0) loop.number = next_loop_;
  MT_REQUIRE(find_loop(loop.id()) == nullptr, "a number that no loop joint has");
  next_loop_ = std::max(next_loop_, loop.number + 1);
  loops_.push_back(std::move(loop));
  list_loops();
  revision_.renew();
  return loops_.back().number;
}

void Tree::remove_loop(int number) {
  MT_REQUIRE(loop_place({first_loop + number}) >= 0, "the loop joint is in the tree");
  std::erase_if(loops_, [number](const Loop& loop) { return loop.number == number; });
  list_loops();
  revision_.renew();
}

void Tree::set_loop(int number, const Joint& joint, const JointParameters& parameters, const Values& held) {
  const int place = loop_place({first_loop + number});
  MT_REQUIRE(place >= 0, "the loop joint is in the tree");
  MT_REQUIRE(joint.locked == 0 || held.size() == info(joint.kind).nq, "coordinates at which the joint is held");
  Loop& loop = loops_[at(place)];
  loop.joint = joint, loop.parameters = parameters, loop.held = held;
  list_loops();
  revision_.renew();
}

void Tree::set_loop_function(int number, std::shared_ptr<const JointFunction> function) {
  const int place = loop_place({first_loop + number});
  MT_REQUIRE(place >= 0, "the loop joint is in the tree");
  int& own = loops_[at(place)].joint.function;
  own = renewed_function(own, std::move(function));
  count_loop_functions();
  revision_.renew();
}

void Tree::count_loop_functions() {
  loop_functions_ =
      static_cast<int>(std::count_if(loops_.begin(), loops_.end(), [](const Loop& loop) { return loop.joint.function >= 0; }));
}

void Tree::end_coupling(int coupling) {
  MT_REQUIRE(coupling >= 0 && at(coupling) < couplings().size() && coupling_acts(coupling), "the coupling acts");
  coupling_ended_[at(coupling)] = 1;
  list_loops();
  revision_.renew();
}

// A coupling ends with one of its joints: this cannot be undone by another joint that later has the same number.
void Tree::list_couplings() {
  for (std::size_t c = 0; c < coupling_ended_.size(); ++c) {
    if (coupling_ended_[c] != 0) continue;
    const Coupling& coupling = couplings()[c];
    const auto carrier_of = [this](JointId joint) {
      const int b = carrier_[at(joint.index)];
      return b >= 0 && info(this->joint(b).kind).nv == 1 ? b : -1;
    };
    LoopLink link;
    link.ends = {static_cast<int>(c), carrier_of(coupling.joint), coupling.leads() ? carrier_of(coupling.follows) : -1};
    if (link.ends.joint < 0 || (coupling.leads() && link.ends.follows < 0)) {
      coupling_ended_[c] = 1;
      continue;
    }
    link.first_row = loop_rows_++;
    link.rows = 1;
    link.coupled = static_cast<int>(loop_links_.size());
    loop_links_.push_back(link);
  }
}

int Tree::loop_place(JointId joint) const {
  for (std::size_t i = 0; i < loops_.size(); ++i)
    if (loops_[i].id() == joint) return static_cast<int>(i);
  return -1;
}

const Loop* Tree::find_loop(JointId joint) const {
  const int place = loop_place(joint);
  return place < 0 ? nullptr : &loops_[at(place)];
}

// Rows, frames and stops. Called whenever the order or a kernel frame changes.
void Tree::list_loops() {
  loop_revision_.renew();
  loop_links_.clear(), loop_stops_.clear();
  loop_rows_ = loop_columns_ = loop_motions_ = loop_armatures_ = 0;
  std::erase_if(loops_, [this](const Loop& loop) { return !alive(loop.body) || (loop.to >= 0 && !alive(loop.to)); });
  count_loop_functions();
  for (std::size_t i = 0; i < loops_.size(); ++i) {
    const Loop& loop = loops_[i];
    const std::optional<LockedForm> held = locked_form(loop.joint, loop.held);
    const LockedForm form = held ? *held : LockedForm{closure_of(spec_of(loop.joint)), {}, {}};
    LoopLink link;
    link.closure = form.rows;
    link.child = in_kernel_frame(frame(loop.body), loop.joint.child_at * form.child);
    link.parent = in_kernel_frame(loop.to < 0 ? KernelFrame{} : frame(loop.to), loop.joint.at * form.parent);
    link.first_row = loop_rows_;
    link.child_offset = form.child, link.parent_offset = form.parent;
    list_dof_rows(loop, !held, link);
    link.rows = link.closure.rows() + link.dof_row_count;
    for (int k = 0; k < link.dof_row_count; ++k) {
      loop_motions_ += link.dof_rows[at(k)].use == DofRow::Use::motion ? 1 : 0;
      loop_armatures_ += link.dof_rows[at(k)].use == DofRow::Use::armature ? 1 : 0;
    }
    link.coupled = static_cast<int>(i);
    loop_rows_ += link.rows;
    loop_links_.push_back(link);
  }
  list_couplings();
  for (std::size_t i = 0; i < loop_links_.size(); ++i) {
    const bool is_loop = i < loops_.size();
    const int one = is_loop ? loops_[i].body : loop_links_[i].ends.joint;
    const int other = is_loop ? loops_[i].to : loop_links_[i].ends.follows;
    const auto place = static_cast<int>(i);
    for (int b = one; b >= 0; b = parent_[at(b)]) loop_stops_.push_back({b, place, 0, -1});
    const auto found = [&](int b) {
      return std::any_of(loop_stops_.begin(), loop_stops_.end(),
                         [&](const LoopStop& s) { return s.body == b && s.loop == place; });
    };
    for (int b = other; b >= 0 && !found(b); b = parent_[at(b)]) loop_stops_.push_back({b, place, 0, -1});
  }
  std::sort(loop_stops_.begin(), loop_stops_.end(), [this](const LoopStop& a, const LoopStop& b) {
    return a.body == b.body ? a.loop < b.loop : place_[at(a.body)] < place_[at(b.body)];
  });
  int nearest = -1, first = 0;  // the first loop with a stop at the present body
  for (LoopStop& stop : loop_stops_) {
    if (stop.body != nearest) nearest = stop.body, first = stop.loop;
    int& coupled = loop_links_[at(stop.loop)].coupled;
    coupled = std::min(coupled, first);
    stop.first_column = loop_columns_;
    loop_columns_ += loop_links_[at(stop.loop)].rows;
    const int outer = parent_[at(stop.body)];
    if (outer < 0) continue;
    const auto inner = std::lower_bound(loop_stops_.begin(), loop_stops_.end(), outer,
                                        [this](const LoopStop& s, int b) { return place_[at(s.body)] < place_[at(b)]; });
    for (auto s = inner; s != loop_stops_.end() && s->body == outer; ++s)
      if (s->loop == stop.loop) stop.inboard = static_cast<int>(s - loop_stops_.begin());
  }
  note_constraints();
}

}  // namespace momentree

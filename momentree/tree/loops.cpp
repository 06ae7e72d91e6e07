// Loop joints of a tree, and what follows from them and the present topology.
#include <algorithm>

#include <momentree/joint/motion.hpp>
#include <momentree/tree/edit.hpp>
#include <momentree/tree/kernel_run.hpp>

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

int Tree::Edit::add_loop(Loop loop) {
  MT_REQUIRE(tree_.alive(loop.body) && (loop.to == ground.index || tree_.alive(loop.to)) && loop.body != loop.to,
             "a loop joint joins two different bodies, or a body and the ground");
  MT_REQUIRE(loop.joint.kind != Kind::free, "a loop joint constrains something");
  if (loop.number < 0) loop.number = tree_.loops_.next_number;
  MT_REQUIRE(tree_.loops_.find(loop.id()) == nullptr, "a number that no loop joint has");
  tree_.loops_.next_number = std::max(tree_.loops_.next_number, loop.number + 1);
  tree_.loops_.joints.push_back(std::move(loop));
  tree_.list_loops();
  tree_.revision_.renew();
  return tree_.loops_.joints.back().number;
}

void Tree::Edit::remove_loop(int number) {
  MT_REQUIRE(tree_.loops_.place({first_loop + number}) >= 0, "the loop joint is in the tree");
  std::erase_if(tree_.loops_.joints, [number](const Loop& loop) { return loop.number == number; });
  tree_.list_loops();
  tree_.revision_.renew();
}

void Tree::Edit::set_loop(int number, const Joint& joint, const JointParameters& parameters, const Values& held) {
  const int place = tree_.loops_.place({first_loop + number});
  MT_REQUIRE(place >= 0, "the loop joint is in the tree");
  MT_REQUIRE(joint.locked == 0 || held.size() == info(joint.kind).nq, "coordinates at which the joint is held");
  Loop& loop = tree_.loops_.joints[at(place)];
  loop.joint = joint, loop.parameters = parameters, loop.held = held;
  tree_.list_loops();
  tree_.revision_.renew();
}

void Tree::Edit::set_loop_function(int number, std::shared_ptr<const JointFunction> function) {
  const int place = tree_.loops_.place({first_loop + number});
  MT_REQUIRE(place >= 0, "the loop joint is in the tree");
  int& own = tree_.loops_.joints[at(place)].joint.function;
  own = tree_.renewed_function(own, std::move(function));
  tree_.count_loop_functions();
  tree_.revision_.renew();
}

void Tree::count_loop_functions() {
  loops_.functions = static_cast<int>(
      std::count_if(loops_.joints.begin(), loops_.joints.end(), [](const Loop& loop) { return loop.joint.function >= 0; }));
}

void Tree::Edit::end_coupling(int coupling) {
  MT_REQUIRE(coupling >= 0 && at(coupling) < tree_.couplings().size() && tree_.coupling_acts(coupling), "the coupling acts");
  tree_.coupling_ended_[at(coupling)] = 1;
  tree_.list_loops();
  tree_.revision_.renew();
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
    link.first_row = loops_.rows++;
    link.rows = 1;
    link.coupled = static_cast<int>(loops_.links.size());
    loops_.links.push_back(link);
  }
}

int TreeLoops::place(JointId joint) const {
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (joints[i].id() == joint) return static_cast<int>(i);
  return -1;
}

const Loop* TreeLoops::find(JointId joint) const {
  const int at = place(joint);
  return at < 0 ? nullptr : &joints[static_cast<std::size_t>(at)];
}

// Rows, frames and stops. Called whenever the order or a kernel frame changes.
void Tree::list_loops() {
  loops_.version.renew();
  loops_.links.clear(), loops_.stops.clear();
  loops_.rows = loops_.columns = loops_.motions = loops_.armatures = 0;
  std::erase_if(loops_.joints, [this](const Loop& loop) { return !alive(loop.body) || (loop.to >= 0 && !alive(loop.to)); });
  count_loop_functions();
  for (std::size_t i = 0; i < loops_.joints.size(); ++i) {
    const Loop& loop = loops_.joints[i];
    const std::optional<LockedForm> held = locked_form(loop.joint, loop.held);
    const LockedForm form = held ? *held : LockedForm{closure_of(spec_of(loop.joint)), {}, {}};
    LoopLink link;
    link.closure = form.rows;
    link.child = in_kernel_frame(frame(loop.body), loop.joint.child_at * form.child);
    link.parent = in_kernel_frame(loop.to < 0 ? KernelFrame{} : frame(loop.to), loop.joint.at * form.parent);
    link.first_row = loops_.rows;
    link.child_offset = form.child, link.parent_offset = form.parent;
    list_dof_rows(loop, !held, link);
    link.rows = link.closure.rows() + link.dof_row_count;
    for (int k = 0; k < link.dof_row_count; ++k) {
      loops_.motions += link.dof_rows[at(k)].use == DofRow::Use::motion ? 1 : 0;
      loops_.armatures += link.dof_rows[at(k)].use == DofRow::Use::armature ? 1 : 0;
    }
    link.coupled = static_cast<int>(i);
    loops_.rows += link.rows;
    loops_.links.push_back(link);
  }
  list_couplings();
  for (std::size_t i = 0; i < loops_.links.size(); ++i) {
    const bool is_loop = i < loops_.joints.size();
    const int one = is_loop ? loops_.joints[i].body : loops_.links[i].ends.joint;
    const int other = is_loop ? loops_.joints[i].to : loops_.links[i].ends.follows;
    const auto place = static_cast<int>(i);
    for (int b = one; b >= 0; b = tables_.parent[at(b)]) loops_.stops.push_back({b, place, 0, -1});
    const auto found = [&](int b) {
      return std::any_of(loops_.stops.begin(), loops_.stops.end(),
                         [&](const LoopStop& s) { return s.body == b && s.loop == place; });
    };
    for (int b = other; b >= 0 && !found(b); b = tables_.parent[at(b)]) loops_.stops.push_back({b, place, 0, -1});
  }
  std::sort(loops_.stops.begin(), loops_.stops.end(), [this](const LoopStop& a, const LoopStop& b) {
    return a.body == b.body ? a.loop < b.loop : place_[at(a.body)] < place_[at(b.body)];
  });
  int nearest = -1, first = 0;  // the first loop with a stop at the present body
  for (LoopStop& stop : loops_.stops) {
    if (stop.body != nearest) nearest = stop.body, first = stop.loop;
    int& coupled = loops_.links[at(stop.loop)].coupled;
    coupled = std::min(coupled, first);
    stop.first_column = loops_.columns;
    loops_.columns += loops_.links[at(stop.loop)].rows;
    const int outer = tables_.parent[at(stop.body)];
    if (outer < 0) continue;
    const auto inner = std::lower_bound(loops_.stops.begin(), loops_.stops.end(), outer,
                                        [this](const LoopStop& s, int b) { return place_[at(s.body)] < place_[at(b)]; });
    for (auto s = inner; s != loops_.stops.end() && s->body == outer; ++s)
      if (s->loop == stop.loop) stop.inboard = static_cast<int>(s - loops_.stops.begin());
  }
  note_constraints();
}

}  // namespace momentree

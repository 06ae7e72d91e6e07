// Everything that follows from parents, joints and directions: offsets, lists, order, kernel runs, subtree masses. All at once
// when a model is compiled or a topology restored; after an edit, only the affected part. Both give the same tables.
#include <algorithm>

#include <momentree/base/check.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/edit.hpp>
#include <momentree/tree/kernel_run.hpp>

namespace momentree {

namespace {

enum Special : unsigned char {
  spring = 1,
  quaternion = 2,
  force = 4,
  drive = 8,
  driven = 16,
  strength = 32,
  function_driven = 64
};

Variant variant_of(unsigned locked, bool armature, bool reversed, bool rotates_about_z) {
  const bool exchanged = reversed && !rotates_about_z;  // other kinds are reversed by flipping their frame
  if (locked != 0) return exchanged ? Variant::reversed_locked : Variant::locked;
  if (exchanged) return Variant::reversed;
  return armature ? Variant::armature : Variant::plain;
}

// Moves the entries from `first` on by `by` places, in a list with sufficient capacity.
template <class T>
void shift_tail(std::vector<T>& all, int first, int by) {
  const std::size_t count = all.size(), now = count + static_cast<std::size_t>(by);
  if (by > 0) {
    all.resize(now);
    std::move_backward(all.begin() + first, all.begin() + static_cast<std::ptrdiff_t>(count), all.end());
  } else if (by < 0) {
    std::move(all.begin() + first, all.end(), all.begin() + first + by);
    all.resize(now);
  }
}

}  // namespace

void Tree::link_all(detail::LinkCollector* collector) {
  first_root_ = -1;
  for (int& child : first_child_) child = -1;
  int living = 0;
  for (int b = bodies() - 1; b >= 0; --b) {  // backwards, so that the lists are in ascending order
    next_sibling_[at(b)] = -1;
    if (!alive(b)) continue;
    ++living;
    int& head = tables_.parent[at(b)] < 0 ? first_root_ : first_child_[at(tables_.parent[at(b)])];
    next_sibling_[at(b)] = head;
    head = b;
  }
  tables_.order.resize(at(living));
  int place = 0;
  for (int root = first_root_; root >= 0; root = next_sibling_[at(root)]) place = number_depth_first(root, place);
  MT_REQUIRE(place == living, "every body is joined to the ground");
  // Where the topology is the model's, so are frames and links.
  const bool known = declared_ && collector == nullptr;
  tables_.links.clear(declared_ ? std::shared_ptr<const detail::SharedLinks>(declared_, &declared_->links) : nullptr);
  for (int b = 0; b < bodies(); ++b) tables_.links.leave(at(b));
  for (int b : tables_.order) {
    tables_.classes[at(b)].as_declared = known && frame_as_declared(b);
    if (tables_.classes[at(b)].as_declared) tables_.links.share(at(b), at(declared_->bodies[at(b)].link));
  }
  pack_all();
  for (int b : tables_.order) {  // a link depends on the inboard frame
    const int outer = tables_.parent[at(b)];
    const bool frame_known = tables_.classes[at(b)].as_declared;
    if (frame_known && outer == declared_->bodies[at(b)].parent && (outer < 0 || tables_.classes[at(outer)].as_declared)) {
      classify(b);
      continue;
    }
    if (!frame_known) make_frame(b);
    put_locks(b);
    make_link(b);
    if (collector != nullptr) collect(b, *collector);
  }
  build_runs();
  for (std::size_t i = tables_.order.size(); i-- > 0;) update_subtree_mass(tables_.order[i]);
}

void Tree::pack_all() {
  nq_ = nv_ = angles_ = 0;
  tables_.angle_q.clear(), tables_.angle_offset.clear();
  for (auto* list : {&tables_.armature, &tables_.damping, &tables_.effort}) list->clear();
  for (int j = 0; j < bodies(); ++j) {
    const int b = carrier_[at(j)];
    special_[at(j)] = 0;
    if (b < 0) continue;
    assign_offsets(b);
    pack(b);
  }
  list_special_joints();
}

// Assigns the next coordinates, DoFs and angles to b's joint. Does not allocate: capacity is reserved for any joints.
void Tree::assign_offsets(int b) {
  const KindShape& kind = shape(joint(b).kind);
  tables_.offsets[at(b)].q = nq_, tables_.offsets[at(b)].p = nv_, tables_.offsets[at(b)].angle = angles_;
  nq_ += kind.nq, nv_ += kind.nv, angles_ += kind.angles;
  tables_.angle_q.resize(at(angles_)), tables_.angle_offset.resize(at(angles_));
  for (auto* list : {&tables_.armature, &tables_.damping, &tables_.effort}) list->resize(at(nv_));
}

const detail::DofParameters& Tree::dof_parameters(const Joint& joint) const {
  static constexpr detail::DofParameters none{};
  const int own = joint.parameters - shared_parameters();
  if (joint.parameters < 0) return none;
  return own < 0 ? declared_->dofs[at(joint.parameters)] : own_dofs_[at(own)];
}

Tree::Locks Tree::locks_of(int b) const {
  const Joint& joint = this->joint(b);
  const unsigned all = (1u << shape(joint.kind).nv) - 1;
  const unsigned driven = dof_parameters(joint).motion ? all & ~joint.locked : 0;
  return {static_cast<unsigned char>(joint.locked | driven), static_cast<unsigned char>(driven)};
}

void Tree::put_locks(int b) {
  const Locks now = locks_of(b);
  if (tables_.links[at(b)].locked == now.locked && tables_.links[at(b)].driven == now.driven) return;
  LinkConstants& link = tables_.links.own(at(b));
  link.locked = now.locked, link.driven = now.driven;
}

// Writes the packed data at the offsets of b's joint.
void Tree::pack(int b) {
  const Joint& joint = this->joint(b);
  const KindShape& kind = shape(joint.kind);
  const detail::DofParameters& given = dof_parameters(joint);
  const Locks locks = locks_of(b);
  if (tables_.links.has(at(b))) put_locks(b);
  for (int i = 0; i < kind.angles; ++i) {
    tables_.angle_q[at(tables_.offsets[at(b)].angle + i)] = tables_.offsets[at(b)].q + kind.angle[i];
    tables_.angle_offset[at(tables_.offsets[at(b)].angle + i)] =
        kind.rotates_about_z && tables_.links.has(at(b)) ? tables_.links[at(b)].angle_0 : 0.0;
  }
  for (int i = 0; i < kind.nv; ++i) {
    const auto p = at(tables_.offsets[at(b)].p + i);
    const bool moves = (joint.locked >> i & 1u) == 0;  // forces on a locked DoF have no effect
    tables_.armature[p] = given.armature[at(i)];
    tables_.damping[p] = moves ? given.damping[at(i)] : 0.0;
    tables_.effort[p] = moves ? given.effort[at(i)] : 0.0;
  }
  tables_.classes[at(b)].kind = joint.kind;
  tables_.classes[at(b)].variant = variant_of(locks.locked, given.has_armature, reversed_[at(b)] != 0, kind.rotates_about_z);
  const bool drives = given.drive || joint.function >= 0;
  special_[at(joint_of_[at(b)])] = static_cast<unsigned char>(
      (given.spring ? spring : 0) | (given.force ? force : 0) | (kind.nq > kind.nv ? quaternion : 0) | (drives ? drive : 0) |
      (joint.function >= 0 ? function_driven : 0) | (locks.driven != 0 ? driven : 0) | (given.strength ? strength : 0));
}

void Tree::Edit::copy_with_armatures(const Tree& other) {
  tree_ = other;
  tree_.revision_.renew();
  for (const int b : tree_.tables_.order)
    if (tree_.parameters(b) != nullptr && tree_.tables_.classes[at(b)].variant == Variant::plain) {
      tree_.tables_.classes[at(b)].variant = Variant::armature;
      if (tree_.kind(b) == Kind::free) tree_.update_frames(b);
    }
  tree_.build_runs();
  tree_.loops_.version = other.loops_.version;  // rows that were chosen for one tree are those of the other
}

double* Tree::Edit::armature() {
  tree_.revision_.renew();
  return tree_.tables_.armature.data();
}

void Tree::Edit::use_generic_kernels() {
  tree_.revision_.renew();
  for (const int b : tree_.tables_.order) {
    Variant& variant = tree_.tables_.classes[at(b)].variant;
    if (variant == Variant::plain || variant == Variant::armature) variant = Variant::locked;
    if (tree_.kind(b) == Kind::free) tree_.update_frames(b);  // it depends on the variant
  }
  tree_.build_runs();
}

// Updates the packed data after b's joint changed from kind `before`: data behind it moves. Returns whether the lists of special
// joints must be renewed.
bool Tree::repack(int b, Kind before) {
  const KindShape& old = shape(before);
  const KindShape& now = shape(joint(b).kind);
  const int q = now.nq - old.nq, p = now.nv - old.nv, angles = now.angles - old.angles;
  if (q != 0 || p != 0 || angles != 0) {
    for (int j = joint_of_[at(b)] + 1; j < bodies(); ++j) {
      const int c = carrier_[at(j)];
      if (c >= 0) tables_.offsets[at(c)].q += q, tables_.offsets[at(c)].p += p, tables_.offsets[at(c)].angle += angles;
    }
    const int behind_p = tables_.offsets[at(b)].p + old.nv, behind_angle = tables_.offsets[at(b)].angle + old.angles;
    for (int i = behind_angle; i < angles_; ++i) tables_.angle_q[at(i)] += q;
    shift_tail(tables_.angle_q, behind_angle, angles);
    shift_tail(tables_.angle_offset, behind_angle, angles);
    for (auto* list : {&tables_.armature, &tables_.damping, &tables_.effort}) shift_tail(*list, behind_p, p);
    nq_ += q, nv_ += p, angles_ += angles;
  }
  const unsigned char was = special_[at(joint_of_[at(b)])];
  pack(b);
  return special_[at(joint_of_[at(b)])] != was;
}

void Tree::list_special_joints() {
  for (auto* list : {&special_joints_.springs, &special_joints_.quaternions, &special_joints_.forces, &special_joints_.motions,
                     &special_joints_.strengths})
    list->clear();
  unsigned all = 0;
  for (std::size_t j = 0; j < special_.size(); ++j) {
    const unsigned s = special_[j];
    all |= s;
    if ((s & ~unsigned{force}) == 0) continue;
    if ((s & spring) != 0) special_joints_.springs.push_back(carrier_[j]);
    if ((s & quaternion) != 0) special_joints_.quaternions.push_back(carrier_[j]);
    if ((s & drive) != 0) special_joints_.forces.push_back(carrier_[j]);
    if ((s & driven) != 0) special_joints_.motions.push_back(carrier_[j]);
    if ((s & strength) != 0) special_joints_.strengths.push_back(carrier_[j]);
  }
  tables_.has_forces = (all & force) != 0;
  special_joints_.functions = (all & function_driven) != 0;
  note_constraints();
}

// Writes the tree of `root` into the order, from `place` on; returns its end. Iterative, because a chain of a million bodies is a
// million levels deep.
int Tree::number_depth_first(int root, int place) {
  for (int b = root;;) {
    tables_.order[at(place)] = b;
    place_[at(b)] = place++;
    if (first_child_[at(b)] >= 0) {
      b = first_child_[at(b)];
      continue;
    }
    while (b != root && next_sibling_[at(b)] < 0) b = tables_.parent[at(b)];
    if (b == root) return place;
    b = next_sibling_[at(b)];
  }
}

// End of b's subtree in the order.
int Tree::end_of(int b) const {
  while (b >= 0 && next_sibling_[at(b)] < 0) b = tables_.parent[at(b)];
  return b < 0 ? static_cast<int>(tables_.order.size()) : place_[at(next_sibling_[at(b)])];
}

// Moves bodies [begin, end) of the order to `to`, a place outside of that range.
void Tree::move_block(int begin, int end, int to) {
  const auto o = tables_.order.begin();
  if (to < begin) std::rotate(o + to, o + begin, o + end);
  if (to > end) std::rotate(o + begin, o + end, o + to);
}

// Finds places, node flags, records and kernel runs from the order.
void Tree::build_runs() {
  tables_.runs.clear();
  const int count = static_cast<int>(tables_.order.size());
  tables_.node_flags.resize(at(count));
  const int *order = tables_.order.data(), *parent = tables_.parent.data(), *first_child = first_child_.data(),
            *next_sibling = next_sibling_.data();
  const TreeTables::Class* classes = tables_.classes.data();
  int* places = place_.data();
  TreeTables::Offsets* offsets = tables_.offsets.data();
  std::size_t scalars = 0, record = 0;
  TreeTables::Class same{};
  bool planar = false;
  for (int place = 0; place < count; ++place) {
    const int b = order[place], outer = parent[b], child = first_child[b];
    places[b] = place;
    unsigned f = 0;
    if (classes[b].aligned) f |= node::aligned;
    if (child < 0) f |= node::leaf;
    if (child >= 0 && next_sibling[child] >= 0) f |= node::branching;
    if (outer < 0)
      f |= node::root;
    else if (first_child[outer] == b)
      f |= node::first_child;
    else if (next_sibling[b] < 0)
      f |= node::last_child;
    if (outer < 0 || (classes[outer].kind == Kind::weld && (tables_.node_flags[at(places[outer])] & node::grounded) != 0))
      f |= node::grounded;
    tables_.node_flags[at(place)] = static_cast<unsigned char>(f);
    const TreeTables::Class own = classes[b];
    bool cut = place == 0 || !(own == same);
    if (outer < 0) {
      cut = cut || planar;
      planar = in_a_plane(place);
      cut = cut || planar;
    }
    if (cut) {
      if (place > 0) tables_.runs.back().end = place;
      tables_.runs.push_back({.begin = place, .end = count, .kind = own.kind, .variant = own.variant, .planar = planar});
      record = shape(own.kind).record[static_cast<std::size_t>(own.variant)];
      same = own;
    }
    offsets[b].record = static_cast<std::uint32_t>(scalars);
    scalars += record;
  }
  MT_REQUIRE(scalars <= std::numeric_limits<std::uint32_t>::max(), "fewer than a few hundred million bodies");
  tables_.record_scalars = scalars;
  list_loaded_bodies();
  if (!loops_.joints.empty() || !coupling_ended_.empty()) list_loops();
}

// Allocates only the first time and after bodies were added.
void Tree::list_loaded_bodies() {
  loads_.bodies.clear();
  std::erase_if(contacts_, [this](const Contact& c) { return (c.a >= 0 && !alive(c.a)) || (c.b >= 0 && !alive(c.b)); });
  note_constraints();
  if (loads_.forces.empty() && loads_.functions.empty() && springs_.states.empty() && contacts_.empty()) return;
  loads_.bodies.reserve(at(bodies()));
  loaded_mark_.assign(at(bodies()), 0);
  const auto mark = [this](int body) {
    if (body < 0 || !alive(body)) return;
    for (int b = body; b >= 0 && loaded_mark_[at(b)] == 0; b = tables_.parent[at(b)]) loaded_mark_[at(b)] = 1;
  };
  for (const BodyForce& force : loads_.forces) mark(force.body.index);
  for (const Topology::Loaded& load : loads_.functions) mark(load.body);
  for (int s = 0; s < springs_.count(); ++s)
    if (spring_acts(*this, s)) mark(springs_[at(s)].from.body.index), mark(springs_[at(s)].to.body.index);
  for (const Contact& contact : contacts_) mark(contact.a), mark(contact.b);
  for (const int b : tables_.order)
    if (loaded_mark_[at(b)] != 0) loads_.bodies.push_back(b);
}

// Mass of b and all outboard bodies, from the subtree masses of its children.
void Tree::update_subtree_mass(int b) {
  double sum = tables_.links[at(b)].body.m;
  for (int c = first_child_[at(b)]; c >= 0; c = next_sibling_[at(c)]) sum += tables_.subtree_mass[at(c)];
  tables_.subtree_mass[at(b)] = sum;
}

void Tree::update_subtree_masses(int b) {
  for (; b >= 0; b = tables_.parent[at(b)]) update_subtree_mass(b);
}

}  // namespace momentree

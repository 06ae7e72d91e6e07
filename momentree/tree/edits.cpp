// Elementary edits from which topology changes are composed. Each updates everything it affects: offsets after a joint of another
// size, a block of the order, frames that depend on a joint, subtree masses inboard.
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

void Tree::unlink(int b) {
  const int outer = parent_[at(b)];
  int* head = outer < 0 ? &first_root_ : &first_child_[at(outer)];
  while (*head != b) head = &next_sibling_[at(*head)];
  *head = next_sibling_[at(b)];
}

// Siblings and roots are in ascending order, so that the order of evaluation depends on the topology, not on its history.
void Tree::add_child(int b, int parent) {
  int* head = parent < 0 ? &first_root_ : &first_child_[at(parent)];
  while (*head >= 0 && *head < b) head = &next_sibling_[at(*head)];
  next_sibling_[at(b)] = *head;
  *head = b;
  parent_[at(b)] = parent;
}

// Moves the subtree of b, at [begin, end) of the order so far, to b's new place.
void Tree::move_tree(int b, int begin, int end) {
  move_block(begin, end, end_of(b));
  build_runs();
}

void Tree::require_valid(const Joint& joint) const {
  MT_REQUIRE(joint.locked >> info(joint.kind).nv == 0, "a joint's locked degrees of freedom are those of its kind");
  MT_REQUIRE(joint.parameters < shared_parameters() + static_cast<int>(own_parameters_.size()),
             "a joint's parameters exist in the tree");
  MT_REQUIRE(joint.function < static_cast<int>(functions_.size()), "a joint's function exists in the tree");
}

// Returns whether the lists of special joints must be renewed.
bool Tree::replace_joint(int b, const Joint& joint, bool reversed) {
  MT_REQUIRE(!reversed || parent_[at(b)] >= 0, "the ground is not a joint's child");
  require_valid(joint);
  Joint& own = own_joint(joint_of_[at(b)]).joint;
  const Kind before = own.kind;
  own = joint;
  reversed_[at(b)] = reversed ? 1 : 0;
  return repack(b, before);
}

void Tree::detach(int b) {
  const int outer = parent_[index(b)];
  const bool was_first = outer >= 0 && first_child_[at(outer)] == b;
  const int begin = place_[at(b)], end = end_of(b);
  unlink(b);
  add_child(b, -1);
  if (replace_joint(b, floating_root_joint(), false)) list_special_joints();
  update_frames(b);
  if (was_first) renew_child_changed(outer);
  move_tree(b, begin, end);
  update_subtree_masses(outer);
  revision_.renew();
}

// From b up to the root, attaches each body's parent below it: joints keep their numbers and packed data, while the body that
// carries each joint changes to the next one inboard. Returns the old root.
int Tree::reverse_path(int b) {
  int root = b;
  while (parent_[at(root)] >= 0) root = parent_[at(root)];
  MT_REQUIRE(joint(root).kind == Kind::free, "the root is joined to the ground by a free joint");
  struct Carried {
    int joint, first_q, first_p, first_angle;
    unsigned char reversed;
  };
  const auto carried = [this](int a) -> Carried {
    return {joint_of_[at(a)], offsets_[at(a)].q, offsets_[at(a)].p, offsets_[at(a)].angle, reversed_[at(a)]};
  };
  Carried below = carried(root);
  for (int joined = -1, body = b; body >= 0;) {
    const int outer = parent_[at(body)];
    const Carried own = carried(body);
    unlink(body);
    add_child(body, joined);
    joint_of_[at(body)] = below.joint, carrier_[at(below.joint)] = body;
    offsets_[at(body)].q = below.first_q, offsets_[at(body)].p = below.first_p, offsets_[at(body)].angle = below.first_angle;
    reversed_[at(body)] = below.reversed;
    below = own;
    below.reversed = own.reversed != 0 ? 0 : 1;
    joined = body;
    body = outer;
  }
  return root;
}

void Tree::attach(int b, int parent, const Joint& joint, bool reversed) {
  int root = static_cast<int>(index(b));
  while (parent_[at(root)] >= 0) root = parent_[at(root)];
  MT_REQUIRE(parent >= ground.index, "the parent is a body or the ground");
  for (int a = parent; a >= 0; a = parent_[index(a)]) MT_REQUIRE(a != root, "the parent belongs to another tree");
  const int begin = place_[at(root)], end = end_of(root);
  reverse_path(b);
  if (parent >= 0) {
    unlink(b);
    add_child(b, parent);
  }
  if (replace_joint(b, joint, reversed) || root != b) list_special_joints();
  // Kernel frames are located at the carried joints: renew them from the old root to b, then all links that depend on them.
  // Welded bodies follow their new carrier.
  for (int a = root; a != b; a = parent_[at(a)]) pack(a);
  for (int a = root; a != b; a = parent_[at(a)])
    if (!is_welded(a)) make_frames(a);
  for (int a = root, below = -1; a != b; a = parent_[at(a)]) {
    if (is_welded(a)) continue;
    make_link(a);
    make_outboard_links(a, below);
    below = a;
  }
  update_frames(b);
  number_depth_first(b, begin);
  move_tree(b, begin, end);
  update_subtree_masses(root);
  revision_.renew();
}

void Tree::reroot(int b) { attach(b, -1, floating_root_joint(), false); }

void Tree::set_joint(int b, const Joint& joint, bool reversed) {
  MT_REQUIRE(alive(b), known_body);
  if (replace_joint(b, joint, reversed)) list_special_joints();
  update_frames(b);
  build_runs();
  revision_.renew();
}

void Tree::set_gravity(const Vec3& gravity) {
  MT_REQUIRE(is_finite(gravity), "a finite gravity");
  gravity_ = gravity;
  revision_.renew();
}

void Tree::set_parameters(int b, const JointParameters& parameters) {
  const int number = give_parameters(joint_of_[index(b)], parameters);
  Joint joint = this->joint(b);
  joint.parameters = number;
  if (replace_joint(b, joint, reversed(b))) list_special_joints();
  if (kind(b) == Kind::free) update_frames(b);  // it depends on the armature
  build_runs();
  revision_.renew();
}

// The number of a joint's function, which had the number given, or −1.
int Tree::renewed_function(int number, std::shared_ptr<const JointFunction> function) {
  if (function == nullptr) return -1;
  if (number >= 0) {  // a stored topology has its own list
    functions_[at(number)] = std::move(function);
    return number;
  }
  functions_.push_back(std::move(function));
  return static_cast<int>(functions_.size()) - 1;
}

void Tree::set_function(int b, std::shared_ptr<const JointFunction> function) {
  Joint joint = this->joint(b);
  joint.function = renewed_function(joint.function, std::move(function));
  if (replace_joint(b, joint, reversed(b))) list_special_joints();
  revision_.renew();
}

void Tree::set_body_function(int b, std::shared_ptr<const BodyFunction> function) {
  MT_REQUIRE(alive(b), known_body);
  std::erase_if(body_functions_, [b](const Topology::Loaded& load) { return load.body == b; });
  if (function != nullptr) body_functions_.push_back({b, std::move(function)});
  list_loaded_bodies();
  revision_.renew();
}

void Tree::remove(int b) {
  MT_REQUIRE(alive(b) && parent_[at(b)] < 0, "the body is a root");
  const int begin = place_[at(b)], end = end_of(b);
  unlink(b);
  for (int place = begin; place < end; ++place) {
    const auto x = at(order_[at(place)]);
    carrier_[at(joint_of_[x])] = -1;
    joint_of_[x] = parent_[x] = first_child_[x] = next_sibling_[x] = -1;
  }
  order_.erase(order_.begin() + begin, order_.begin() + end);
  pack_all();
  build_runs();
  revision_.renew();
}

int Tree::add(const BodySpec& spec) {
  const int b = bodies(), outer = spec.parent.index;
  MT_REQUIRE(outer == ground.index || alive(outer), "the parent is the ground or a body of this tree");
  resize(b + 1);
  added_masses_.push_back({spec.mass, spec.com, spec.inertia});
  parent_[at(b)] = outer;
  joint_of_[at(b)] = carrier_[at(b)] = b;
  joint_at_[at(b)] = no_joint;
  Joint joint = detail::joint_of(spec);
  if (const JointParameters& p = spec.joint.parameters; p.any()) joint.parameters = give_parameters(b, p);
  own_joint(b).joint = joint;
  add_child(b, outer);
  order_.insert(order_.begin() + end_of(b), b);
  assign_offsets(b);
  pack(b);
  list_special_joints();
  update_frames(b);
  put_locks(b);  // it had no link before
  build_runs();
  update_subtree_masses(b);
  revision_.renew();
  return b;
}

Tree::OwnJoint& Tree::own_joint(int joint) {
  int& number = joint_at_[at(joint)];
  if (number >= 0) {  // allocates the joint's own entry, once; the capacity is reserved at the start
    OwnJoint own;
    if (number != no_joint) own.joint = declared_->joints[at(number)];
    number = ~static_cast<int>(own_joints_.size());
    own_joints_.push_back(own);
  }
  return own_joints_[at(~number)];
}

// Returns the index of the parameters.
int Tree::give_parameters(int joint, const JointParameters& parameters) {
  OwnJoint& own = own_joint(joint);
  if (own.parameters < 0) {
    own.parameters = static_cast<int>(own_parameters_.size());
    own_parameters_.emplace_back();
    own_dofs_.emplace_back();
  }
  own_parameters_[at(own.parameters)] = parameters;
  own_dofs_[at(own.parameters)] = detail::spread(parameters);
  return shared_parameters() + own.parameters;
}

}  // namespace momentree

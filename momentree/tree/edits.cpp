// Elementary edits from which topology changes are composed. Each updates everything it affects: offsets after a joint of another
// size, a block of the order, frames that depend on a joint, subtree masses inboard.
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

void Tree::unlink(int b) {
  const int outer = tables_.parent[at(b)];
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
  tables_.parent[at(b)] = parent;
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
  MT_REQUIRE(!reversed || tables_.parent[at(b)] >= 0, "the ground is not a joint's child");
  require_valid(joint);
  Joint& own = own_joint(joint_of_[at(b)]).joint;
  const Kind before = own.kind;
  own = joint;
  reversed_[at(b)] = reversed ? 1 : 0;
  return repack(b, before);
}

void Tree::Edit::detach(int b) {
  const int outer = tree_.tables_.parent[tree_.index(b)];
  const bool was_first = outer >= 0 && tree_.first_child_[at(outer)] == b;
  const int begin = tree_.place_[at(b)], end = tree_.end_of(b);
  tree_.unlink(b);
  tree_.add_child(b, -1);
  if (tree_.replace_joint(b, floating_root_joint(), false)) tree_.list_special_joints();
  tree_.update_frames(b);
  if (was_first) tree_.renew_child_changed(outer);
  tree_.move_tree(b, begin, end);
  tree_.update_subtree_masses(outer);
  tree_.revision_.renew();
}

// From b up to the root, attaches each body's parent below it: joints keep their numbers and packed data, while the body that
// carries each joint changes to the next one inboard. Returns the old root.
int Tree::reverse_path(int b) {
  int root = b;
  while (tables_.parent[at(root)] >= 0) root = tables_.parent[at(root)];
  MT_REQUIRE(joint(root).kind == Kind::free, "the root is joined to the ground by a free joint");
  struct Carried {
    int joint, first_q, first_p, first_angle;
    unsigned char reversed;
  };
  const auto carried = [this](int a) -> Carried {
    return {joint_of_[at(a)], tables_.offsets[at(a)].q, tables_.offsets[at(a)].p, tables_.offsets[at(a)].angle, reversed_[at(a)]};
  };
  Carried below = carried(root);
  for (int joined = -1, body = b; body >= 0;) {
    const int outer = tables_.parent[at(body)];
    const Carried own = carried(body);
    unlink(body);
    add_child(body, joined);
    joint_of_[at(body)] = below.joint, carrier_[at(below.joint)] = body;
    tables_.offsets[at(body)].q = below.first_q, tables_.offsets[at(body)].p = below.first_p,
    tables_.offsets[at(body)].angle = below.first_angle;
    reversed_[at(body)] = below.reversed;
    below = own;
    below.reversed = own.reversed != 0 ? 0 : 1;
    joined = body;
    body = outer;
  }
  return root;
}

void Tree::Edit::attach(int b, int parent, const Joint& joint, bool reversed) {
  int root = static_cast<int>(tree_.index(b));
  while (tree_.tables_.parent[at(root)] >= 0) root = tree_.tables_.parent[at(root)];
  MT_REQUIRE(parent >= ground.index, "the parent is a body or the ground");
  for (int a = parent; a >= 0; a = tree_.tables_.parent[tree_.index(a)])
    MT_REQUIRE(a != root, "the parent belongs to another tree");
  const int begin = tree_.place_[at(root)], end = tree_.end_of(root);
  tree_.reverse_path(b);
  if (parent >= 0) {
    tree_.unlink(b);
    tree_.add_child(b, parent);
  }
  if (tree_.replace_joint(b, joint, reversed) || root != b) tree_.list_special_joints();
  // Kernel frames are located at the carried joints: renew them from the old root to b, then all links that depend on them.
  // Welded bodies follow their new carrier.
  for (int a = root; a != b; a = tree_.tables_.parent[at(a)]) tree_.pack(a);
  for (int a = root; a != b; a = tree_.tables_.parent[at(a)])
    if (!tree_.is_welded(a)) tree_.make_frames(a);
  for (int a = root, below = -1; a != b; a = tree_.tables_.parent[at(a)]) {
    if (tree_.is_welded(a)) continue;
    tree_.make_link(a);
    tree_.make_outboard_links(a, below);
    below = a;
  }
  tree_.update_frames(b);
  tree_.number_depth_first(b, begin);
  tree_.move_tree(b, begin, end);
  tree_.update_subtree_masses(root);
  tree_.revision_.renew();
}

void Tree::Edit::reroot(int b) { attach(b, -1, floating_root_joint(), false); }

void Tree::Edit::set_joint(int b, const Joint& joint, bool reversed) {
  MT_REQUIRE(tree_.alive(b), known_body);
  if (tree_.replace_joint(b, joint, reversed)) tree_.list_special_joints();
  tree_.update_frames(b);
  tree_.build_runs();
  tree_.revision_.renew();
}

void Tree::Edit::set_gravity(const Vec3& gravity) {
  MT_REQUIRE(is_finite(gravity), "a finite gravity");
  tree_.gravity_ = gravity;
  tree_.revision_.renew();
}

void Tree::Edit::set_parameters(int b, const JointParameters& parameters) {
  const int number = tree_.give_parameters(tree_.joint_of_[tree_.index(b)], parameters);
  Joint joint = tree_.joint(b);
  joint.parameters = number;
  if (tree_.replace_joint(b, joint, tree_.reversed(b))) tree_.list_special_joints();
  if (tree_.kind(b) == Kind::free) tree_.update_frames(b);  // it depends on the armature
  tree_.build_runs();
  tree_.revision_.renew();
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

void Tree::Edit::set_function(int b, std::shared_ptr<const JointFunction> function) {
  Joint joint = tree_.joint(b);
  joint.function = tree_.renewed_function(joint.function, std::move(function));
  if (tree_.replace_joint(b, joint, tree_.reversed(b))) tree_.list_special_joints();
  tree_.revision_.renew();
}

void Tree::Edit::set_body_function(int b, std::shared_ptr<const BodyFunction> function) {
  MT_REQUIRE(tree_.alive(b), known_body);
  std::erase_if(tree_.loads_.functions, [b](const Topology::Loaded& load) { return load.body == b; });
  if (function != nullptr) tree_.loads_.functions.push_back({b, std::move(function)});
  tree_.list_loaded_bodies();
  tree_.revision_.renew();
}

void Tree::Edit::remove(int b) {
  MT_REQUIRE(tree_.alive(b) && tree_.tables_.parent[at(b)] < 0, "the body is a root");
  const int begin = tree_.place_[at(b)], end = tree_.end_of(b);
  tree_.unlink(b);
  for (int place = begin; place < end; ++place) {
    const auto x = at(tree_.tables_.order[at(place)]);
    tree_.carrier_[at(tree_.joint_of_[x])] = -1;
    tree_.joint_of_[x] = tree_.tables_.parent[x] = tree_.first_child_[x] = tree_.next_sibling_[x] = -1;
  }
  tree_.tables_.order.erase(tree_.tables_.order.begin() + begin, tree_.tables_.order.begin() + end);
  tree_.pack_all();
  tree_.build_runs();
  tree_.revision_.renew();
}

int Tree::Edit::add(const BodySpec& spec) {
  const int b = tree_.bodies(), outer = spec.parent.index;
  MT_REQUIRE(outer == ground.index || tree_.alive(outer), "the parent is the ground or a body of this tree");
  tree_.resize(b + 1);
  tree_.added_masses_.push_back({spec.mass, spec.com, spec.inertia});
  tree_.tables_.parent[at(b)] = outer;
  tree_.joint_of_[at(b)] = tree_.carrier_[at(b)] = b;
  tree_.joint_at_[at(b)] = no_joint;
  Joint joint = detail::joint_of(spec);
  if (const JointParameters& p = spec.joint.parameters; p.any()) joint.parameters = tree_.give_parameters(b, p);
  tree_.own_joint(b).joint = joint;
  tree_.add_child(b, outer);
  tree_.tables_.order.insert(tree_.tables_.order.begin() + tree_.end_of(b), b);
  tree_.assign_offsets(b);
  tree_.pack(b);
  tree_.list_special_joints();
  tree_.update_frames(b);
  tree_.put_locks(b);  // it had no link before
  tree_.build_runs();
  tree_.update_subtree_masses(b);
  tree_.revision_.renew();
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

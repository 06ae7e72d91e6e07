// The edits that changes of topology are made of. Each puts right what it moved: offsets behind a joint of another size, a block
// of the order, the frames that look to a joint, the masses inboard.
#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

void Tree::unlink(int b) {
  const int outer = parent_[at(b)];
  int* head = outer < 0 ? &first_root_ : &first_child_[at(outer)];
  while (*head != b) head = &next_sibling_[at(*head)];
  *head = next_sibling_[at(b)];
}

// Siblings and roots stand in ascending order: the order of evaluation is that of the topology, not of its history.
void Tree::hang(int b, int parent) {
  int* head = parent < 0 ? &first_root_ : &first_child_[at(parent)];
  while (*head >= 0 && *head < b) head = &next_sibling_[at(*head)];
  next_sibling_[at(b)] = *head;
  *head = b;
  parent_[at(b)] = parent;
}

// What hangs on b stood at [begin, end) of the order: it moves to where b hangs now.
void Tree::move_tree(int b, int begin, int end) {
  move_block(begin, end, end_of(b));
  arrange();
}

// Returns whether the lists of joints are to be renewed.
bool Tree::replace_joint(int b, const Joint& joint, bool reversed) {
  MT_REQUIRE(!reversed || parent_[at(b)] >= 0, "the ground is nobody's child");
  Joint& own = joints_[at(joint_of_[at(b)])];
  const Kind before = own.kind;
  own = joint;
  changed_[at(joint_of_[at(b)])] = 1;
  reversed_[at(b)] = reversed ? 1 : 0;
  return repack(b, before);
}

void Tree::detach(int b) {
  const int outer = parent_[at(b)];
  const bool was_first = outer >= 0 && first_child_[at(outer)] == b;
  const int begin = place_[at(b)], end = end_of(b);
  unlink(b);
  hang(b, -1);
  if (replace_joint(b, made_free_joint(), false)) list_special_joints();
  renew(b);
  if (was_first) renew_child_changed(outer);
  move_tree(b, begin, end);
  weigh_path(outer);
  ++revision_;
}

// From b up to the root, each body's parent is hung below it: joints keep their numbers and what is packed for them, carriers
// move one body inboard. Returns the old root.
int Tree::turn_over(int b) {
  int root = b;
  while (parent_[at(root)] >= 0) root = parent_[at(root)];
  MT_REQUIRE(joint(root).kind == Kind::free, "the root hangs on a free joint");
  struct Carried {
    int joint, first_q, first_p, first_angle;
    unsigned char reversed;
  };
  const auto carried = [this](int a) -> Carried {
    return {joint_of_[at(a)], first_q_[at(a)], first_p_[at(a)], first_angle_[at(a)], reversed_[at(a)]};
  };
  Carried below = carried(root);
  for (int hung = -1, body = b; body >= 0;) {
    const int outer = parent_[at(body)];
    const Carried own = carried(body);
    unlink(body);
    hang(body, hung);
    joint_of_[at(body)] = below.joint, carrier_[at(below.joint)] = body;
    first_q_[at(body)] = below.first_q, first_p_[at(body)] = below.first_p, first_angle_[at(body)] = below.first_angle;
    reversed_[at(body)] = below.reversed;
    below = own;
    below.reversed = own.reversed != 0 ? 0 : 1;
    hung = body;
    body = outer;
  }
  return root;
}

void Tree::attach(int b, int parent, const Joint& joint, bool reversed) {
  int root = b;
  while (parent_[at(root)] >= 0) root = parent_[at(root)];
  const int begin = place_[at(root)], end = end_of(root);
  turn_over(b);
  if (parent >= 0) {
    unlink(b);
    hang(b, parent);
  }
  if (replace_joint(b, joint, reversed) || root != b) list_special_joints();
  // Frames stand at the joints carried: renewed from the old root to b; then every link that touches them.
  for (int a = root; a != b; a = parent_[at(a)]) {
    pack(a);
    make_frame(a);
  }
  for (int a = root, below = -1; a != b; below = a, a = parent_[at(a)]) {
    make_link(a);
    for (int c = first_child_[at(a)]; c >= 0; c = next_sibling_[at(c)])
      if (c != below) make_link(c);
  }
  renew(b);
  walk(b, begin);
  move_tree(b, begin, end);
  weigh_path(root);
  ++revision_;
}

void Tree::reroot(int b) { attach(b, -1, made_free_joint(), false); }

void Tree::set_joint(int b, const Joint& joint, bool reversed) {
  if (replace_joint(b, joint, reversed)) list_special_joints();
  renew(b);
  arrange();
  ++revision_;
}

void Tree::set_parameters(int b, const JointParameters& parameters) {
  const int j = joint_of_[at(b)];
  give_parameters(j, parameters);
  Joint joint = joints_[at(j)];
  joint.parameters = own_parameters_[at(j)];
  if (replace_joint(b, joint, reversed(b))) list_special_joints();
  arrange();
  ++revision_;
}

void Tree::set_function(int b, std::shared_ptr<const JointFunction> function) {
  Joint joint = this->joint(b);
  if (function == nullptr) {
    joint.function = -1;
  } else if (joint.function >= 0) {  // a topology that was kept has a list of its own
    functions_[at(joint.function)] = std::move(function);
  } else {
    joint.function = static_cast<int>(functions_.size());
    functions_.push_back(std::move(function));
  }
  if (replace_joint(b, joint, reversed(b))) list_special_joints();
  ++revision_;
}

void Tree::set_body_function(int b, std::shared_ptr<const BodyFunction> function) {
  std::erase_if(body_functions_, [b](const Topology::Loaded& load) { return load.body == b; });
  if (function != nullptr) body_functions_.push_back({b, std::move(function)});
  list_loaded_bodies();
  ++revision_;
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
  arrange();
  ++revision_;
}

int Tree::add(const BodySpec& spec) {
  const int b = bodies(), outer = spec.parent.index;
  MT_REQUIRE(outer < b && (outer < 0 || alive(outer)), "the parent is there");
  resize(b + 1);
  set_body(b, spec);
  changed_[at(b)] = 1;
  const JointParameters& p = spec.joint.parameters;
  if (p.any()) {
    give_parameters(b, p);
    joints_[at(b)].parameters = own_parameters_[at(b)];
  }
  hang(b, outer);
  order_.insert(order_.begin() + end_of(b), b);
  const KindShape& kind = shape(spec.joint.kind);
  first_q_[at(b)] = nq_, first_p_[at(b)] = nv_, first_angle_[at(b)] = angles_;
  nq_ += kind.nq, nv_ += kind.nv, angles_ += kind.angles;
  pack(b);
  list_special_joints();
  renew(b);
  arrange();
  weigh_path(b);
  ++revision_;
  return b;
}

void Tree::give_parameters(int joint, const JointParameters& parameters) {
  int& own = own_parameters_[at(joint)];
  if (own < 0) {  // the joint's own place, once and for all: reserved at the start
    own = static_cast<int>(parameters_.size());
    parameters_.emplace_back();
    per_freedom_.emplace_back();
  }
  parameters_[at(own)] = parameters;
  per_freedom_[at(own)] = spread(parameters);
}

Tree::PerFreedom Tree::spread(const JointParameters& parameters) {
  PerFreedom f;
  for (int i = 0; i < 6; ++i) {
    f.armature[at(i)] = parameters.armature.of(i);
    f.damping[at(i)] = parameters.damping.of(i);
    f.effort[at(i)] = parameters.effort.of(i);
  }
  f.rotor = parameters.armature.any();
  f.spring = parameters.stiffness.any();
  f.force = parameters.damping.any() || parameters.effort.any();
  const JointDrive* drive = parameters.drive.get();
  f.motion = drive != nullptr && drive->moves();
  f.drive = parameters.friction.any() || parameters.limits.soft() || (drive != nullptr && !f.motion);
  f.strength = parameters.strength.any();
  return f;
}

}  // namespace momentree

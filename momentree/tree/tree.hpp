#pragma once
// The compiled topology: one forest of flat arrays. Body numbers never change; a change relinks order and offsets. A mechanism
// breaks off by making the ground the parent of its root.
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/reserved.hpp>
#include <momentree/base/unique_number.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/joint/variant.hpp>
#include <momentree/model/model.hpp>
#include <momentree/tree/contact.hpp>
#include <momentree/tree/declared.hpp>
#include <momentree/tree/parts/loads.hpp>
#include <momentree/tree/parts/tables.hpp>
#include <momentree/tree/parts/topology.hpp>
#include <momentree/tree/parts/tree_loops.hpp>

namespace momentree {

struct LinkConstants;

/// A value type: copies are independent, and several threads may read a const tree at once.
class Tree {
 public:
  Tree();
  Tree(const Tree& other);
  Tree(Tree&& other) noexcept;
  Tree& operator=(const Tree& other);
  Tree& operator=(Tree&& other) noexcept;
  ~Tree();
  /// Compiles a model. Reserves storage for every later topology: no change allocates.
  explicit Tree(const Model& model);

  /// Number of bodies so far, including removed ones, which keep their numbers.
  int bodies() const { return static_cast<int>(tables_.parent.size()); }
  /// False for an unused number and for a removed body: any other query of it stops the program.
  bool alive(int b) const { return at(b) < joint_of_.size() && joint_of_[at(b)] >= 0; }
  /// Index of body b in lists by body; b must be alive.
  std::size_t index(int b) const {
    MT_REQUIRE(alive(b), known_body);
    return at(b);
  }
  int nq() const { return nq_; }
  int nv() const { return nv_; }
  const Vec3& gravity() const { return gravity_; }
  /// Identifies the present form of this tree: each compiled tree and each change of one gets a number that is unique in this
  /// process. Copies share it, because they are equal. A State belongs to the tree of one revision.
  std::uint64_t revision() const { return revision_.number(); }

  int parent(int b) const { return tables_.parent[index(b)]; }
  int first_child(int b) const { return first_child_[index(b)]; }
  int next_sibling(int b) const { return next_sibling_[index(b)]; }
  int first_root() const { return first_root_; }
  /// Offsets of the joint's coordinates in q, and of its DoFs in p.
  int first_q(int b) const { return tables_.offsets[index(b)].q; }
  int first_p(int b) const { return tables_.offsets[index(b)].p; }
  const LinkConstants& link(int b) const { return tables_.links[index(b)]; }
  /// Mass of body b and all bodies outboard of it (kg).
  double subtree_mass(int b) const { return tables_.subtree_mass[index(b)]; }
  /// The inboard joint of body b. Joints have their own numbers, initially that of their child; re-rooting makes a body carry
  /// another joint, in reverse.
  const Joint& joint(int b) const { return numbered_joint(joint_of_[index(b)]); }
  /// Its kind, from a compact table.
  Kind kind(int b) const { return tables_.classes[index(b)].kind; }
  int joint_of(int b) const { return joint_of_[index(b)]; }
  /// The body that carries a joint, by the joint's number; −1: removed with its body.
  int carrier(int joint) const {
    MT_REQUIRE(at(joint) < carrier_.size(), "the tree has a joint of that number");
    return carrier_[at(joint)];
  }
  /// The same for handles; stops the program for a joint that is not in the tree.
  BodyId carrier(JointId joint) const {
    MT_REQUIRE(at(joint.index) < carrier_.size() && carrier_[at(joint.index)] >= 0, "the joint is in the tree");
    return {carrier_[at(joint.index)]};
  }
  /// The joint that a body carries.
  JointId inboard_joint(BodyId body) const { return {joint_of(body.index)}; }
  bool reversed(int b) const { return reversed_[index(b)] != 0; }
  Variant variant(int b) const { return tables_.classes[index(b)].variant; }
  const KernelFrame& frame(int b) const;
  /// Parameters of b's joint, or null.
  const JointParameters* parameters(int b) const {
    const int i = joint(b).parameters;
    if (i < 0) return nullptr;
    const int own = i - shared_parameters();
    return own < 0 ? &declared_->parameters[at(i)] : &own_parameters_[at(own)];
  }
  /// Number of distinct parameters of the model's joints; the indices of parameters set by changes start there.
  int shared_parameters() const { return declared_ ? static_cast<int>(declared_->parameters.size()) : 0; }
  /// The function that drives a joint of the tree or a loop joint, or null.
  const JointFunction* function(const Joint& joint) const {
    return joint.function < 0 ? nullptr : functions_[at(joint.function)].get();
  }
  const JointFunction* function(int b) const { return function(joint(b)); }

  /// Place of body b in the order.
  int place(int b) const { return place_[index(b)]; }
  /// Depth-first, inboard before outboard; siblings and roots in ascending order of numbers.
  std::span<const int> order() const { return tables_.order; }
  /// The arrays themselves: reading them checks nothing.
  const TreeTables& tables() const { return tables_; }
  const SpecialJoints& joints_with() const { return special_joints_; }
  const TreeLoads& loads() const { return loads_; }
  const TreeSprings& springs() const { return springs_; }
  const TreeLoops& loops() const { return loops_; }
  /// True with loop joints or couplings that act.
  bool has_loops() const { return !loops_.links.empty(); }
  /// The couplings of the model. One acts until a joint of it breaks, leaves the world, or no longer has one DoF; it never acts
  /// again.
  std::span<const Coupling> couplings() const {
    return declared_ ? std::span<const Coupling>(declared_->couplings) : std::span<const Coupling>();
  }
  bool coupling_acts(int coupling) const { return coupling_ended_[at(coupling)] == 0; }
  /// The contacts that are closed.
  std::span<const Contact> contacts() const { return contacts_; }
  /// True if there are loops, contacts or driven joints: evaluations then do more than the passes over the tree.
  bool has_constraints() const { return has_constraints_; }

  /// The difference from the compiled model.
  [[nodiscard]] Topology topology() const;

  /// Write access: the edits of which topology changes are composed (tree/edit.hpp).
  class Edit;
  Edit edit();

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static constexpr const char* known_body = "the tree has a body of that number, and it was not removed";

  // frames.cpp
  bool is_welded(int b) const { return tables_.classes[at(b)].kind == Kind::weld; }
  template <class F>
  void for_rigid(int b, const F& f) const;
  int carrier_of(int b) const;
  void make_frame(int b);
  void set_mass_properties(int b, LinkConstants& link) const;
  void make_link(int b);
  void make_frames(int b);
  void make_outboard_links(int b, int but = -1);
  void update_frames(int b);
  bool renew_child_changed(int b);

  void classify(int b);

  void resize(int bodies);

  // relink.cpp: everything that follows from parents, joints and directions.
  void link_all(detail::LinkCollector* collector = nullptr);
  void pack_all();
  void assign_offsets(int b);
  void pack(int b);
  const detail::DofParameters& dof_parameters(const Joint& joint) const;
  struct Locks {
    unsigned char locked, driven;
  };
  Locks locks_of(int b) const;
  void put_locks(int b);
  bool repack(int b, Kind before);
  void list_special_joints();
  int number_depth_first(int root, int place);
  void build_runs();

  // planes.cpp
  bool in_a_plane(int place) const;

  void cut_runs();
  void update_subtree_mass(int b);
  void update_subtree_masses(int b);
  int end_of(int b) const;
  void move_block(int begin, int end, int to);

  void list_loaded_bodies();
  void list_loops();
  void list_couplings();
  void note_constraints() { has_constraints_ = !special_joints_.motions.empty() || !loops_.links.empty() || !contacts_.empty(); }

  // springs.cpp
  void put_springs(const std::vector<Topology::SpringChange>& changes);

  // edits.cpp
  void unlink(int b);
  void add_child(int b, int parent);
  void move_tree(int b, int begin, int end);
  bool replace_joint(int b, const Joint& joint, bool reversed);
  int reverse_path(int b);
  int give_parameters(int joint, const JointParameters& parameters);
  void require_valid(const Joint& joint) const;
  void require_valid(const Topology& topology) const;

  // Joints by number: the model's or the tree's own.
  struct OwnJoint {
    Joint joint;
    int parameters = -1;  // index of the joint's own parameters, once they were set
  };
  const Joint& numbered_joint(int joint) const {
    const int i = joint_at_[at(joint)];
    return i >= 0 ? declared_->joints[at(i)] : own_joints_[at(~i)].joint;
  }
  OwnJoint& own_joint(int joint);
  static constexpr int no_joint = std::numeric_limits<int>::max();  // marks a joint of a removed body that the model did not have
  std::size_t declared_bodies() const { return declared_ ? declared_->bodies.size() : 0; }
  bool joint_as_declared(int b) const;
  bool frame_as_declared(int b) const;
  const MassProperties& mass(int b) const;
  void collect(int b, detail::LinkCollector& collector);

  Vec3 gravity_{};
  int nq_ = 0, nv_ = 0, angles_ = 0, first_root_ = -1;
  detail::Version revision_;
  std::shared_ptr<const detail::Declared> declared_;
  TreeTables tables_;
  // By body, or by joint if stated.
  std::vector<int> first_child_, next_sibling_;
  std::vector<int> place_;  // place in the order
  std::vector<int> joint_of_;
  std::vector<int> carrier_, joint_at_;  // by joint; the second: index of the declared joint, or ~index of the tree's own
  std::vector<unsigned char> reversed_;
  detail::Reserved<OwnJoint> own_joints_;
  std::vector<MassProperties> added_masses_;
  detail::Reserved<JointParameters> own_parameters_;  // set by changes for one joint, in the order in which they were set
  detail::Reserved<detail::DofParameters> own_dofs_;
  SpecialJoints special_joints_;
  std::vector<std::shared_ptr<const JointFunction>> functions_;  // in the order in which they were set
  std::vector<unsigned char> special_;                           // by joint: a bit each for a spring, a quaternion, a force, …
  bool has_constraints_ = false;
  TreeLoads loads_;
  std::vector<unsigned char> loaded_mark_;  // scratch, by body
  TreeSprings springs_;
  TreeLoops loops_;
  std::vector<Contact> contacts_;
  std::vector<unsigned char> coupling_ended_;  // by coupling
  void count_loop_functions();
  int renewed_function(int number, std::shared_ptr<const JointFunction> function);
};

/// True if a function drives a joint at present, not merely earlier.
inline bool has_functions(const Tree& tree) { return tree.joints_with().functions || tree.loops().functions > 0; }

/// True for a body with a root joint made by a change; that joint is named after the body.
inline bool is_detached(const Tree& tree, int b) { return tree.joint(b).created_by_event; }

/// True for a body that floats on the ground, whose kernel frame is at its centre of mass. Not with armature or locked DoFs,
/// whose joint-space mass belongs to the joint's own origin.
inline bool at_centre_of_mass(const Tree& tree, int b) {
  return tree.kind(b) == Kind::free && tree.variant(b) == Variant::plain && tree.parent(b) < 0;
}

/// The prescribed motion of b's joint, which must have one.
inline const Curve& prescribed_motion(const Tree& tree, int b) {
  const JointParameters* const p = tree.parameters(b);
  MT_REQUIRE(p != nullptr && p->drive != nullptr && p->drive->moves(), "the joint's motion is prescribed");
  return p->drive->motion.front();
}

/// False for a spring that is broken or was attached to a body that was removed.
inline bool spring_acts(const Tree& tree, int spring) {
  if (tree.springs().broken(spring)) return false;
  const Spring& s = tree.springs()[static_cast<std::size_t>(spring)];
  const auto holds = [&tree](BodyId body) { return body == ground || tree.alive(body.index); };
  return holds(s.from.body) && holds(s.to.body);
}
/// True if a spring that acts has a strength.
bool has_spring_strengths(const Tree& tree);

/// The first instant (s) after t at which a table of a drive or force has a kink; infinite if there is none. Steps must not cross
/// it.
double next_bend(const Tree& tree, double t);
/// The shortest period of the sines of drives and forces (s); infinite without any.
double shortest_period(const Tree& tree);

/// Compiles a model: `Tree tree = compile(model)`.
[[nodiscard]] inline Tree compile(const Model& model) { return Tree(model); }

/// Joints at which the joint-space mass is singular at these coordinates (nq numbers, order of State::q).
std::vector<SingularJoint> singular_joints(const Tree& tree, std::span<const double> coordinates);

}  // namespace momentree

#pragma once
// The compiled topology: one forest of flat arrays. Body numbers never change; a change relinks order and offsets. A mechanism
// breaks off by making the ground the parent of its root.
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/unique_number.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/joint/variant.hpp>
#include <momentree/model/model.hpp>
#include <momentree/tree/contact.hpp>
#include <momentree/tree/declared.hpp>
#include <momentree/tree/loop.hpp>

namespace momentree {

/// A drive as a function of the world: called at every stage of a step with one zero per DoF, to be set to the efforts (N m, N).
/// Must not throw; its result may depend only on the evaluation context.
using JointFunction = std::function<void(const EvaluationContext&, std::span<double>)>;

/// A topology as its difference from the compiled model: a small value. Everything else in a Tree follows from it and the model,
/// bit for bit, whatever changes led to it.
struct Topology {
  /// Attachment of a body: its parent (−1: the ground), the inboard joint that it carries (−1: the body was removed), and whether
  /// that joint is reversed.
  struct Place {
    int parent = -1, joint = -1;
    bool reversed = false;
  };
  /// A joint that differs from the model's, and its number.
  struct Changed {
    int joint = -1;
    Joint as{};
  };
  /// Parameters that a change set for one joint.
  struct Own {
    int joint = -1;
    JointParameters parameters{};
  };
  /// A function that acts on a body.
  struct Loaded {
    int body = -1;
    std::shared_ptr<const BodyFunction> function;
  };
  /// A spring that broke, or that has another law than the model's.
  struct SpringChange {
    int spring = -1;
    bool broken = false;
    SpringLaw law{};
    friend bool operator==(const SpringChange&, const SpringChange&) = default;
  };
  std::vector<Place> places;                                    ///< by body
  std::vector<Changed> changed;                                 ///< in the order of joint numbers
  std::vector<Own> own;                                         ///< in the order in which they were set
  std::vector<MassProperties> added;                            ///< of bodies added after compilation
  std::vector<std::shared_ptr<const JointFunction>> functions;  ///< drives, indexed by Joint::function
  std::vector<Loaded> loads;                                    ///< at most one per body
  std::vector<Loop> loops;                                      ///< all loop joints, the model's too
  std::vector<SpringChange> springs;                            ///< in the order of spring numbers
  std::vector<int> ended_couplings;                             ///< in ascending order
  std::vector<Contact> contacts;                                ///< that are closed
  std::uint64_t model = 0;                                      ///< fingerprint of the model
};

/// The free joint of a body that broke off, at the identity: its coordinates are the pose of the body's user frame.
inline Joint floating_root_joint() {
  Joint joint;
  joint.kind = Kind::free;
  joint.created_by_event = true;
  return joint;
}

struct KernelRun;
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
  int bodies() const { return static_cast<int>(parent_.size()); }
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
  /// The same for its loops and couplings: their equations, and the bodies between their ends and the ground. It may change
  /// more often than these do.
  std::uint64_t loop_revision() const { return loop_revision_.number(); }

  int parent(int b) const { return parent_[index(b)]; }
  int first_child(int b) const { return first_child_[index(b)]; }
  int next_sibling(int b) const { return next_sibling_[index(b)]; }
  int first_root() const { return first_root_; }
  int first_q(int b) const { return offsets_[index(b)].q; }
  int first_p(int b) const { return offsets_[index(b)].p; }
  int first_angle(int b) const { return offsets_[index(b)].angle; }
  /// Offset of the body's record in Workspace::records, in scalars.
  std::size_t record(int b) const { return offsets_[index(b)].record; }
  const LinkConstants& link(int b) const { return links_[index(b)]; }
  /// Mass of body b and all bodies outboard of it (kg).
  double subtree_mass(int b) const { return subtree_mass_[index(b)]; }
  /// The inboard joint of body b. Joints have their own numbers, initially that of their child; re-rooting makes a body carry
  /// another joint, in reverse.
  const Joint& joint(int b) const { return numbered_joint(joint_of_[index(b)]); }
  /// Its kind, from a compact table.
  Kind kind(int b) const { return class_[index(b)].kind; }
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
  Variant variant(int b) const { return class_[index(b)].variant; }
  const KernelFrame& frame(int b) const;
  /// True for a body that floats on the ground, whose kernel frame is at its centre of mass. Not with armature or locked DoFs,
  /// whose joint-space mass belongs to the joint's own origin.
  bool at_centre_of_mass(int b) const;
  /// Parameters of b's joint, or null.
  const JointParameters* parameters(int b) const {
    const int i = joint(b).parameters;
    if (i < 0) return nullptr;
    const int own = i - shared_parameters();
    return own < 0 ? &declared_->parameters[at(i)] : &own_parameters_[at(own)];
  }
  /// Number of distinct parameters of the model's joints; the indices of parameters set by changes start there.
  int shared_parameters() const { return declared_ ? static_cast<int>(declared_->parameters.size()) : 0; }
  /// True for a body with a root joint made by a change; that joint is named after the body.
  bool detached(int b) const { return joint(b).created_by_event; }

  /// Place of body b in the order.
  int place(int b) const { return place_[index(b)]; }
  /// Depth-first, inboard before outboard; siblings and roots in ascending order of numbers.
  std::span<const int> order() const { return order_; }
  std::span<const KernelRun> kernel_runs() const;
  /// Flags of the bodies in the order: see namespace node.
  std::span<const unsigned char> node_flags() const { return node_flags_; }
  std::size_t record_scalars() const { return record_scalars_; }
  /// Angles of all joints: index into q, and the offset θ0 added to it.
  std::span<const int> angle_coordinates() const { return angle_q_; }
  std::span<const double> angle_offsets() const { return angle_offset_; }
  /// Armature per DoF (kg m², kg), in the order of p.
  const double* armature() const { return armature_.data(); }
  /// Damping (N m s/rad, N s/m) and constant effort (N m, N) per DoF, in the order of p; zero if there is none.
  const double* damping() const { return damping_.data(); }
  const double* effort() const { return effort_.data(); }
  bool has_forces() const { return has_forces_; }
  /// Bodies whose joint's coordinates contain a quaternion; this and the next lists are in the order of joint numbers.
  std::span<const int> quaternion_joints() const { return quaternion_joints_; }
  /// Bodies whose joint has a spring.
  std::span<const int> spring_joints() const { return spring_joints_; }
  /// The model's forces on bodies, including those on removed bodies, which have no effect.
  std::span<const BodyForce> body_forces() const {
    return declared_ ? std::span<const BodyForce>(declared_->forces) : std::span<const BodyForce>();
  }
  /// Functions that act on bodies, at most one per body; also including removed bodies.
  std::span<const Topology::Loaded> body_functions() const { return body_functions_; }
  /// The model's springs between points of bodies, by number, including those without effect: see spring_acts().
  std::span<const Spring> springs() const {
    return declared_ ? std::span<const Spring>(declared_->springs) : std::span<const Spring>();
  }
  int spring_count() const { return static_cast<int>(spring_states_.size()); }
  /// False for a spring that is broken or was attached to a body that was removed.
  bool spring_acts(int spring) const {
    const Spring& s = springs()[at(spring)];
    const auto holds = [this](BodyId body) { return body == ground || alive(body.index); };
    return !spring_broken(spring) && holds(s.from.body) && holds(s.to.body);
  }
  bool spring_broken(int spring) const { return spring_state(spring).broken; }
  /// Its present law: the model's, or as a change set it.
  const SpringLaw& spring_law(int spring) const { return spring_state(spring).law; }
  /// True if a spring that acts has a strength.
  bool has_spring_strengths() const;
  /// Bodies on which such a force, function or spring acts, and all bodies inboard of them, inboard before outboard.
  std::span<const int> loaded_bodies() const { return loaded_; }
  /// Bodies whose joint has friction, soft stops, or a drive other than a constant effort.
  std::span<const int> forced_joints() const { return forced_joints_; }
  /// Bodies whose joint has a prescribed motion and is not locked.
  std::span<const int> driven_joints() const { return driven_joints_; }
  /// The prescribed motion of such a joint; the joint must have one.
  const Curve& motion(int b) const {
    const JointParameters* const p = parameters(b);
    MT_REQUIRE(p != nullptr && p->drive != nullptr && p->drive->moves(), "the joint's motion is prescribed");
    return p->drive->motion.front();
  }
  /// Bodies whose joint has a strength.
  std::span<const int> strength_joints() const { return strength_joints_; }
  /// True if a function drives a joint at present, not merely earlier.
  bool has_functions() const { return has_functions_ || loop_functions_ > 0; }
  /// The function that drives b's joint, or null.
  const JointFunction* function(int b) const {
    const int i = joint(b).function;
    return i < 0 ? nullptr : functions_[at(i)].get();
  }
  /// The function that drives a loop joint, by its place in loops(), or null.
  const JointFunction* loop_function(int place) const {
    const int i = loops_[at(place)].joint.function;
    return i < 0 ? nullptr : functions_[at(i)].get();
  }
  /// Loop joints, and their form for the recursions, in the same order, followed by the couplings that act.
  std::span<const Loop> loops() const { return loops_; }
  std::span<const LoopLink> loop_links() const { return loop_links_; }
  /// True with loop joints or couplings that act.
  bool has_loops() const { return !loop_links_.empty(); }
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
  /// A loop joint: its place in loops(), or −1; itself, or null.
  int loop_place(JointId joint) const;
  const Loop* find_loop(JointId joint) const;
  /// Bodies between the ends of loops and the ground, one entry per body and loop, inboard before outboard.
  std::span<const LoopStop> loop_stops() const { return loop_stops_; }
  /// Numbers of rows of all loops, and of columns at all stops.
  int loop_rows() const { return loop_rows_; }
  int loop_columns() const { return loop_columns_; }
  /// Of these, rows of prescribed motions and of armatures of loop joints.
  int loop_motions() const { return loop_motions_; }
  int loop_armatures() const { return loop_armatures_; }
  /// The first instant (s) after t at which a table of a drive or force has a kink; infinite if there is none. Steps must not
  /// cross it.
  double next_bend(double t) const;
  /// The shortest period of the sines of drives and forces (s); infinite without any.
  double shortest_period() const;

  /// Largest sizes that any topology of these bodies needs.
  std::size_t record_capacity() const { return record_capacity_; }
  int angle_capacity() const { return 2 * bodies(); }

  /// The difference from the compiled model.
  [[nodiscard]] Topology topology() const;
  /// Becomes a copy of `other` in which every joint with parameters uses armature kernels, whether or not it has armature:
  /// mutable_armature() then holds the whole inertia of these joints apart from the bodies'. O(bodies); copying the same bodies
  /// again allocates nothing.
  void copy_with_armatures(const Tree& other);
  /// Write access to armature(), for an integration method that changes it between evaluations at bare arrays: no state belongs
  /// to this tree afterwards. Valid until the tree is next changed or copied to.
  double* mutable_armature() {
    revision_.renew();
    return armature_.data();
  }
  /// Sets the topology of this tree, which must be compiled from the same model as `topology` was. Creates a revision like every
  /// edit: earlier evaluations are stale, even if the topology is the same. O(bodies); allocates only if bodies were added.
  void restore(const Topology& topology);

  // Edits of which topology changes are composed. Each relinks what it affects and creates a revision; none changes a state
  // (topology/ does that) or, unless stated, allocates. Joints are packed in the order of their numbers, so re-rooting moves no
  // coordinate.

  /// Makes the inboard joint of b a free joint to the ground, at the identity, without parameters: b's user frame is then its
  /// joint's frame.
  void detach(int b);
  /// Makes b the root of its tree, whose root joint must be free. Reverses the joints in between; b gets the free joint.
  void reroot(int b);
  /// Re-roots the tree of b at b and attaches it to `parent`, in another tree or the ground; the free joint becomes `joint`.
  void attach(int b, int parent, const Joint& joint, bool reversed);
  /// Replaces the inboard joint of b; joint.parameters is an index as the caller wants it. The direction stays.
  void set_joint(int b, const Joint& joint) { set_joint(b, joint, reversed(b)); }
  /// The same for a joint whose declared child is b or, if reversed, b's parent (which must not be the ground).
  void set_joint(int b, const Joint& joint, bool reversed);
  /// Sets the gravity (m/s², world axes).
  void set_gravity(const Vec3& gravity);
  /// Sets the parameters of b's joint alone.
  void set_parameters(int b, const JointParameters& parameters);
  /// Sets the function that drives b's joint, or null for none. It stays with the joint until that is replaced by another.
  /// Allocates.
  void set_function(int b, std::shared_ptr<const JointFunction> function);
  /// Sets the function that acts on body b, or null for none. It stays until b is removed, whatever b is attached to. Allocates.
  void set_body_function(int b, std::shared_ptr<const BodyFunction> function);
  /// Adds a loop joint, whose `number` is assigned if it is negative, and returned; removes one; replaces joint and parameters.
  /// May allocate.
  int add_loop(Loop loop);
  void remove_loop(int number);
  void set_loop(int number, const Joint& joint, const JointParameters& parameters, const Values& held = {});
  /// Sets the function that drives a loop joint, or null for none: as set_function(), which it stays if the joint becomes one of
  /// the tree. Allocates.
  void set_loop_function(int number, std::shared_ptr<const JointFunction> function);
  /// Ends a coupling.
  void end_coupling(int coupling);
  /// Sets the contacts that are closed, between bodies of the tree. May allocate.
  void set_contacts(std::vector<Contact> contacts);
  /// Removes a spring, or sets its law.
  void break_spring(int spring);
  void set_spring_law(int spring, const SpringLaw& law);
  /// Removes root b and all bodies outboard of it; their numbers are not used again.
  void remove(int b);
  /// Adds a body, given in the complete form of Model::operator[], and returns the new number of the body and its joint. Storage
  /// for every later topology grows: workspaces must be made anew.
  int add(const BodySpec& spec);

 private:
  template <class Look>
  void for_signals(Look look) const;
  friend class UncheckedTree;
  friend struct TestAccess;  // dynamics/test_support.hpp
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static constexpr const char* known_body = "the tree has a body of that number, and it was not removed";

  // frames.cpp
  bool is_welded(int b) const { return class_[at(b)].kind == Kind::weld; }
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
  void note_constraints() { has_constraints_ = !driven_joints_.empty() || !loop_links_.empty() || !contacts_.empty(); }

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
  std::size_t record_scalars_ = 0, record_capacity_ = 0;
  detail::Version revision_, loop_revision_;
  std::shared_ptr<const detail::Declared> declared_;
  // By body, or by joint if stated.
  std::vector<int> parent_, first_child_, next_sibling_;
  struct Offsets {  // together, because a step needs all of them
    int q = -1, p = -1, angle = -1;
    std::uint32_t record = 0;
  };
  std::vector<Offsets> offsets_;
  detail::Reserved<int> order_;  // alive bodies only
  std::vector<int> place_;       // place in the order
  std::vector<int> joint_of_;
  std::vector<int> carrier_, joint_at_;  // by joint; the second: index of the declared joint, or ~index of the tree's own
  std::vector<unsigned char> reversed_;
  struct alignas(4) Class {  // neighbours of equal class share a kernel run; read as a whole, with one load
    Kind kind = Kind::weld;
    Variant variant = Variant::plain;
    bool parallel : 1 = false;     // its axis is parallel to its parent's
    bool aligned : 1 = false;      // its link needs no rotation about the parent's z
    bool as_declared : 1 = false;  // while everything is linked: its frame is as declared
    friend bool operator==(Class a, Class b) { return a.kind == b.kind && a.variant == b.variant; }
  };
  std::vector<Class> class_;
  std::vector<double> subtree_mass_;
  detail::LinkTable links_;
  detail::Reserved<OwnJoint> own_joints_;
  std::vector<MassProperties> added_masses_;
  detail::Reserved<JointParameters> own_parameters_;  // set by changes for one joint, in the order in which they were set
  detail::Reserved<detail::DofParameters> own_dofs_;
  detail::Reserved<KernelRun> runs_;
  detail::Reserved<unsigned char> node_flags_;
  detail::Reserved<int> spring_joints_, quaternion_joints_, forced_joints_, driven_joints_, strength_joints_;
  std::vector<std::shared_ptr<const JointFunction>> functions_;  // in the order in which they were set
  std::vector<unsigned char> special_;                           // by joint: a bit each for a spring, a quaternion, a force, …
  // Packed, by angle and by DoF.
  detail::Reserved<int> angle_q_;
  detail::Reserved<double> angle_offset_, armature_, damping_, effort_;
  bool has_forces_ = false, has_functions_ = false;
  bool has_constraints_ = false;
  std::vector<Topology::Loaded> body_functions_;
  std::vector<Topology::SpringChange> spring_states_;  // by spring
  const Topology::SpringChange& spring_state(int spring) const {
    MT_REQUIRE(at(spring) < spring_states_.size(), "the model has a spring of that number");
    return spring_states_[at(spring)];
  }
  detail::Reserved<int> loaded_;
  std::vector<unsigned char> loaded_mark_;  // scratch, by body
  std::vector<Loop> loops_;
  std::vector<LoopLink> loop_links_;
  std::vector<LoopStop> loop_stops_;
  std::vector<Contact> contacts_;
  std::vector<unsigned char> coupling_ended_;  // by coupling
  int next_loop_ = 0, loop_rows_ = 0, loop_columns_ = 0, loop_motions_ = 0, loop_armatures_ = 0;
  int loop_functions_ = 0;
  void count_loop_functions();
  int renewed_function(int number, std::shared_ptr<const JointFunction> function);
};

/// Compiles a model: `Tree tree = compile(model)`.
[[nodiscard]] inline Tree compile(const Model& model) { return Tree(model); }

/// Joints at which the joint-space mass is singular at these coordinates (nq numbers, order of State::q).
std::vector<SingularJoint> singular_joints(const Tree& tree, std::span<const double> coordinates);

}  // namespace momentree

#pragma once
// The compiled topology: one forest of flat arrays. Body numbers never change; a change relinks order and offsets.
// A mechanism that falls off is a body whose parent became the ground.
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/unique_number.hpp>
#include <momentree/joint/body_pair.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/joint/kernels.hpp>
#include <momentree/tree/declared.hpp>
#include <momentree/tree/model.hpp>

namespace momentree {

/// A drive that is a function of the world: called at every stage of a step with one entry per freedom, zeros, to be made efforts
/// (N m, N). Must not throw; what it returns may depend on the moment alone.
using JointFunction = std::function<void(const EvaluationContext&, std::span<double>)>;

/// What a topology is beyond the compiled model: a small value. Everything else of a Tree follows from it and the model, to the
/// last bit, whatever changes led there.
struct Topology {
  /// How a body hangs: its parent (−1: the ground) and its inboard joint (−1: the body was removed), perhaps against its declared
  /// direction.
  struct Place {
    int parent = -1, joint = -1;
    bool reversed = false;
  };
  /// A joint that is not the model's, and the number it has.
  struct Changed {
    int joint = -1;
    Joint as{};
  };
  /// Parameters that a change gave to one joint.
  struct Own {
    int joint = -1;
    JointParameters parameters{};
  };
  /// A function that acts on a body.
  struct Loaded {
    int body = -1;
    std::shared_ptr<const BodyFunction> function;
  };
  std::vector<Place> places;                                    ///< by body
  std::vector<Changed> changed;                                 ///< in the order of numbers
  std::vector<Own> own;                                         ///< in the order in which they were given
  std::vector<MassProperties> added;                            ///< of the bodies that the model did not have
  std::vector<std::shared_ptr<const JointFunction>> functions;  ///< drives that joints have numbers of
  std::vector<Loaded> loads;                                    ///< one for a body
  std::uint64_t model = 0;                                      ///< fingerprint of the model
};

/// The free joint of what broke off, at the identity: coordinates are the pose of the body's own frame.
inline Joint floating_root_joint() {
  Joint joint;
  joint.kind = Kind::free;
  joint.created_by_event = true;
  return joint;
}

/// A stretch of the order whose joints share their kernels: bodies order[begin] … order[end − 1], forks and tips among them.
struct KernelRun {
  int begin = 0, end = 0;
  Kind kind = Kind::weld;
  Variant variant = Variant::plain;
  bool planar = false;  ///< one mechanism, whole: a grounded tree of plain pins whose axes are parallel
  int pair = -1;        ///< where that stretch begins that is like this one in a branch that is built alike; −1: there is none
  bool branch = false;  ///< such a branch begins with it
  int links = 0;        ///< where its constants and its twin's begin in Tree::paired_links
};
/// The stretch that is swept with this one.
inline KernelRun pair_of(const KernelRun& s) {
  return {s.pair, s.pair + s.end - s.begin, s.kind, s.variant, s.planar, s.begin, s.branch, s.links};
}

/// How a body stands in the order: depth first, so that behind a body comes its first child, if it has any. On the way in its
/// sums are then at hand, and on the way out those of its parent; only other children pass theirs through memory.
namespace node {
enum : unsigned char {
  leaf = 1,         ///< it has no child
  branching = 2,    ///< it has several
  first_child = 4,  ///< it is its parent's first child, and comes right behind it
  root = 8,         ///< it is joined to the ground
  last_child = 16,  ///< its parent's last child, and not the only one: the first to be met on the way in
  aligned = 32,     ///< its link needs no turn about the parent's z
};
}

/// A value: copies are independent of each other, and a const tree may be read by several threads at once.
class Tree {
 public:
  Tree() = default;
  /// Compiles a model. Storage for every later topology is reserved: no change allocates.
  explicit Tree(const Model& model);

  /// Numbers given to bodies so far; those that were removed keep theirs.
  int bodies() const { return static_cast<int>(parent_.size()); }
  /// False for a number that no body has, and for a body that was removed: asking anything else about it stops the program.
  bool alive(int b) const { return at(b) < joint_of_.size() && joint_of_[at(b)] >= 0; }
  /// Where body b stands in lists by body.
  std::size_t index(int b) const {
    MT_REQUIRE(alive(b), known_body);
    return at(b);
  }
  int nq() const { return nq_; }
  int nv() const { return nv_; }
  const Vec3& gravity() const { return gravity_; }
  /// Identifies this tree as it is now: each tree that is compiled, and each change of one, has a number that no other has in
  /// this process; copies share it, for they are the same. States are of the tree of one revision.
  std::uint64_t revision() const { return revision_.number(); }

  int parent(int b) const { return parent_[index(b)]; }
  int first_child(int b) const { return first_child_[index(b)]; }
  int next_sibling(int b) const { return next_sibling_[index(b)]; }
  int first_root() const { return first_root_; }
  int first_q(int b) const { return offsets_[index(b)].q; }
  int first_p(int b) const { return offsets_[index(b)].p; }
  int first_angle(int b) const { return offsets_[index(b)].angle; }
  /// Offset of the body's record in Work, in scalars.
  std::size_t record(int b) const { return offsets_[index(b)].record; }
  const LinkConstants& link(int b) const { return links_[index(b)]; }
  /// Mass of body b and of all outboard of it (kg).
  double subtree_mass(int b) const { return subtree_mass_[index(b)]; }
  /// The inboard joint of body b. Joints have numbers of their own: at the start that of their child; re-rooting makes a body
  /// carry another joint, against its declared direction.
  const Joint& joint(int b) const { return numbered_joint(joint_of_[index(b)]); }
  /// Its kind, without a look at the rest of it.
  Kind kind(int b) const { return class_[index(b)].kind; }
  int joint_of(int b) const { return joint_of_[index(b)]; }
  /// The body that carries the joint of that number; −1: it left with its body.
  int carrier(int joint) const {
    MT_REQUIRE(at(joint) < carrier_.size(), "the tree has a joint of that number");
    return carrier_[at(joint)];
  }
  /// The same for handles.
  BodyId carrier(JointId joint) const { return {carrier(joint.index)}; }
  /// The joint that a body carries.
  JointId inboard_joint(BodyId body) const { return {joint_of(body.index)}; }
  bool reversed(int b) const { return reversed_[index(b)] != 0; }
  Variant variant(int b) const { return class_[index(b)].variant; }
  const KernelFrame& frame(int b) const { return links_.frame(index(b)); }
  /// Parameters of the joint, or null.
  const JointParameters* parameters(int b) const {
    const int i = joint(b).parameters;
    if (i < 0) return nullptr;
    const int own = i - shared_parameters();
    return own < 0 ? &declared_->parameters[at(i)] : &own_parameters_[at(own)];
  }
  /// How many parameters the model's joints share: those that changes gave to one joint have numbers from there on.
  int shared_parameters() const { return declared_ ? static_cast<int>(declared_->parameters.size()) : 0; }
  /// True for a body whose root joint was made by a change: named after the body.
  bool detached(int b) const { return joint(b).created_by_event; }

  /// Depth first, inboard before outboard; siblings and roots in ascending order of numbers.
  std::span<const int> order() const { return order_; }
  std::span<const KernelRun> kernel_runs() const { return runs_; }
  /// The same cut where branches begin and end that hang on one body and are built alike, pins and welds in the same order with
  /// the same forks, as the legs of a robot are: the sweeps of one world take two such branches at once.
  std::span<const KernelRun> paired_runs() const { return has_pairs_ ? paired_runs_ : runs_; }
  /// The constants of bodies and their twins, by the first ones' places in their branches: see Segment::links.
  std::span<const PairedLinks> paired_links() const { return paired_links_; }
  /// Flags of the bodies in the order: see flow.
  std::span<const unsigned char> node_flags() const { return node_flags_; }
  std::size_t record_scalars() const { return record_scalars_; }
  /// Angles of all joints: index into q, and the offset θ0 that is added to it.
  std::span<const int> angle_coordinates() const { return angle_q_; }
  std::span<const double> angle_offsets() const { return angle_offset_; }
  /// Rotor inertia per freedom, in the order of p.
  const double* armature() const { return armature_.data(); }
  /// Damping and constant effort per freedom, in the order of p; zeros where there is none.
  const double* damping() const { return damping_.data(); }
  const double* effort() const { return effort_.data(); }
  bool has_forces() const { return has_forces_; }
  /// Bodies whose joint's coordinates hold a quaternion; these and the next in the order of joint numbers.
  std::span<const int> quaternion_joints() const { return quaternion_joints_; }
  /// Bodies whose joint has a spring.
  std::span<const int> spring_joints() const { return spring_joints_; }
  /// Forces on bodies, as the model has them; also those on bodies that were removed, which do nothing.
  std::span<const BodyForce> body_forces() const {
    return declared_ ? std::span<const BodyForce>(declared_->forces) : std::span<const BodyForce>();
  }
  /// Functions that act on bodies, one for a body; the same goes for them.
  std::span<const Topology::Loaded> body_functions() const { return body_functions_; }
  /// Bodies on which such a force or function acts, and all that carry them, inboard before outboard.
  std::span<const int> loaded_bodies() const { return loaded_; }
  /// Bodies whose joint has friction, soft stops or a drive that is no constant effort.
  std::span<const int> forced_joints() const { return forced_joints_; }
  /// Bodies whose joint's motion is prescribed and not locked.
  std::span<const int> driven_joints() const { return driven_joints_; }
  /// The prescribed motion of such a joint.
  const Curve& motion(int b) const {
    const JointParameters* const p = parameters(b);
    MT_REQUIRE(p != nullptr && p->drive != nullptr && p->drive->moves(), "the joint's motion is prescribed");
    return p->drive->motion.front();
  }
  /// Bodies whose joint has a strength.
  std::span<const int> strength_joints() const { return strength_joints_; }
  /// True where a function drives a joint now: what did so before must not show.
  bool has_functions() const { return has_functions_; }
  /// The function that drives b's joint, or null.
  const JointFunction* function(int b) const {
    const int i = joint(b).function;
    return i < 0 ? nullptr : functions_[at(i)].get();
  }
  /// The first instant after t at which a table of a drive or of a force bends, infinite where there is none: steps must not pass
  /// it.
  double next_bend(double t) const;

  /// Largest sizes that any topology of these bodies needs.
  std::size_t record_capacity() const { return record_capacity_; }
  int angle_capacity() const { return 2 * bodies(); }

  /// What has changed since the model was compiled.
  [[nodiscard]] Topology topology() const;
  /// Becomes a copy of `other` in which every joint that has parameters takes a rotor, whether or not it has one: what stands in
  /// rotors() is then its whole mass beside the bodies'. O(bodies); a copy of the same bodies as before allocates nothing.
  void copy_with_armatures(const Tree& other);
  /// Becomes a copy of `other` in which joints with structured kernels go by the generic pieces, as locked ones do, though
  /// nothing is locked: what those kernels are held to. Costs as much.
  void copy_with_generic_kernels(const Tree& other);
  /// The numbers of armature(), for a method that changes them between evaluations at bare arrays: no state is one of this tree
  /// from now on. Good until the tree is next changed or copied to.
  double* rotors() {
    revision_.renew();
    return armature_.data();
  }
  /// Makes this tree, which was compiled from the same model, what `topology` says. A revision, as every edit: what was evaluated
  /// before is stale, even on the same topology. O(bodies); allocates only where bodies were added.
  void restore(const Topology& topology);

  // The edits that changes are made of. Each relinks what it moved and makes another revision; none touches a state (topology/
  // does) or allocates. Joints are packed in the order of their numbers: re-rooting moves no coordinate.

  /// The inboard joint of b becomes a free joint to the ground, at the identity, without parameters: b's user frame is its
  /// joint's frame.
  void detach(int b);
  /// b becomes the root of its tree, whose root must hang on a free joint. The joints between turn over; the free joint is b's.
  void reroot(int b);
  /// The tree of b is re-rooted at b and hung on `parent`, of another tree or the ground; the free joint becomes `joint`.
  void attach(int b, int parent, const Joint& joint, bool reversed);
  /// Replaces the inboard joint of b; parameters (if the index says so) are the caller's. The direction stays.
  void set_joint(int b, const Joint& joint) { set_joint(b, joint, reversed(b)); }
  /// The same for a joint whose declared child is b, or, reversed, b's parent (which is then not the ground).
  void set_joint(int b, const Joint& joint, bool reversed);
  /// Another gravity (m/s², world axes).
  void set_gravity(const Vec3& gravity);
  /// Parameters of b's joint alone.
  void set_parameters(int b, const JointParameters& parameters);
  /// A function that drives b's joint from now on, or null: none. Goes with the joint, until that is replaced by another;
  /// allocates.
  void set_function(int b, std::shared_ptr<const JointFunction> function);
  /// A function that acts on body b from now on, or null: none; whatever b is joined to, until it leaves. Allocates.
  void set_body_function(int b, std::shared_ptr<const BodyFunction> function);
  /// Root b and all bodies outboard of it leave; their numbers are not used again.
  void remove(int b);
  /// A body, complete as Model::operator[] has it, joins with a new number for itself and its joint, which it returns. The
  /// storage grows, for every later topology: Work is to be made anew.
  int add(const BodySpec& spec);

 private:
  friend class UncheckedTree;
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

  // relink.cpp: from parents, joints and directions, everything that follows.
  void link_all(LinkCollector* collector = nullptr);
  void pack_all();
  void assign_offsets(int b);
  void pack(int b);
  const DofParameters& dof_parameters(const Joint& joint) const;
  struct Locks {
    unsigned char locked, driven;
  };
  Locks locks_of(int b) const;
  void put_locks(int b);
  bool repack(int b, Kind before);
  void list_special_joints();
  int number_depth_first(int root, int place);
  void build_runs();
  bool in_a_plane(int place) const;

  // twins.cpp
  void find_pairs(bool forks);
  void pair_siblings(int first, int end);
  void pair_branches();
  void cut_runs();
  bool are_isomorphic(int place, int other, int count) const;
  void update_subtree_mass(int b);
  void weigh_path(int b);
  int end_of(int b) const;
  void move_block(int begin, int end, int to);

  void list_loaded_bodies();

  // edits.cpp
  void unlink(int b);
  void hang(int b, int parent);
  void move_tree(int b, int begin, int end);
  bool replace_joint(int b, const Joint& joint, bool reversed);
  int reverse_path(int b);
  int give_parameters(int joint, const JointParameters& parameters);
  void require_valid(const Joint& joint) const;
  void require_valid(const Topology& topology) const;

  // Joints by number: the model's, or the tree's own.
  struct OwnJoint {
    Joint joint;
    int parameters = -1;  // place of the joint's own parameters, once it was given some
  };
  const Joint& numbered_joint(int joint) const {
    const int i = joint_at_[at(joint)];
    return i >= 0 ? declared_->joints[at(i)] : own_joints_[at(~i)].joint;
  }
  OwnJoint& own_joint(int joint);
  static constexpr int no_joint = std::numeric_limits<int>::max();  // of a body that left, which the model did not have
  std::size_t declared_bodies() const { return declared_ ? declared_->bodies.size() : 0; }
  bool joint_as_declared(int b) const;
  bool frame_as_declared(int b) const;
  const MassProperties& mass(int b) const;
  void collect(int b, LinkCollector& collector);

  Vec3 gravity_{};
  int nq_ = 0, nv_ = 0, angles_ = 0, first_root_ = -1;
  std::size_t record_scalars_ = 0, record_capacity_ = 0;
  detail::Version revision_;
  std::shared_ptr<const Declared> declared_;
  // By body, or by joint where it says so.
  std::vector<int> parent_, first_child_, next_sibling_;
  struct Offsets {  // together: a step asks for all of them
    int q = -1, p = -1, angle = -1;
    std::uint32_t record = 0;
  };
  std::vector<Offsets> offsets_;
  Reserved<int> order_;     // of the living
  std::vector<int> place_;  // in the order
  std::vector<int> joint_of_;
  std::vector<int> carrier_, joint_at_;  // by joint; the second: its number among the declared, or ~ that among its own
  std::vector<unsigned char> reversed_;
  struct Class {  // neighbours of one class share a segment
    Kind kind = Kind::weld;
    Variant variant = Variant::plain;
    bool parallel = false;     // its axis is its parent's: no tilt
    bool aligned = false;      // its link needs no turn about the parent's z
    bool as_declared = false;  // while everything is linked: its frame is the model's
    friend bool operator==(Class a, Class b) { return a.kind == b.kind && a.variant == b.variant; }
  };
  std::vector<Class> class_;
  std::vector<double> subtree_mass_;
  LinkTable links_;
  Reserved<OwnJoint> own_joints_;
  std::vector<MassProperties> added_masses_;
  Reserved<JointParameters> own_parameters_;  // those that changes gave to one joint, in the order in which they were given
  Reserved<DofParameters> own_dofs_;
  Reserved<KernelRun> runs_, paired_runs_;
  Reserved<PairedLinks> paired_links_;
  Reserved<int> end_, pair_;  // while branches are compared, by place: where what is outboard ends; place of the twin, or −1
  Reserved<unsigned char> node_flags_;
  Reserved<int> spring_joints_, quaternion_joints_, forced_joints_, driven_joints_, strength_joints_;
  std::vector<std::shared_ptr<const JointFunction>> functions_;  // in the order in which they were given
  std::vector<unsigned char> special_;                           // by joint: a bit each for a spring, a quaternion, a force, …
  // Packed, by angle and by freedom.
  Reserved<int> angle_q_;
  Reserved<double> angle_offset_, armature_, damping_, effort_;
  bool has_forces_ = false, has_functions_ = false, has_pairs_ = false;
  std::vector<Topology::Loaded> body_functions_;
  Reserved<int> loaded_;
  std::vector<unsigned char> loaded_mark_;  // scratch, by body
};

/// Compiles a model: `Tree tree = compile(model)`.
[[nodiscard]] inline Tree compile(const Model& model) { return Tree(model); }

/// Joints at which the joint-space mass is singular at these coordinates (order of State::q).
std::vector<SingularJoint> singular_joints(const Tree& tree, std::span<const double> coordinates);

}  // namespace momentree

#pragma once
// Immutable data shared by the trees of one model. Equal values are stored once, because a large world repeats a few joints,
// masses and placements.
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <momentree/joint/joint.hpp>
#include <momentree/math/mass_properties.hpp>
#include <momentree/model/model.hpp>
#include <momentree/tree/distinct.hpp>
#include <momentree/tree/parts/links.hpp>

namespace momentree {

/// A joint as declared, or as a change made it. Parameters are stored separately: most joints of a large world share a few.
struct Joint {
  Kind kind = Kind::weld;
  int parameters = -1;  ///< index for Tree::parameters, −1: none
  Pose at{}, child_at{};
  Vec3 axis{0, 0, 1}, axis2{};
  double pitch = 0;
  unsigned locked = 0;            ///< a bit per frozen DoF, in the order of v
  bool created_by_event = false;  ///< a free root joint made by a change, which corresponds to no declared joint
  int function = -1;              ///< index of the function that drives it, for Tree::function; −1: none
};
/// Kind and geometry of a joint, without placements and parameters.
inline JointSpec spec_of(const Joint& joint) {
  JointSpec spec;
  spec.kind = joint.kind, spec.axis = joint.axis, spec.axis2 = joint.axis2, spec.pitch = joint.pitch;
  return spec;
}

namespace detail {

/// Parameters expanded to one value per DoF, ready to be copied when a topology is relinked.
struct DofParameters {
  std::array<double, 6> armature{}, damping{}, effort{};
  bool has_armature = false, spring = false, force = false, drive = false, motion = false, strength = false;
};
DofParameters spread(const JointParameters& parameters);

/// The model in the form that its trees use.
struct Declared {
  struct Body {
    int parent, first_child;
    int joint, mass, link;  ///< indices into the lists below
  };
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<MassProperties> masses;
  std::vector<JointParameters> parameters;
  std::vector<DofParameters> dofs;  ///< the parameters per DoF, by the same indices
  SharedLinks links;                ///< of the declared topology
  std::vector<BodyForce> forces;
  std::vector<Spring> springs;
  std::vector<Coupling> couplings;
  /// Hash of everything that a snapshot of coordinates and momenta depends on: equal for models with the same bodies and joints.
  std::uint64_t fingerprint = 0;
};
/// Everything but the links, which a tree computes.
std::shared_ptr<Declared> declare(const Model& model);
/// The declared joint of a body, without its parameters.
Joint joint_of(const BodySpec& spec);
Joint joint_of(const LoopSpec& spec);

/// Collects the links of the declared topology in the shared list.
class LinkCollector {
 public:
  /// Reserves space for all links, so that pointers to collected links stay valid.
  explicit LinkCollector(Declared& declared);
  /// Returns the index of the link.
  int take(int body, int first_child, const LinkConstants& link, const KernelFrame& frame);
  /// Releases unused capacity if it is large; links then move and it returns true.
  bool finish();

 private:
  Declared& declared_;
  Distinct numbers_;
};

}  // namespace detail
}  // namespace momentree

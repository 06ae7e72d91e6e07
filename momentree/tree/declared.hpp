#pragma once
// What trees of one model share and none of them changes. Equal values are stored once: a large world repeats a few joints,
// masses and placements.
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <momentree/joint/joint.hpp>
#include <momentree/tree/distinct.hpp>
#include <momentree/tree/links.hpp>
#include <momentree/tree/model.hpp>

namespace momentree {

/// A joint as declared (or as a change made it). Parameters stay apart: most joints of a large world share few.
struct Joint {
  Kind kind = Kind::weld;
  int parameters = -1;  ///< index for Tree::parameters, −1: none
  Pose at{}, child_at{};
  Vec3 axis{0, 0, 1}, axis2{};
  double pitch = 0;
  unsigned locked = 0;            ///< a bit per freedom that is frozen, in the order of v
  bool created_by_event = false;  ///< a free root joint that a change made: its place in a mechanism is that of no declared joint
  int function = -1;              ///< index of its drive for Tree::function, −1: none
};
/// Kind and geometry of a joint, without placements and parameters.
inline JointSpec spec_of(const Joint& joint) {
  JointSpec spec;
  spec.kind = joint.kind, spec.axis = joint.axis, spec.axis2 = joint.axis2, spec.pitch = joint.pitch;
  return spec;
}

/// Mass (kg), centre of mass and inertia about it, in the user's frame of the body.
struct MassProperties {
  double mass = 0;
  Vec3 com{};
  Sym3 inertia{};
};

/// Parameters spread over the freedoms: what relinking copies.
struct DofParameters {
  std::array<double, 6> armature{}, damping{}, effort{};
  bool rotor = false, spring = false, force = false, drive = false, motion = false, strength = false;
};
DofParameters spread(const JointParameters& parameters);

/// The model as its trees see it.
struct Declared {
  struct Body {
    int parent, first_child;
    int joint, mass, link;  ///< numbers in the lists below
  };
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<MassProperties> masses;
  std::vector<JointParameters> parameters;
  std::vector<DofParameters> dofs;  ///< the same, by their numbers
  SharedLinks links;                ///< of the declared topology
  std::vector<BodyForce> forces;
  /// Of all that a snapshot of coordinates and momenta relies on: models with the same bodies and joints have the same one.
  std::uint64_t fingerprint = 0;
};
/// All but the links, which a tree finds.
std::shared_ptr<Declared> declare(const Model& model);
/// The joint of a body as its model has it, parameters apart.
Joint joint_of(const BodySpec& spec);

/// Puts the links of the declared topology where they are shared.
class LinkCollector {
 public:
  /// There is room for all: links that were taken stay where they are.
  explicit LinkCollector(Declared& declared);
  /// Returns the number of the link.
  int take(int body, int first_child, const LinkConstants& link, const KernelFrame& frame);
  /// Gives back the room that was not needed, if it was much: links move then, and it returns true.
  bool finish();

 private:
  Declared& declared_;
  Distinct numbers_;
};

}  // namespace momentree

#pragma once
// The topology of a tree as a value: its difference from the compiled model.
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <momentree/joint/joint.hpp>
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

}  // namespace momentree

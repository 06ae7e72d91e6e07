// URDF as DART reads it (urdfdom) and computes it (articulated bodies).
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/utils/urdf/DartLoader.hpp>

#include <momentree/text/files/text_file.hpp>
#include <tests/cross/random_state.hpp>

namespace momentree::peers {
namespace {

using dart::dynamics::SkeletonPtr;

std::string name_of(const std::string& full) { return full.substr(full.find('/') + 1); }

// Without shapes: DART refuses a model whose meshes are missing.
std::string without(std::string text, const std::string& element) {
  for (;;) {
    const std::size_t begin = text.find("<" + element + ">"), named = text.find("<" + element + " ");
    const std::size_t from = std::min(begin, named);
    if (from == std::string::npos) return text;
    const std::string end = "</" + element + ">";
    text.erase(from, text.find(end, from) + end.size() - from);
  }
}

SkeletonPtr skeleton_of(const std::string& file, bool free) {
  const std::string text = io::read_text_file(MOMENTREE_SOURCE_DIR "/scenarios/models/" + file);
  dart::utils::DartLoader loader;
  SkeletonPtr skeleton = loader.parseSkeletonString(without(without(text, "visual"), "collision"), "");
  REQUIRE(skeleton);
  if (free)
    skeleton->getRootBodyNode()->changeParentJointType<dart::dynamics::FreeJoint>();
  else
    skeleton->getRootBodyNode()->changeParentJointType<dart::dynamics::WeldJoint>();
  for (auto* joint : skeleton->getJoints()) {
    joint->setActuatorType(dart::dynamics::Joint::FORCE);  // a joint that should mimic another is free here
    for (std::size_t i = 0; i < joint->getNumDofs(); ++i) {
      joint->setDampingCoefficient(i, 0);  // it takes damping implicitly, we do not
      joint->setCoulombFriction(i, 0);
      joint->setLimitEnforcement(false);
    }
  }
  return skeleton;
}

void put(const BodySpec& body, SkeletonPtr& skeleton) {
  if (body.joint.kind == Kind::weld) return;
  if (body.joint.kind == Kind::free) {
    auto* joint = dynamic_cast<dart::dynamics::FreeJoint*>(skeleton->getRootJoint());
    REQUIRE(joint);
    Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
    placement.linear() = Eigen::Quaterniond(body.q[3], body.q[4], body.q[5], body.q[6]).toRotationMatrix();
    placement.translation() = Eigen::Vector3d(body.q[0], body.q[1], body.q[2]);
    joint->setTransform(placement);
    Eigen::Matrix<double, 6, 1> twist;
    twist << body.v[3], body.v[4], body.v[5], body.v[0], body.v[1], body.v[2];
    joint->setSpatialVelocity(twist, dart::dynamics::Frame::World(), skeleton->getRootBodyNode());
    return;
  }
  auto* joint = skeleton->getJoint(name_of(body.joint_name));
  REQUIRE_MESSAGE(joint, body.joint_name);
  REQUIRE(joint->getNumDofs() == 1);
  joint->setPosition(0, body.q[0]);
  joint->setVelocity(0, body.v[0]);
  joint->setForce(0, -body.joint.parameters.damping.of(0) * body.v[0]);
}

void compare(const std::string& file, bool free, std::uint64_t seed) {
  const std::string name = file.substr(file.find('/') + 1, file.find('.') - file.find('/') - 1);
  const Model model =
      read(file, {"mechanism." + name + ".limits=false", "mechanism." + name + ".root=\"" + (free ? "free\"" : "fixed\"")});
  SkeletonPtr skeleton = skeleton_of(file, free);
  for (const BodySpec& body : model.bodies())  // a link without <inertial> weighs 1 kg there
    if (auto* node = skeleton->getBodyNode(name_of(body.name)); node && body.mass == 0)
      node->setInertia(dart::dynamics::Inertia(0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()));
  skeleton->setGravity(Eigen::Vector3d(0, 0, -9.81));
  oracle::Prng random(seed);
  for (int sample = 0; sample < 100; ++sample) {
    const Model here = at_random_state(model, random);
    for (const BodySpec& body : here.bodies()) put(body, skeleton);
    skeleton->computeForwardDynamics();
    const World world(here);
    double largest = 0, worst = 0;
    for (int b = 0; b < here.size(); ++b) {
      const BodySpec& body = here[{b}];
      const auto a = world.joint_forces({b}).a;
      Eigen::VectorXd theirs;
      if (body.joint.kind == Kind::free) {
        const auto spatial = skeleton->getRootBodyNode()->getSpatialAcceleration();  // of the twist's components
        theirs.resize(6);
        theirs << spatial.tail<3>(), spatial.head<3>();
      } else if (!a.empty()) {
        theirs.resize(1);
        theirs[0] = skeleton->getJoint(name_of(body.joint_name))->getAcceleration(0);
      }
      REQUIRE(static_cast<std::size_t>(theirs.size()) == a.size());
      for (std::size_t i = 0; i < a.size(); ++i) {
        const double their = theirs[static_cast<Eigen::Index>(i)];
        largest = std::max(largest, std::fabs(their));
        worst = std::max(worst, std::fabs(a[i] - their));
      }
    }
    CAPTURE(sample);
    REQUIRE(largest > 0);
    CHECK(worst <= bound * largest);
  }
}

}  // namespace

TEST_CASE("DART: accelerations of every URDF model, grounded and free, at 100 random states") {
  const char* files[] = {"panda/panda.urdf",
                         "ur5/ur5_robot.urdf",
                         "anymal_b/anymal.urdf",
                         "simple_humanoid/simple_humanoid.urdf",
                         "double_pendulum/double_pendulum.urdf",
                         "iiwa14/iiwa14_no_collision.urdf"};
  std::uint64_t seed = 1;
  for (const std::string file : files)
    for (const bool free : {false, true}) {
      CAPTURE(file);
      CAPTURE(free);
      compare(file, free, seed++);
    }
}

}  // namespace momentree::peers

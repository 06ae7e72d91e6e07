// SDF as libsdformat reads it (poses, inertias, axes) and DART computes what it has read (articulated bodies).
#include <cstring>
#include <filesystem>
#include <map>

#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/ScrewJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/UniversalJoint.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <sdf/sdf.hh>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/cross/random_state.hpp>

namespace momentree::peers {
namespace {

namespace dd = dart::dynamics;
using ignition::math::Pose3d;

Eigen::Vector3d vector_of(const ignition::math::Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }
Eigen::Isometry3d placement_of(const Pose3d& pose) {
  Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
  placement.linear() = Eigen::Quaterniond(pose.Rot().W(), pose.Rot().X(), pose.Rot().Y(), pose.Rot().Z()).toRotationMatrix();
  placement.translation() = vector_of(pose.Pos());
  return placement;
}

// What libsdformat made of a file, in the world's frame, under full names.
struct Link {
  Eigen::Isometry3d at;
  ignition::math::Inertiald inertial;
  bool is_static;
};
struct Joined {
  std::string name, parent, child;
  Eigen::Isometry3d at;
  const sdf::Joint* joint;
};

class Resolved {
 public:
  explicit Resolved(const std::string& path) {
    sdf::ParserConfig config;
    config.SetFindCallback(
        [folder = std::filesystem::path(path).parent_path()](const std::string& name) { return (folder / name).string(); });
    for (const sdf::Error& error : root_.Load(path, config)) FAIL(error.Message());
    if (const sdf::Model* model = root_.Model()) {
      enter(*model, Eigen::Isometry3d::Identity(), "", false);
      return;
    }
    REQUIRE(root_.WorldCount() == 1);
    const sdf::World& world = *root_.WorldByIndex(0);
    gravity = vector_of(world.Gravity());
    for (std::uint64_t m = 0; m < world.ModelCount(); ++m) {
      const sdf::Model& model = *world.ModelByIndex(m);
      enter(model, Eigen::Isometry3d::Identity(), model.Name() + "::", false);
    }
  }

  std::map<std::string, Link> links;
  std::vector<Joined> joints;
  Eigen::Vector3d gravity{0, 0, -9.81};

 private:
  static Eigen::Isometry3d resolve(const sdf::SemanticPose& pose, const std::string& in = "") {
    Pose3d resolved;
    const sdf::Errors errors = pose.Resolve(resolved, in);
    REQUIRE(errors.empty());
    return placement_of(resolved);
  }

  void enter(const sdf::Model& model, const Eigen::Isometry3d& outer, const std::string& prefix, bool outer_static) {
    const Eigen::Isometry3d at = outer * (prefix.empty() ? placement_of(model.RawPose()) : resolve(model.SemanticPose()));
    const bool is_static = model.Static() || outer_static;
    for (std::uint64_t l = 0; l < model.LinkCount(); ++l) {
      const sdf::Link& link = *model.LinkByIndex(l);
      links[prefix + link.Name()] = {at * resolve(link.SemanticPose()), link.Inertial(), is_static};
    }
    for (std::uint64_t j = 0; j < model.JointCount() && !is_static; ++j) {
      const sdf::Joint& joint = *model.JointByIndex(j);
      std::string parent, child;
      REQUIRE(joint.ResolveParentLink(parent).empty());
      REQUIRE(joint.ResolveChildLink(child).empty());
      joints.push_back({prefix + joint.Name(), parent == "world" ? "" : prefix + parent, prefix + child,
                        at * resolve(joint.SemanticPose(), "__model__"), &joint});
    }
    for (std::uint64_t m = 0; m < model.ModelCount(); ++m) {
      const sdf::Model& inner = *model.ModelByIndex(m);
      enter(inner, at, prefix + inner.Name() + "::", is_static);
    }
  }

  sdf::Root root_;
};

class Engine {
 public:
  explicit Engine(const Resolved& model) {
    skeleton->setGravity(model.gravity);
    std::map<std::string, const Joined*> inboard;
    for (const Joined& joint : model.joints) REQUIRE(inboard.emplace(joint.child, &joint).second);
    for (const auto& [name, link] : model.links) add(name, model, inboard);
  }

  dd::SkeletonPtr skeleton = dd::Skeleton::create("model");
  std::map<std::string, const Joined*> joined;  ///< by the joint's name

 private:
  template <class Type>
  dd::Joint* make(dd::BodyNode* parent, const Eigen::Isometry3d& at, const Eigen::Isometry3d& child_at, const std::string& name) {
    const auto [joint, node] = skeleton->createJointAndBodyNodePair<Type>(parent);
    joint->setTransformFromParentBodyNode(at);
    joint->setTransformFromChildBodyNode(child_at);
    node->setName(name);
    return joint;
  }

  static Eigen::Vector3d axis_of(const sdf::Joint& joint, unsigned i) {
    ignition::math::Vector3d axis;
    REQUIRE(joint.Axis(i)->ResolveXyz(axis).empty());
    return vector_of(axis).normalized();
  }

  dd::Joint* join(const Joined& joined_by, dd::BodyNode* parent, const Eigen::Isometry3d& at, const Eigen::Isometry3d& child_at) {
    const sdf::Joint& joint = *joined_by.joint;
    const std::string& child = joined_by.child;
    switch (joint.Type()) {
      case sdf::JointType::FIXED: return make<dd::WeldJoint>(parent, at, child_at, child);
      case sdf::JointType::BALL: return make<dd::BallJoint>(parent, at, child_at, child);
      case sdf::JointType::REVOLUTE:
      case sdf::JointType::CONTINUOUS: {
        dd::Joint* made = make<dd::RevoluteJoint>(parent, at, child_at, child);
        static_cast<dd::RevoluteJoint*>(made)->setAxis(axis_of(joint, 0));
        return made;
      }
      case sdf::JointType::PRISMATIC: {
        dd::Joint* made = make<dd::PrismaticJoint>(parent, at, child_at, child);
        static_cast<dd::PrismaticJoint*>(made)->setAxis(axis_of(joint, 0));
        return made;
      }
      case sdf::JointType::UNIVERSAL:
      case sdf::JointType::REVOLUTE2: {
        dd::Joint* made = make<dd::UniversalJoint>(parent, at, child_at, child);
        static_cast<dd::UniversalJoint*>(made)->setAxis1(axis_of(joint, 0));
        static_cast<dd::UniversalJoint*>(made)->setAxis2(axis_of(joint, 1));
        return made;
      }
      case sdf::JointType::SCREW: {
        dd::Joint* made = make<dd::ScrewJoint>(parent, at, child_at, child);
        static_cast<dd::ScrewJoint*>(made)->setAxis(axis_of(joint, 0));
        static_cast<dd::ScrewJoint*>(made)->setPitch(-2 * M_PI / joint.ThreadPitch());
        return made;
      }
      default: FAIL("a type of joint that this test does not know"); return nullptr;
    }
  }

  dd::BodyNode* add(const std::string& name, const Resolved& model, const std::map<std::string, const Joined*>& inboard) {
    if (dd::BodyNode* known = skeleton->getBodyNode(name)) return known;
    const Link& link = model.links.at(name);
    const auto found = inboard.find(name);
    dd::Joint* joint = nullptr;
    if (link.is_static) {
      joint = make<dd::WeldJoint>(nullptr, link.at, Eigen::Isometry3d::Identity(), name);
    } else if (found == inboard.end()) {
      joint = make<dd::FreeJoint>(nullptr, Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(), name);
      joint->setName(name);
    } else {
      const Joined& by = *found->second;
      dd::BodyNode* parent = by.parent.empty() ? nullptr : add(by.parent, model, inboard);
      const Eigen::Isometry3d from = by.parent.empty() ? Eigen::Isometry3d::Identity() : model.links.at(by.parent).at;
      joint = join(by, parent, from.inverse() * by.at, link.at.inverse() * by.at);
      joint->setName(by.name);
      joined[by.name] = &by;
    }
    dd::BodyNode* node = joint->getChildBodyNode();
    const auto moments = link.inertial.Moi();
    Eigen::Matrix3d moi;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) moi(r, c) = moments(static_cast<std::size_t>(r), static_cast<std::size_t>(c));
    node->setInertia(dd::Inertia(link.inertial.MassMatrix().Mass(), vector_of(link.inertial.Pose().Pos()), moi));
    return node;
  }
};

std::string name_of(const std::string& full) { return full.substr(full.find('/') + 1); }

void put(const BodySpec& body, Engine& engine) {
  if (body.joint.kind == Kind::weld) return;
  dd::Joint* joint = engine.skeleton->getJoint(name_of(body.joint_name));
  if (body.joint.kind == Kind::free) joint = engine.skeleton->getJoint(name_of(body.name));
  REQUIRE_MESSAGE(joint, body.joint_name);
  const auto rotation = [&](int i) { return Eigen::Quaterniond(body.q[i], body.q[i + 1], body.q[i + 2], body.q[i + 3]); };
  if (body.joint.kind == Kind::free) {
    Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
    placement.linear() = rotation(3).toRotationMatrix();
    placement.translation() = Eigen::Vector3d(body.q[0], body.q[1], body.q[2]);
    Eigen::Matrix<double, 6, 1> twist;
    twist << body.v[3], body.v[4], body.v[5], body.v[0], body.v[1], body.v[2];
    auto* free = dynamic_cast<dd::FreeJoint*>(joint);
    REQUIRE(free);
    free->setTransform(placement);
    free->setSpatialVelocity(twist, dd::Frame::World(), joint->getChildBodyNode());
    return;
  }
  REQUIRE(static_cast<int>(joint->getNumDofs()) == body.v.size());
  if (body.joint.kind == Kind::ball) joint->setPositions(dd::BallJoint::convertToPositions(rotation(0).toRotationMatrix()));
  const sdf::Joint& said = *engine.joined.at(name_of(body.joint_name))->joint;
  for (int i = 0; i < body.v.size(); ++i) {
    const auto dof = static_cast<std::size_t>(i);
    joint->setVelocity(dof, body.v[i]);
    if (body.joint.kind == Kind::ball) continue;
    joint->setPosition(dof, body.q[i]);
    const sdf::JointAxis& axis = *said.Axis(static_cast<unsigned>(i));
    joint->setForce(dof, -axis.Damping() * body.v[i] - axis.SpringStiffness() * (body.q[i] - axis.SpringReference()));
  }
}

void compare(const std::string& path, std::uint64_t seed) {
  CAPTURE(path);
  const std::string name = std::filesystem::path(path).stem().string();
  const io::ReadResult result = io::read_scenario(path, {"mechanism." + name + ".limits=false"});
  CAPTURE(io::rendered(result.diagnostics));
  REQUIRE(result.scenario);
  const Model& model = result.scenario->model;
  const Resolved resolved(path);
  Engine engine(resolved);
  REQUIRE(static_cast<std::size_t>(model.size()) == resolved.links.size());
  oracle::Prng random(seed);
  for (int sample = 0; sample < 100; ++sample) {
    Model here({.gravity = model.gravity()});
    for (BodySpec spec : model.bodies()) {
      spec = at_random_state(spec, random);
      spec.joint.parameters.friction = {};  // another law there
      here.add_unjudged(spec);
    }
    for (const BodySpec& body : here.bodies()) put(body, engine);
    engine.skeleton->computeForwardDynamics();
    const World world(here);
    double largest = 0, worst = 0;
    for (int b = 0; b < here.size(); ++b) {
      const BodySpec& body = here[{b}];
      const auto a = world.joint_forces({b}).a;
      Eigen::VectorXd theirs(static_cast<Eigen::Index>(a.size()));
      if (body.joint.kind == Kind::free) {
        const auto spatial = engine.skeleton->getBodyNode(name_of(body.name))->getSpatialAcceleration();
        theirs << spatial.tail<3>(), spatial.head<3>();
      } else if (!a.empty()) {
        const dd::Joint& joint = *engine.skeleton->getJoint(name_of(body.joint_name));
        for (std::size_t i = 0; i < a.size(); ++i) theirs[static_cast<Eigen::Index>(i)] = joint.getAcceleration(i);
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

// Cassie without the joints that close its loops.
std::string open_cassie(const io::test::TemporaryFolder& folder) {
  std::string text = io::read_text_file(MOMENTREE_SOURCE_DIR "/scenarios/models/cassie/cassie_v2.sdf");
  for (const char* joint :
       {"left-pitch-rod-joint", "right-pitch-rod-joint", "left-plantar-foot-joint", "right-plantar-foot-joint"}) {
    const std::size_t begin = text.find("<joint name=\"" + std::string(joint) + "\"");
    REQUIRE(begin != std::string::npos);
    text.erase(begin, text.find("</joint>", begin) + std::strlen("</joint>") - begin);
  }
  const std::string path = folder / "cassie.sdf";
  io::write_text_file(path, text);
  return path;
}

}  // namespace

TEST_CASE("libsdformat and DART: accelerations of SDF models at 100 random states") {
  compare(MOMENTREE_SOURCE_DIR "/tests/cross/models/every_joint.sdf", 1);
  compare(MOMENTREE_SOURCE_DIR "/tests/cross/models/of_old.sdf", 2);
  compare(MOMENTREE_SOURCE_DIR "/scenarios/models/iiwa14/iiwa14_no_collision.sdf", 3);
  const io::test::TemporaryFolder folder;
  compare(open_cassie(folder), 4);
}

}  // namespace momentree::peers

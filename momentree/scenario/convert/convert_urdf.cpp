#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include <momentree/base/error.hpp>
#include <momentree/models/import/imported.hpp>
#include <momentree/models/mesh/source.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/convert/describe.hpp>
#include <momentree/scenario/convert/urdf_writer.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

using namespace urdf;

bool is_identity(const Quat& r) { return std::fabs(r.w) == 1 && r.x == 0 && r.y == 0 && r.z == 0; }
bool is_zero(const Vec3& a) { return a.x == 0 && a.y == 0 && a.z == 0; }
bool is_identity(const Pose& pose) { return is_zero(pose.position) && is_identity(pose.rotation); }
// A product that leaves the digits of one placement unchanged if the other is the identity.
Pose times(const Pose& a, const Pose& b) { return is_identity(a) ? b : is_identity(b) ? a : a * b; }
Pose inverted(const Pose& a) { return is_identity(a) ? a : inverse(a); }

std::string parent_folder(const std::string& file) {
  const std::string folder = std::filesystem::path(file).parent_path().string();
  return folder.empty() ? "." : folder;
}

bool alike(const Values& values, int count) {
  for (int i = 1; i < count; ++i)
    if (values.of(i) != values.of(0)) return false;
  return true;
}

/// One joint of a chain that represents a joint of the model.
struct Part {
  const char* suffix;  ///< suffix of its name; empty: the joint's own name
  const char* type;    ///< revolute: continuous if it has no stops
  Vec3 axis;
  int dof;  ///< the DoF whose damping, friction and stops it has; −1: all DoFs
};

std::vector<Part> parts_of(const JointSpec& joint) {
  switch (joint.kind) {
    case Kind::revolute: return {{"", "revolute", joint.axis, 0}};
    case Kind::prismatic: return {{"", "prismatic", joint.axis, 0}};
    case Kind::weld: return {{"", "fixed", {}, -1}};
    case Kind::free: return {{"", "floating", {}, -1}};
    case Kind::planar: return {{"", "planar", z_axis, -1}};
    case Kind::universal: return {{".1", "revolute", joint.axis, 0}, {".2", "revolute", joint.axis2, 1}};
    case Kind::cylindrical: return {{".angle", "revolute", joint.axis, 0}, {".displacement", "prismatic", joint.axis, 1}};
    case Kind::ball: return {{".x", "revolute", x_axis, 0}, {".y", "revolute", y_axis, 1}, {".z", "revolute", z_axis, 2}};
    default: return {};
  }
}

class UrdfWriter {
 public:
  UrdfWriter(const Scenario& scenario, const std::string& folder)
      : scenario_(scenario), model_(scenario.model), folder_(folder), shift_(static_cast<std::size_t>(model_.size())) {}

  Converted write(BodyId root, const std::string& mechanism) {
    root_ = root;
    find_members();
    refuse_kinds();
    refuse_loops();
    for (const int b : members_) note_names(model_[BodyId{b}]);
    for (const int b : members_) add(b);
    note_world();
    report_losses();
    std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"" + escaped(mechanism) + "\">\n";
    for (const WrittenLink& link : links_) urdf::write(text, link);
    text += "\n";
    for (const WrittenJoint& joint : joints_) urdf::write(text, joint);
    return {text + "</robot>\n", std::move(diagnostics_)};
  }

 private:
  void find_members() {
    std::vector<char> in(static_cast<std::size_t>(model_.size()), 0);
    for (int b = 0; b < model_.size(); ++b) {
      const BodyId parent = model_[BodyId{b}].parent;
      in[static_cast<std::size_t>(b)] = b == root_.index || (parent != ground && in[static_cast<std::size_t>(parent.index)]);
      if (in[static_cast<std::size_t>(b)]) members_.push_back(b);
    }
  }

  void refuse_kinds() {
    std::string names;
    for (const int b : members_) {
      const BodySpec& spec = model_[BodyId{b}];
      if (parts_of(spec.joint).empty())
        names += (names.empty() ? "" : ", ") + in_quotes(spec.joint_name) + " is " + info(spec.joint.kind).name;
    }
    if (!names.empty())
      throw_error({"URDF has no such joint: " + names, scenario_.path, "write a .toml, or change the joint's kind"});
  }

  void refuse_loops() {
    std::string names;
    for (const LoopSpec& loop : model_.loops()) {
      const auto member = [&](BodyId body) { return std::find(members_.begin(), members_.end(), body.index) != members_.end(); };
      if (member(loop.body) || member(loop.to)) names += (names.empty() ? "" : ", ") + in_quotes(loop.name);
    }
    if (!names.empty())
      throw_error({"URDF has no closed loops: " + names, scenario_.path, "write a .toml, or remove the [[loop]] first"});
  }

  void note_names(const BodySpec& spec) {
    link_names_.insert(document_values::bare(spec.name));
    joint_names_.insert(document_values::bare(spec.joint_name));
  }
  static std::string fresh(std::unordered_set<std::string>& names, const std::string& wanted) {
    std::string name = wanted;
    for (int k = 2; !names.insert(name).second; ++k) name = wanted + "_" + std::to_string(k);
    return name;
  }

  // The pose of the link's frame in the body's frame: not the identity if URDF cannot express the joint in the body's own
  // frame. `at`, the placement of the joint's frame in the parent, and the axis are changed accordingly.
  Pose shift_of(const BodySpec& spec, const Part& last, Pose& at, Vec3& axis) {
    const Pose& c = spec.child_at;
    const std::string_view type = last.type;
    if (is_identity(c)) return {};
    const bool rotates_about = type == "revolute" && is_zero(c.position);
    // A planar joint is read with its frame turned by the shortest rotation that takes z to the axis.
    const bool normal = type == "planar" && is_zero(c.position) && std::fabs(c.rotation.z) < 1e-15 && c.rotation.w > 0;
    if (type != "fixed" && type != "prismatic" && !rotates_about && !normal) return c;
    at = times(at, inverted(c));
    if (!is_identity(c.rotation)) axis = rotation_matrix(c.rotation) * axis;
    return {};
  }

  // A root that is written as a link without a joint: the reader fixes it or leaves it free.
  bool plain_root(const BodySpec& spec) const {
    if (spec.parent != ground) return false;
    if (spec.joint.kind == Kind::weld) return is_identity(times(spec.at, inverted(spec.child_at)));
    return spec.joint.kind == Kind::free && is_identity(spec.at) && !spec.joint.parameters.damping.any() &&
           !spec.joint.parameters.friction.any();
  }

  void add(int b) {
    const BodySpec& spec = model_[BodyId{b}];
    const auto k = static_cast<std::size_t>(b);
    std::vector<Part> parts = parts_of(spec.joint);
    const bool root = spec.parent == ground;
    std::string parent = root ? "" : document_values::bare(model_[spec.parent].name);
    Pose at = root ? spec.at : times(inverted(shift_[static_cast<std::size_t>(spec.parent.index)]), spec.at);
    note_lost(spec);
    if (plain_root(spec)) {
      shift_[k] = spec.joint.kind == Kind::free ? spec.child_at : Pose{};
      if (spec.joint.kind == Kind::free)
        say(Severity::note, "the root " + in_quotes(spec.name) + " is free, which URDF cannot express",
            "read it with root = \"free\"", {});
      links_.push_back(link_of(spec, k));
      return;
    }
    if (root) {
      parent = fresh(link_names_, "world");
      links_.push_back({parent, ""});
    }
    if (parts.size() > 1) chains_[spec.joint.kind].push_back(spec.joint_name);
    const std::string joint_name = document_values::bare(spec.joint_name);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Part& part = parts[i];
      const bool last = i + 1 == parts.size();
      WrittenJoint joint;
      joint.name = parts.size() == 1 ? joint_name : fresh(joint_names_, joint_name + part.suffix);
      joint.type = part.type;
      joint.parent = parent;
      joint.axis = part.axis;
      joint.has_axis = joint.type != "fixed" && joint.type != "floating";
      if (last) shift_[k] = shift_of(spec, part, at, joint.axis);
      joint.origin = at;
      take_parameters(spec, part, joint);
      if (last) {
        joint.child = document_values::bare(spec.name);
        links_.push_back(link_of(spec, k));
      } else {
        joint.child = parent = fresh(link_names_, document_values::bare(spec.name) + part.suffix);
        links_.push_back({parent, "no mass: one of the joints that represent " + joint_name});
      }
      joints_.push_back(std::move(joint));
      at = {};
    }
  }

  WrittenLink link_of(const BodySpec& spec, std::size_t k) {
    WrittenLink link;
    const Pose &shift = shift_[k], back = inverted(shift);
    link.name = document_values::bare(spec.name);
    link.mass = spec.mass;
    link.com = is_identity(shift) ? spec.com : back * spec.com;
    link.inertia = is_identity(shift.rotation) ? spec.inertia : rotate(rotation_matrix(back.rotation), spec.inertia);
    if (!is_identity(shift)) {
      const auto text = [](const Vec3& a) {
        return rounded_text(a.x, 6) + " " + rounded_text(a.y, 6) + " " + rounded_text(a.z, 6);
      };
      link.comment = link.name + ": the frame is moved to its joint, by xyz " + text(shift.position) + " rpy " +
                     text(document_values::rpy_of(shift.rotation).angles);
      ++moved_;
    }
    if (k < scenario_.shapes.size()) {
      const auto add = [&](const Shape& shape) {
        if (shape.as<contact::Ellipsoid>() || (shape.kind == Shape::Kind::primitive && !contact::standard(shape.primitive)))
          lost_[contact::info(shape.primitive).plural].push_back({spec.joint_name, "shape"});
        else
          add_shape(link, shape, back);
      };
      add(scenario_.shapes[k]);
      for (const Shape& shape : scenario_.shapes[k].more) add(shape);
    }
    return link;
  }

  void add_shape(WrittenLink& link, Shape shape, const Pose& back) {
    if (shape.kind == Shape::Kind::none) return;
    if (shape.source && (shape.source->path.empty() || !shape.source->submesh.empty())) return;  // not a whole file
    if (shape.kind == Shape::Kind::mesh) {  // if it is not found, it keeps the name given in the source
      const std::string mesh = mesh_path(shape.mesh, {parent_folder(scenario_.path), folder_.empty() ? "." : folder_});
      if (!mesh.empty()) shape.mesh = mesh;
    }
    shape.at = times(back, shape.at);
    link.shapes.push_back(std::move(shape));
  }

  void take_parameters(const BodySpec& spec, const Part& part, WrittenJoint& joint) {
    const JointParameters& p = spec.joint.parameters;
    const KindInfo& kind = info(spec.joint.kind);
    const int i = std::max(part.dof, 0);
    // The damping of a ball joint differs from that of three axes.
    const bool one = part.dof >= 0 && spec.joint.kind != Kind::ball;
    if (one || (kind.nv > 0 && spec.joint.kind != Kind::ball && alike(p.damping, kind.nv))) joint.damping = p.damping.of(i);
    if (one || (kind.nv > 0 && spec.joint.kind != Kind::ball && alike(p.friction.coulomb, kind.nv)))
      joint.friction = p.friction.coulomb.of(i);
    if (!one) return;
    if (p.drive && !p.drive->pd.max_effort.empty() && std::isfinite(p.drive->pd.max_effort.of(i)))
      joint.effort = p.drive->pd.max_effort.of(i);
    joint.lower = p.limits.lower_of(i), joint.upper = p.limits.upper_of(i);
    joint.stops = std::isfinite(joint.lower) || std::isfinite(joint.upper);
    if (joint.type == "revolute" && !joint.stops) joint.type = "continuous";
  }

  // Notes what URDF cannot express of this joint.
  void note_lost(const BodySpec& spec) {
    const JointParameters& p = spec.joint.parameters;
    const KindInfo& kind = info(spec.joint.kind);
    const bool ball = spec.joint.kind == Kind::ball, several = kind.nv > 1 && parts_of(spec.joint).size() == 1;
    const auto lose = [&](const char* what, const char* key) { lost_[what].push_back({spec.joint_name, key}); };
    if (p.stiffness.any()) lose("springs", "stiffness");
    if (p.armature.any()) lose("armatures", "armature");
    if (p.effort.any() || (p.drive && (!p.drive->effort.empty() || p.drive->pd.any() || p.drive->moves())))
      lose("drives", "drive");
    if (p.strength.any()) lose("strengths", "strength");
    if (p.damping.any() && (ball || (several && !alike(p.damping, kind.nv)))) lose("damping per degree of freedom", "damping");
    if (p.friction.any() && (ball || (several && !alike(p.friction.coulomb, kind.nv))))
      lose("friction per degree of freedom", "friction");
    bool other_speed = false;
    for (int i = 0; i < kind.nv; ++i)
      other_speed = other_speed || (p.friction.coulomb.of(i) > 0 && p.friction.speed.of(i) != imported_friction_speed);
    if (other_speed) lose("speeds over which friction builds up", "friction");
    if (p.limits.any() && several) lose("limits of several degrees of freedom", "limits");
    if (p.limits.soft()) lose("stiffness and damping of stops", "limits");
    if (p.limits.hard() && p.limits.restitution.any()) lose("restitution of stops", "limits");
    const bool driven = p.drive && p.drive->moves();
    const bool starts = spec.v.any() || !(spec.q.empty() || spec.q == joint_zero(spec.joint.kind));
    if (starts && !driven) lose("starts", "q");
  }

  void note_world() {
    const Vec3 g = model_.gravity(), usual = Model().gravity();
    std::string all;
    if (g.x != usual.x || g.y != usual.y || g.z != usual.z) all += ", its gravity";
    if (!model_.forces().empty()) all += ", " + std::to_string(model_.forces().size()) + " forces on bodies";
    if (!model_.springs().empty()) all += ", " + std::to_string(model_.springs().size()) + " springs between bodies";
    if (!model_.elements().empty() || !model_.couplings().empty()) all += ", the couplings of its joints";
    if (!scenario_.events.empty()) all += ", its events";
    if (!scenario_.state_files.empty()) all += ", its state document";
    if (!all.empty()) say(Severity::warning, "a URDF holds only a model; left out: " + all.substr(2), "", {});
  }

  struct Lost {
    std::string joint;
    const char* key;
  };

  void report_losses() {
    for (const auto& [what, joints] : lost_) {
      std::string names;
      for (std::size_t i = 0; i < joints.size() && i < 5; ++i) names += (i ? ", " : "") + in_quotes(joints[i].joint);
      if (joints.size() > 5) names += " and " + std::to_string(joints.size() - 5) + " more";
      say(Severity::warning, "URDF cannot express " + what + "; left out at " + names, "", place_of(joints.front()));
    }
    for (const auto& [kind, joints] : chains_) {
      const std::string count =
          std::to_string(joints.size()) + " " + info(kind).name + (joints.size() == 1 ? " joint is" : " joints are");
      say(Severity::note, count + " written as chains of links without mass, from " + in_quotes(joints.front()),
          kind == Kind::ball ? "the motion is the same, except where the middle axis turns by 90 deg" : "the motion is the same",
          {});
    }
    if (moved_ > 0)
      say(Severity::note,
          "the frames of " + std::to_string(moved_) + (moved_ == 1 ? " link are" : " links are") +
              " moved to their joints, as URDF requires",
          "comments give the original frames", {});
  }

  void say(Severity severity, std::string what, std::string hint, Place place) {
    diagnostics_.push_back({severity, scenario_.path, place.line, place.column, std::move(what), std::move(hint), ""});
  }

  static Place place_in(const Value& table, const char* key) {
    const std::vector<const char*> keys = key == std::string_view("q")
                                              ? std::vector<const char*>{"q", "angle", "position", "v", "speed"}
                                              : std::vector<const char*>{key};
    for (const char* each : keys)
      if (const Value::Entry* entry = table.find(each)) return entry->value.place;
    return table.place;
  }

  // The place in the scenario; none for values from a model file or a generator.
  Place place_of(const Lost& lost) const {
    const Value::Entry* mechanisms = scenario_.document ? scenario_.document->find("mechanism") : nullptr;
    if (!mechanisms || !mechanisms->value.array()) return {};
    for (const Value& mechanism : *mechanisms->value.array()) {
      const Value::Entry *name = mechanism.find("name"), *bodies = mechanism.find("body"), *chain = mechanism.find("chain");
      if (!name || !name->value.string() || lost.joint.rfind(*name->value.string() + "/", 0) != 0) continue;
      if (chain) return place_in(chain->value, lost.key);
      if (!bodies || !bodies->value.array()) continue;
      for (const Value& body : *bodies->value.array()) {
        const Value::Entry* joint = body.find("joint");
        const Value::Entry* named = joint ? joint->value.find("name") : nullptr;
        if (!named) named = body.find("name");
        if (!joint || !named || !named->value.string() || *named->value.string() != document_values::bare(lost.joint)) continue;
        return place_in(joint->value, lost.key);
      }
    }
    return {};
  }

  const Scenario& scenario_;
  const Model& model_;
  std::string folder_;
  std::vector<Pose> shift_;  ///< by body: the pose of its link's frame in its own frame
  BodyId root_{};
  std::vector<int> members_;
  std::unordered_set<std::string> link_names_, joint_names_;
  std::vector<WrittenLink> links_;
  std::vector<WrittenJoint> joints_;
  std::map<std::string, std::vector<Lost>> lost_;
  std::map<Kind, std::vector<std::string>> chains_;
  int moved_ = 0;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace

Converted to_urdf(const Scenario& scenario, const std::string& mechanism, const std::string& folder) {
  std::vector<std::string> names;
  std::string all;
  BodyId chosen;
  for (int b = 0; b < scenario.model.size(); ++b) {
    if (scenario.model[BodyId{b}].parent != ground) continue;
    names.push_back(scenario.model.mechanism_name({b}));
    if (names.size() <= 10) all += (all.empty() ? "" : ", ") + in_quotes(names.back());
    if (names.back() == mechanism || mechanism.empty()) chosen = {b};
  }
  if (names.size() > 10) all += " …";
  if (mechanism.empty() && names.size() > 1)
    throw_error({"a URDF holds one mechanism, but the scenario has " + std::to_string(names.size()) + ": " + all, scenario.path,
                 "choose one with --mechanism NAME"});
  if (chosen == ground) {
    const std::string hint = did_you_mean(mechanism, names);
    throw_error({"there is no mechanism " + in_quotes(mechanism), scenario.path, hint.empty() ? "known: " + all : hint});
  }
  return UrdfWriter(scenario, folder).write(chosen, mechanism.empty() ? names.front() : mechanism);
}

}  // namespace momentree::io

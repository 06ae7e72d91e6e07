// Converts links and joints into bodies: the tree, the joints in the frames of their two links, static models.
#include <cmath>
#include <unordered_set>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/models/sdf/frames.hpp>

namespace momentree::io::sdf {

namespace {

struct Joined {
  const JointPart* part = nullptr;
  int frame = -1, scope = -1, parent = -1, child = -1;  ///< parent, child: frames of links; a parent of −1: the world
};

class Builder {
 public:
  Builder(const ModelPart& outermost, Import& import) : import_(import), frames_(outermost, import) {}

  void build() {
    if (!frames_.sound()) return;
    collect_links();
    for (int s = 0; s < static_cast<int>(frames_.scopes().size()); ++s) collect_joints(s);
    if (!frames_.sound()) return;
    if (links_.empty())
      return frames_.error({frames_.scopes()[0].part->element}, "there is no <link> in it", "for example <link name=\"base\">");
    const LinkTree tree = arrange(links_, ends_, Loops::closed, import_);
    body_of_.assign(links_.size(), -1);
    for (const NamedJoint& each : ends_) joint_names_.insert(each.name);
    for (const std::size_t link : tree.order) add_body(link, tree);
    for (const std::size_t joint : tree.loops) add_loop(joint);
    if (import_.errors() == 0) follow(tree);
  }

 private:
  struct Linked {
    const LinkPart* part;
    int frame, scope;
  };

  void collect_links() {
    const auto& scopes = frames_.scopes();
    for (int s = 0; s < static_cast<int>(scopes.size()); ++s) {
      const Scope& scope = scopes[static_cast<std::size_t>(s)];
      int frame = scope.first_link;
      for (const LinkPart& link : scope.part->links) {
        parts_.push_back({&link, frame++, s});
        links_.push_back({scope.prefix + link.name, link.element});
      }
    }
  }

  std::size_t link_at(int frame) const { return static_cast<std::size_t>(frames_.frame(frame).link); }
  bool is_static(int link_frame) const {
    return frames_.scopes()[static_cast<std::size_t>(frames_.frame(link_frame).scope)].is_static;
  }

  void collect_joints(int s) {
    const Scope& scope = frames_.scopes()[static_cast<std::size_t>(s)];
    int frame = scope.first_joint;
    for (const JointPart& part : scope.part->joints) {
      Joined joint{&part, frame++, s, -1, -1};
      joint.child = frames_.link_of(joint.frame);
      if (part.parent != "world") {
        const int parent = frames_.look_up(s, part.parent, part.parent_spot, "parent");
        if (parent < 0) continue;
        joint.parent = frames_.link_of(parent);
      }
      if (joint.child < 0) {
        frames_.error(part.child_spot, "child: " + in_quotes(part.child) + " is fixed in the world", "swap parent and child");
        continue;
      }
      if (is_static(joint.child)) {
        if (joint.parent < 0 || is_static(joint.parent)) {
          import_.file_of(part.element).once(Severity::note, "a joint of a static model is ignored", "", {part.element});
          continue;
        }
        frames_.error(part.child_spot,
                      "child: " + in_quotes(part.child) + " belongs to a static model, and the joint would carry it",
                      "swap parent and child, or make the model non-static");
        continue;
      }
      NamedJoint ends;
      ends.name = scope.prefix + part.name;
      ends.child = links_[link_at(joint.child)].name;
      ends.from_ground = joint.parent < 0;
      if (joint.parent >= 0) ends.parent = links_[link_at(joint.parent)].name;
      ends.rows = 6 - info(part.kind).nv;
      ends.element = part.element;
      ends.parent_spot = part.parent_spot;
      ends.child_spot = part.child_spot;
      ends_.push_back(std::move(ends));
      joints_.push_back(joint);
    }
  }

  Vec3 axis_of(const Joined& joint, const AxisPart& axis) {
    int frame = joint.frame;
    if (!axis.expressed_in.empty()) frame = frames_.look_up(joint.scope, axis.expressed_in, axis.location, "expressed_in");
    if (frame < 0) return axis.xyz;
    return rotation_matrix(frames_.between(joint.frame, frame).rotation) * axis.xyz;
  }

  void join(const Joined& joint, BodySpec& spec, ImportedBody& body) {
    const JointPart& part = *joint.part;
    spec.at = joint.parent < 0 ? frames_.frame(joint.frame).placed : frames_.between(joint.parent, joint.frame);
    spec.child_at = frames_.between(joint.child, joint.frame);
    spec.joint.kind = part.kind;
    if (part.kind == Kind::helical) spec.joint.pitch = part.pitch;
    if (part.dofs > 0) spec.joint.axis = axis_of(joint, part.axes[0]);
    if (part.dofs > 1) spec.joint.axis2 = axis_of(joint, part.axes[1]);
    JointParameters& p = spec.joint.parameters;
    const auto take = [&](Values& target, double AxisPart::*value) {
      bool any = false;
      for (int i = 0; i < part.dofs; ++i) any = any || part.axes[static_cast<std::size_t>(i)].*value != 0;
      for (int i = 0; any && i < part.dofs; ++i) target.push_back(part.axes[static_cast<std::size_t>(i)].*value);
    };
    take(p.damping, &AxisPart::damping);
    take(p.stiffness, &AxisPart::stiffness);
    if (p.stiffness.any()) take(p.rest, &AxisPart::rest);
    take(p.friction.coulomb, &AxisPart::friction);
    if (p.friction.any()) p.friction.speed = imported_friction_speed;
    bool limited = false;
    for (int i = 0; i < part.dofs; ++i) {
      const AxisPart& axis = part.axes[static_cast<std::size_t>(i)];
      limited = limited || std::isfinite(axis.lower) || std::isfinite(axis.upper);
      if (axis.limit && !body.spots.limits) body.spots.limits = axis.limit;
    }
    for (int i = 0; limited && i < part.dofs; ++i) {
      body.limits.lower.push_back(part.axes[static_cast<std::size_t>(i)].lower);
      body.limits.upper.push_back(part.axes[static_cast<std::size_t>(i)].upper);
    }
  }

  void add_body(std::size_t link, const LinkTree& tree) {
    const auto& [part, frame, scope] = parts_[link];
    ImportedBody& body = import_.model.bodies.emplace_back();
    BodySpec& spec = body.spec;
    spec.name = links_[link].name;
    spec.mass = part->mass;
    spec.com = part->com;
    spec.inertia = part->inertia;
    body.spots = {frames_.scopes()[static_cast<std::size_t>(scope)].part->file, part->element, {}, part->inertial, {}};
    body.shapes = part->shapes;
    for (const auto& [shape, pose] : part->placed_shapes) {
      const int base = frames_.look_up(scope, pose.relative_to, pose.location, "pose");
      if (base >= 0) body.shapes[shape].at = frames_.between(frame, base) * pose.pose;
    }
    body.collision = part->collision, body.friction = part->friction;
    for (const auto& [shape, pose] : part->placed_collision) {
      const int base = frames_.look_up(scope, pose.relative_to, pose.location, "pose");
      if (base >= 0) body.collision[shape].at = frames_.between(frame, base) * pose.pose;
    }
    body_of_[link] = static_cast<int>(import_.model.bodies.size()) - 1;
    if (tree.joint[link] >= 0) {
      const auto j = static_cast<std::size_t>(tree.joint[link]);
      if (tree.parent[link] >= 0) spec.parent = {body_of_[static_cast<std::size_t>(tree.parent[link])]};
      spec.joint_name = ends_[j].name;
      body.spots.joint = ends_[j].element;
      join(joints_[j], spec, body);
      return;
    }
    spec.at = frames_.frame(frame).placed;
    spec.joint_name = spec.name;
    if (joint_names_.contains(spec.name)) spec.joint_name += "~root";
    if (is_static(frame)) return;  // welded to the ground
    body.own_joint = false;
    body.floats = true;
  }

  void add_loop(std::size_t j) {
    const Joined& joint = joints_[j];
    ImportedBody joined;  // as if it were the inboard joint of its child
    join(joint, joined.spec, joined);
    ImportedLoop& loop = import_.model.loops.emplace_back();
    loop.spec.name = ends_[j].name;
    loop.spec.body = {body_of_[link_at(joint.child)]};
    loop.spec.to = joint.parent < 0 ? ground : BodyId{body_of_[link_at(joint.parent)]};
    loop.spec.joint = std::move(joined.spec.joint);
    loop.spec.at = joined.spec.at;
    loop.spec.child_at = joined.spec.child_at;
    loop.limits = std::move(joined.limits);
    const XmlElement element = joint.part->element;
    loop.spots = {&import_.file_of(element), element, element, {}, joined.spots.limits};
  }

  // <mimic> of newer versions.
  void follow(const LinkTree& tree) {
    std::unordered_map<std::string_view, int> body_of_joint;
    for (std::size_t link = 0; link < links_.size(); ++link)
      if (tree.joint[link] >= 0) body_of_joint.emplace(ends_[static_cast<std::size_t>(tree.joint[link])].name, body_of_[link]);
    for (std::size_t j = 0; j < joints_.size(); ++j)
      for (const AxisPart& axis : joints_[j].part->axes) {
        if (!axis.mimic) continue;
        XmlFile& file = import_.file_of(axis.mimic);
        Texts texts(axis.mimic, file);
        texts.fields.require("joint", "the name of the joint that it follows");
        const auto leader = texts.fields.string("joint");
        texts.fields.known({"axis"});
        Follower follower;
        follower.file = &file;
        follower.element = axis.mimic;
        follower.multiplier = texts.number("multiplier").value_or(0);
        follower.offset = texts.number("offset").value_or(0) - follower.multiplier * texts.number("reference").value_or(0);
        texts.fields.finish();
        if (!leader) continue;
        const auto own = body_of_joint.find(ends_[j].name);
        if (own == body_of_joint.end()) {
          file.warning({axis.mimic},
                       "joint " + in_quotes(ends_[j].name) + " closes a loop and can't follow another: <mimic> is ignored",
                       "its position follows from the joints of the tree");
          continue;
        }
        const std::string full = frames_.scopes()[static_cast<std::size_t>(joints_[j].scope)].prefix + *leader;
        const auto other = body_of_joint.find(full);
        if (other == body_of_joint.end()) {
          file.error(texts.fields.location("joint"),
                     joint_names_.contains(full) ? "mimic: joint " + in_quotes(*leader) + " closes a loop and can't lead another"
                                                 : "mimic: there is no joint " + in_quotes(*leader));
          continue;
        }
        follower.body = own->second;
        follower.leader = other->second;
        import_.model.followers.push_back(follower);
      }
  }

  Import& import_;
  Frames frames_;
  std::vector<Linked> parts_;
  std::vector<NamedLink> links_;
  std::vector<Joined> joints_;
  std::vector<NamedJoint> ends_;
  std::vector<int> body_of_;
  std::unordered_set<std::string_view> joint_names_;
};

}  // namespace

void build(const ModelPart& outermost, Import& import) { Builder(outermost, import).build(); }

}  // namespace momentree::io::sdf

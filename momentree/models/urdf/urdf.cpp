#include <momentree/models/importers/urdf.hpp>

#include <memory>
#include <unordered_set>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/models/urdf/parts.hpp>

namespace momentree::io {

namespace {

using namespace urdf;

Materials read_materials(XmlFields& fields, XmlFile& file) {
  Materials materials;
  for (const XmlElement material : fields.children("material")) {
    const std::string colour = read_material(material, file);
    const auto name = material.find("name");
    if (name && !colour.empty()) materials.emplace(material.attribute(*name), colour);
  }
  return materials;
}

// Checks that there is one tree: another link without a parent is a mistake.
void check_roots(const std::deque<ImportedBody>& bodies, XmlFile& file) {
  const ImportedBody* first = nullptr;
  for (const ImportedBody& body : bodies) {
    if (body.spec.parent != ground) continue;
    if (first)
      file.error({body.spots.body},
                 "a second root: link " + in_quotes(body.spec.name) + " is not the child of any joint, like " +
                     in_quotes(first->spec.name) + " on " + file.line_of(first->spots.body),
                 "join one to the other, or make two files");
    else
      first = &body;
  }
}

void join(const Joint& joint, const NamedJoint& ends, ImportedBody& body) {
  BodySpec& spec = body.spec;
  spec.at = joint.at;
  spec.child_at.rotation = joint.turn;
  spec.joint_name = ends.name;
  spec.joint.kind = joint.kind;
  spec.joint.axis = joint.axis;
  if (joint.damping > 0) spec.joint.parameters.damping = joint.damping;
  if (joint.friction > 0) spec.joint.parameters.friction = {joint.friction, imported_friction_speed};
  if (joint.limit) body.limits.lower = joint.lower, body.limits.upper = joint.upper;
  body.spots.joint = ends.element;
  body.spots.limits = joint.limit;
}

void read_mimics(const std::vector<Joint>& joints, const std::vector<NamedJoint>& ends, const LinkTree& tree,
                 const std::vector<int>& body_of_link, Import& import) {
  XmlFile& file = import.file();
  std::unordered_map<std::string_view, int> body_of_joint;
  for (std::size_t link = 0; link < body_of_link.size(); ++link)
    if (tree.joint[link] >= 0) body_of_joint.emplace(ends[static_cast<std::size_t>(tree.joint[link])].name, body_of_link[link]);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    if (!joint.mimic) continue;
    XmlFields fields(joint.mimic, file);
    fields.require("joint", "the name of the joint that it follows");
    Follower follower;
    follower.file = &file;
    follower.element = joint.mimic;
    const auto leader = fields.string("joint");
    follower.multiplier = fields.number("multiplier").value_or(1);
    follower.offset = fields.number("offset").value_or(0);
    fields.finish();
    const auto own = body_of_joint.find(ends[j].name);
    if (!leader || own == body_of_joint.end()) continue;
    const auto found = body_of_joint.find(usable_name(*leader));
    if (found == body_of_joint.end()) {
      std::vector<std::string> names;
      if (ends.size() <= 10'000 && !file.enough())
        for (const NamedJoint& each : ends) names.push_back(each.name);
      file.warning(
          fields.location("joint"),
          "mimic: there is no joint " + in_quotes(*leader) + ": joint " + in_quotes(ends[j].name) + " moves independently",
          did_you_mean(*leader, names));
      continue;
    }
    follower.body = own->second;
    follower.leader = found->second;
    import.model.followers.push_back(follower);
  }
}

}  // namespace

void Urdf::read(XmlElement robot, Import& import) {
  XmlFile& file = import.file();
  XmlFields fields(robot, file);
  fields.known({"version"});
  import.model.title = fields.string("name").value_or("");
  if (import.model.title.empty()) file.warning({robot}, "<robot> has no 'name'");
  const Materials materials = read_materials(fields, file);

  std::vector<std::unique_ptr<ImportedBody>> bodies;
  std::vector<NamedLink> links;
  for (const XmlElement link : fields.children("link")) {
    if (bodies.size() == Import::most_bodies) return file.error({link}, "more than 1000000 links");
    bodies.push_back(std::make_unique<ImportedBody>(read_link(link, materials, import)));
    links.push_back({bodies.back()->spec.name, link});
    if (file.enough()) return;
  }
  std::vector<Joint> joints;
  std::vector<NamedJoint> ends;
  for (const XmlElement joint : fields.children("joint")) {
    joints.push_back(read_joint(joint, file));
    ends.push_back(std::move(joints.back().ends));
    if (file.enough()) return;
  }
  fields.leave_out({"transmission"}, "efforts act on joints directly");
  const std::vector<XmlElement> gazebo = fields.children("gazebo");
  fields.leave_out({"sensor", "ros2_control"}, "it belongs to another program");
  fields.finish();
  if (links.empty()) return file.error({robot}, "the robot has no <link>");

  const std::size_t errors = file.out().errors();
  const LinkTree tree = arrange(links, ends, Loops::refused, import);
  std::vector<int> body_of_link(links.size(), -1);
  std::unordered_set<std::string_view> joint_names;
  for (const NamedJoint& each : ends) joint_names.insert(each.name);
  for (const std::size_t link : tree.order) {
    ImportedBody& body = import.model.bodies.emplace_back(std::move(*bodies[link]));
    bodies[link].reset();
    if (tree.joint[link] >= 0) {
      const auto j = static_cast<std::size_t>(tree.joint[link]);
      body.spec.parent = {body_of_link[static_cast<std::size_t>(tree.parent[link])]};
      join(joints[j], ends[j], body);
    } else {
      body.own_joint = false;
      body.spec.joint_name = body.spec.name;
      if (joint_names.contains(body.spec.name)) body.spec.joint_name += "~root";
    }
    body_of_link[link] = static_cast<int>(import.model.bodies.size()) - 1;
  }
  if (errors != file.out().errors()) return;
  check_roots(import.model.bodies, file);
  read_mimics(joints, ends, tree, body_of_link, import);
  read_gazebo(gazebo, import.model, file);
}

}  // namespace momentree::io

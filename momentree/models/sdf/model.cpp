// Models, worlds, and the files that they include.
#include <algorithm>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/models/sdf/parts.hpp>

namespace momentree::io::sdf {

namespace {

constexpr int deepest = 100;
constexpr std::size_t most_links = 1'000'000, most_models = 100'000;

void read_gravity(Texts& world, Reading& reading, XmlFile& file) {
  constexpr Vec3 by_format{0, 0, -9.8};
  reading.gravity = by_format;
  if (const auto gravity = world.vec3("gravity")) {
    reading.gravity = *gravity;
    return;
  }
  for (const XmlElement physics : world.fields.children("physics"))  // until 1.5
    for (const XmlElement child : physics.children())
      if (child.name() == "gravity") {
        const XmlLocation location{child, XmlLocation::no_attribute, true};
        if (const auto g = read_numbers(child.text(), 3, 3, location, "gravity", file))
          reading.gravity = {(*g)[0], (*g)[1], (*g)[2]};
      }
}

void add(ModelPart& model, NestedPart nested, XmlFile& file) {
  model.all_links += nested.model->all_links;
  model.all_models += nested.model->all_models;
  if (model.all_links > most_links || model.all_models > most_models) {
    file.error({nested.element},
               "more than " + std::to_string(most_links) + " links or " + std::to_string(most_models) +
                   " models, with those of included files",
               "do files include each other repeatedly?");
    model.all_links -= nested.model->all_links;
    model.all_models -= nested.model->all_models;
    return;
  }
  model.levels = std::max(model.levels, nested.model->levels + 1);
  if (model.levels > deepest + 1) {
    file.error({nested.element}, "models are nested more than " + std::to_string(deepest) + " deep", "no mechanism needs that");
    model.levels = 1;
    return;
  }
  model.nested.push_back(std::move(nested));
}

FramePart read_frame(XmlElement element, Version version, XmlFile& file) {
  FramePart frame;
  frame.element = element;
  XmlFields fields(element, file);
  frame.name = read_name(fields, "a frame", version, file);
  frame.attached_to = fields.string("attached_to").value_or("");
  frame.attached_spot = fields.location("attached_to");
  frame.pose = read_pose(fields, version, file);
  fields.finish();
  return frame;
}

void leave_out(Texts& texts, bool is_world) {
  XmlFields& fields = texts.fields;
  if (is_world) {
    fields.known_children({"physics"});
    fields.leave_out({"light", "gui", "scene", "audio", "spherical_coordinates", "road", "actor", "plugin"},
                     "it belongs to another program");
    fields.leave_out({"atmosphere", "wind", "magnetic_field"}, "a scenario's [[force]] acts on bodies");
    fields.leave_out({"state"}, "joints start at zero: a scenario can give other initial values");
    fields.leave_out({"population"}, "list its models one by one");
  } else {
    fields.known_children({"self_collide", "allow_auto_disable", "enable_wind"});
    fields.leave_out({"gripper", "plugin"}, "it belongs to another program");
  }
}

}  // namespace

std::shared_ptr<ModelPart> read_model(XmlElement element, Version version, Reading& reading, XmlFile& file, int depth) {
  auto model = std::make_shared<ModelPart>();
  model->version = version;
  model->element = element;
  model->file = &file;
  model->is_world = element.name() == "world";
  if (depth > deepest) {
    file.error({element}, "models are nested more than " + std::to_string(deepest) + " deep", "no mechanism needs that");
    model->levels = 0;  // reported
    return model;
  }
  Texts texts(element, file);
  XmlFields& fields = texts.fields;
  if (model->is_world) {
    model->name = fields.string("name").value_or("");
    read_gravity(texts, reading, file);
  } else {
    model->name = read_name(fields, "a model", version, file);
    model->canonical_link = fields.string("canonical_link").value_or("");
    model->canonical_spot = fields.location("canonical_link");
    model->placement_frame = fields.string("placement_frame").value_or("");
    model->placement_spot = fields.location("placement_frame");
    model->is_static = texts.boolean("static").value_or(false);
    model->pose = read_pose(fields, version, file);
    const auto links = fields.children("link");
    model->links.reserve(links.size());
    for (const XmlElement link : links) {
      model->links.push_back(read_link(link, version, reading.import, file));
      if (file.enough()) return model;
    }
    model->all_links = links.size();
  }
  for (const XmlElement frame : fields.children("frame")) model->frames.push_back(read_frame(frame, version, file));
  const auto joints = fields.children("joint");
  model->joints.reserve(joints.size());
  for (const XmlElement joint : joints) {
    model->joints.push_back(read_joint(joint, version, file));
    if (file.enough()) return model;
  }
  fields.known_children({"model", "include"});
  for (const XmlElement child : element.children()) {
    if (file.enough()) return model;
    if (child.name() == "model") {
      NestedPart nested;
      nested.model = read_model(child, version, reading, file, depth + 1);
      nested.name = nested.model->name;
      nested.placement_frame = nested.model->placement_frame;
      nested.placement_spot = nested.model->placement_spot;
      nested.pose = nested.model->pose;
      nested.is_static = nested.model->is_static;
      nested.element = child;
      add(*model, std::move(nested), file);
    } else if (child.name() == "include") {
      if (auto nested = read_include(child, *model, reading, file, depth + 1)) add(*model, std::move(*nested), file);
    }
  }
  leave_out(texts, model->is_world);
  fields.finish();
  return model;
}

}  // namespace momentree::io::sdf

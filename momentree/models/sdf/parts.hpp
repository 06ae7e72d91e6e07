#pragma once
// The parts of SDF files as they are written, one reader each, before names are resolved. Internal to the importer.
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <momentree/models/import/importer.hpp>
#include <momentree/models/xml/fields.hpp>

namespace momentree::io::sdf {

/// The version of a file: 1.`minor`.
struct Version {
  int minor = 10;
  bool frames() const { return minor >= 7; }  ///< poses name the frames that they are relative to
};

/// Children of one element that contain text: SDF uses them where other formats have attributes.
class Texts {
 public:
  Texts(XmlElement element, XmlFile& file) : fields(element, file), file_(file) {}

  /// Typed values: nothing if the child is absent, or if it is wrong and was reported.
  std::optional<std::string> string(std::string_view child);
  std::optional<double> number(std::string_view child);
  std::optional<double> not_negative(std::string_view child);
  /// A number, inf or -inf.
  std::optional<double> bound(std::string_view child);
  std::optional<Vec3> vec3(std::string_view child);
  std::optional<bool> boolean(std::string_view child);
  /// The place of the text of the child read last.
  const XmlLocation& location() const { return spot_; }

  XmlFields fields;

 private:
  XmlElement leaf(std::string_view child);
  XmlFile& file_;
  XmlLocation spot_{};
};

/// A placement in a frame that is still a name; empty: the default frame of the format.
struct FramedPose {
  Pose pose{};
  std::string relative_to{};
  XmlLocation location{};  ///< of relative_to, or of the pose; null if neither exists
};
FramedPose read_pose(XmlFields& fields, Version version, XmlFile& file);

struct LinkPart {
  std::string name{};
  FramedPose pose{};
  double mass = 1;
  Vec3 com{};
  Sym3 inertia = diagonal(1);
  std::vector<Shape> shapes{};
  std::vector<std::pair<std::size_t, FramedPose>> placed_shapes{};  ///< shapes whose poses name a frame
  std::vector<Shape> collision{};
  std::vector<std::pair<std::size_t, FramedPose>> placed_collision{};  ///< of them, whose poses name a frame
  double friction = -1;                                                ///< negative: none is given
  XmlElement element{}, inertial{};
};

struct FramePart {
  std::string name{}, attached_to{};
  FramedPose pose{};
  XmlElement element{};
  XmlLocation attached_spot{};
};

/// The properties of one DoF of a joint.
struct AxisPart {
  Vec3 xyz{0, 0, 1};
  std::string expressed_in{};
  XmlLocation location{};  ///< of xyz
  double damping = 0, friction = 0, stiffness = 0, rest = 0;
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  XmlElement limit{}, mimic{};
};

struct JointPart {
  std::string name{}, parent{}, child{};
  Kind kind = Kind::weld;
  bool known = false;  ///< whether its type is known
  FramedPose pose{};
  std::array<AxisPart, 2> axes{};
  int dofs = 0;      ///< each with an axis
  double pitch = 1;  ///< m per turn, right-handed
  XmlElement element{};
  XmlLocation parent_spot{}, child_spot{};
};

struct ModelPart;
/// A model in a model or in a world, from the same file or from another.
struct NestedPart {
  std::shared_ptr<const ModelPart> model{};
  std::string name{}, placement_frame{};
  FramedPose pose{};
  bool is_static = false;
  bool merged = false;  ///< its parts belong to the model that includes it
  XmlElement element{};
  XmlLocation placement_spot{};
};

/// A model or a world.
struct ModelPart {
  Version version{};
  bool is_world = false;
  std::string name{}, canonical_link{}, placement_frame{};
  bool is_static = false;
  FramedPose pose{};
  std::vector<LinkPart> links{};
  std::vector<FramePart> frames{};
  std::vector<JointPart> joints{};
  std::vector<NestedPart> nested{};
  XmlElement element{};
  XmlLocation canonical_spot{}, placement_spot{};
  XmlFile* file = nullptr;
  std::size_t all_links = 0, all_models = 1;  ///< including those of nested models
  int levels = 1;                             ///< nesting depth of models
};

/// State shared while one model is read.
struct Reading {
  Import& import;
  std::unordered_map<const XmlDocument*, std::shared_ptr<const ModelPart>> read{};  ///< files by their only model
  std::vector<XmlFile*> open{};                                                     ///< files being read that include each other
  std::optional<Vec3> gravity{};
};

/// The name of a link, joint, frame or model; empty, with a report, if it is missing or invalid.
std::string read_name(XmlFields& fields, const char* what, Version version, XmlFile& file);

LinkPart read_link(XmlElement link, Version version, Import& import, XmlFile& file);
JointPart read_joint(XmlElement joint, Version version, XmlFile& file);
/// Reads <model> or <world> with everything in it.
std::shared_ptr<ModelPart> read_model(XmlElement model, Version version, Reading& reading, XmlFile& file, int depth);
/// Reads <include>; nothing, with a report, if there is no such model.
std::optional<NestedPart> read_include(XmlElement include, const ModelPart& into, Reading& reading, XmlFile& file, int depth);
/// The only model of a file whose root element is <sdf>, or its world if there is one.
std::shared_ptr<const ModelPart> read_root(XmlElement sdf, Reading& reading, XmlFile& file, bool included, int depth);

/// Resolves all names and adds the bodies to the import's model.
void build(const ModelPart& outermost, Import& import);

}  // namespace momentree::io::sdf

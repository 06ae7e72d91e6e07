#pragma once
// The parts of an MJCF file, one reader each. Internal to the importer.
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <momentree/contact/uniform_mass.hpp>
#include <momentree/models/import/importer.hpp>
#include <momentree/models/xml/fields.hpp>

namespace momentree::io::mjcf {

/// The settings in <compiler>.
struct Compiler {
  bool degrees = true, autolimits = true, balanceinertia = false;
  enum class FromGeoms { automatic, always, never } from_geoms = FromGeoms::automatic;
  double boundmass = 0, boundinertia = 0, settotalmass = -1;
  int first_group = 0, last_group = 5;  ///< groups of geoms that have mass
  std::string eulerseq = "xyz";
  std::string meshdir{};             ///< of mesh files, relative to the model's folder
  bool strippath = false;            ///< only the names of mesh files count, not their folders
  double angle(double given) const;  ///< rad
};

/// A mesh of <asset>.
struct MeshAsset {
  Shape shape{};  ///< of kind mesh, with its scale, at the origin of a geom; none if it is not drawn
};

/// A geom with a name: its body's number, −1: the world, and its coefficient of sliding.
struct NamedGeom {
  int body = -1;
  double friction = 1;
};

/// State shared while one model is read.
struct Reading {
  Import& import;
  Compiler compiler{};
  /// Classes of defaults by name, each with its parent class.
  struct Class {
    XmlElement element{};
    std::vector<XmlElement> parts;  ///< <geom>, <joint> …
    std::string parent;
  };
  std::string outermost = "main";
  std::unordered_map<std::string, Class> classes{};
  std::unordered_map<std::string, std::string> colours{};  ///< of materials
  std::unordered_map<std::string, MeshAsset> meshes{};
  std::unordered_map<std::string, Shape> fields{};  ///< height fields; of kind none: not read, which was reported
  std::unordered_map<std::string, XmlElement> body_names{}, joint_names{};
  /// Named sites, which equalities and tendons connect.
  struct Site {
    XmlElement element{};
    std::string childclass, body;  ///< the world: no body
    SpringEnd end{};
  };
  std::unordered_map<std::string, Site> sites{};
  std::unordered_set<std::string> geoms_of_pairs{};
  std::unordered_map<std::string, NamedGeom> geoms{};  ///< of pairs
  int unnamed = 0;

  XmlFile& file_of(XmlElement element) { return import.file_of(element); }
};

/// The children of an element, with <include> replaced by the elements of the included file.
std::vector<XmlElement> children_of(XmlElement element, Reading& reading);

/// Attributes of an element; an absent one is taken from its default class, or from the parents of that class.
class Attributes {
 public:
  /// `childclass`: of the body; used if the element names no class.
  Attributes(XmlElement element, const std::string& childclass, Reading& reading);
  bool has(std::string_view name) const { return static_cast<bool>(at(name).element); }
  /// The place of an attribute, in the element or in a class; its element is null if the attribute is absent.
  XmlLocation at(std::string_view name) const;
  std::optional<std::string> string(std::string_view name) const;
  std::optional<double> number(std::string_view name);
  std::optional<double> not_negative(std::string_view name);
  std::optional<std::vector<double>> numbers(std::string_view name, std::size_t count, std::size_t most = 0);
  std::optional<Vec3> vec3(std::string_view name);
  /// Reads pos (m) and one of quat, axisangle, xyaxes, zaxis and euler.
  Pose pose();
  void error(std::string_view name, std::string what, std::string hint = {});

 private:
  Quat rotation();
  XmlElement element_;
  std::vector<XmlElement> from_;  // the element itself, then its classes, the nearest first
  Reading& reading_;
};

/// Reports attributes of the element that are not in `known`.
void check_attributes(XmlElement element, std::initializer_list<std::string_view> known, Reading& reading);

/// Of a mesh, which is read only if it has to be.
struct MeshMass {
  std::optional<double> mass{};  ///< kg
  double density = 1000;         ///< without a mass: kg/m³
};
/// The mass of one geom (0 if it has none), and its shape for pictures.
struct Geom {
  MassProperties mass{};
  Shape shape{};
  std::optional<MeshMass> mesh_mass{};
  CollisionMask mask{};  ///< contype and conaffinity
  double friction = 1;   ///< coefficient of sliding
  bool hidden = false;   ///< in a group from 3 on, which is for collisions
};
Geom read_geom(XmlElement element, const std::string& childclass, Reading& reading);

/// Finds the geoms that the <pair> elements of <contact> name: they touch also if their masks are 0. Before bodies are read.
void find_pairs(XmlElement contact, Reading& reading);
/// Reads <contact>, once all bodies are read.
void read_contacts(XmlElement contact, Reading& reading);

/// Reads a <mesh> of <asset>, for pictures.
void read_mesh_asset(XmlElement element, Reading& reading);
/// The shape of a geom with that mesh at `at`; none if there is no such mesh, or none that is drawn.
Shape mesh_shape(const std::string& name, const Pose& at, const Reading& reading);

/// Reads an <hfield> of <asset>.
void read_field_asset(XmlElement element, Reading& reading);

/// Reads <worldbody> with everything in it, and adds its bodies to the model.
void read_world(XmlElement worldbody, Reading& reading);

/// Notes a <site> of a body, by its name and index; "" and −1: of the world.
void read_site(XmlElement element, const std::string& childclass, const std::string& name, int body, Reading& reading);
/// Reads <tendon>, once all bodies are read.
void read_tendons(XmlElement tendon, Reading& reading);
/// Reads all <equality> sections, once the bodies are known.
void read_equalities(const std::vector<XmlElement>& sections, Reading& reading);

void read_compiler(XmlElement compiler, Reading& reading);
void read_defaults(XmlElement defaults, const std::string& parent, Reading& reading, int depth = 0);

}  // namespace momentree::io::mjcf

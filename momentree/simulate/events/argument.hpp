#pragma once
// The arguments of actions and quantities. Each is stated once, like the members of a described type (base/describe.hpp): its key
// in scenario files, its value, and its meaning:
//
//   void arguments(const ArgumentVisitor& visit) override {
//     visit({"body", argument::Body{body}});
//     visit({"force", force, Field{"Impulse at `point`", dimension::force * dimension::time}});
//   }
//
// The type of the value is the kind of argument. scenario/events/argument_kinds.cpp states what each kind is in files, in their
// schema and in the Python package.
#include <functional>
#include <string>
#include <string_view>
#include <typeinfo>
#include <vector>

#include <momentree/base/describe.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/math/vec.hpp>

namespace momentree {

/// A joint that an action makes, as the user describes it.
struct JointDescription {
  JointSpec spec;
  bool axis_given = false, axis2_given = false;
};

/// Kinds of arguments whose values have no type of their own.
namespace argument {
template <class Thing>
struct Name {
  std::string& name;
};
using Joint = Name<struct OfJoint>;
using MadeJoint = Name<struct OfMadeJoint>;  ///< of the joint that an action makes, if the user gives one
using Body = Name<struct OfBody>;
using OtherBody = Name<struct OfOtherBody>;  ///< may be "ground", the default
using Mechanism = Name<struct OfMechanism>;
using Component = Name<struct OfComponent>;  ///< of a reaction: "fx", "fy", "fz", "mx", "my" or "mz"
/// Bodies or mechanisms that can touch, or "ground".
struct TwoSolids {
  std::string &one, &other;
};
/// A point of a body, in the body's frame (m).
struct Point {
  std::string& body;
  Vec3& point;
};
struct TwoPoints {
  Point one, other;
};
/// Indices of DoFs of a joint, in the order of v; empty: all of them.
struct Dofs {
  std::vector<int>& numbers;
};
/// Kind, axis, axis2, pitch and parameters of a joint. `keeps_axes`: axes that are not given stay those of the present joint.
struct Description {
  JointDescription& joint;
  bool keeps_axes;
};
/// Parameters for the joint `of`; absent ones are left empty.
struct Parameters {
  JointParameters& values;
  const std::string& of;
};

// The values of each kind, for archives. They are references, which a reader sets.
template <class Archive, class Thing>
void fields(Archive& archive, const Name<Thing>& a) {
  archive(a.name);
}
template <class Archive>
void fields(Archive& archive, const TwoSolids& a) {
  archive(a.one, a.other);
}
template <class Archive>
void fields(Archive& archive, const Point& a) {
  archive(a.body, a.point);
}
template <class Archive>
void fields(Archive& archive, const TwoPoints& a) {
  archive(a.one, a.other);
}
template <class Archive>
void fields(Archive& archive, const Dofs& a) {
  archive(a.numbers);
}
template <class Archive>
void fields(Archive& archive, const Description& a) {
  archive(a.joint);
}
template <class Archive>
void fields(Archive& archive, const Parameters& a) {
  archive(a.values);
}
}  // namespace argument

/// An argument: its key, a reference to its value, and its meaning.
struct Argument {
  template <class T>
  Argument(const char* the_key, T&& the_value, const Field& the_field = {})
      : key(the_key), field(the_field), type(&typeid(T)), value(&the_value) {}
  /// The value, if the argument is of that kind; else null.
  template <class T>
  T* as() const {
    return *type == typeid(T) ? static_cast<T*>(value) : nullptr;
  }
  const char* key;
  Field field;
  const std::type_info* type;
  void* value;
};

using ArgumentVisitor = std::function<void(const Argument&)>;

/// What has arguments: an action or a quantity.
class WithArguments {
 public:
  virtual ~WithArguments() = default;
  /// Its key in scenario files: "break", "reaction_force".
  virtual std::string_view key() const = 0;
  /// What it does or is, for lists and editors: "Removes a joint: its child's subtree becomes a separate mechanism".
  virtual const char* summary() const = 0;
  /// How to write it in a scenario, if that is not obvious: "for example weld = { body = …, to = … }".
  virtual const char* hint() const { return ""; }
  /// The argument that a plain string in place of a table sets; null if a table is required.
  virtual const char* plain_argument() const { return nullptr; }
  virtual void arguments(const ArgumentVisitor& visit) = 0;
  /// Names of joints and bodies that it refers to.
  virtual std::vector<std::string> joints() const { return {}; }
  virtual std::vector<std::string> bodies() const { return {}; }
  /// True if the name of a spring may take the place of a joint's.
  virtual bool takes_springs() const { return false; }
};

}  // namespace momentree

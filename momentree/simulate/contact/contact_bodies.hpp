#pragma once
// The bodies that a name in a condition on contacts stands for.
#include <optional>
#include <string_view>

#include <momentree/base/error.hpp>
#include <momentree/model/model.hpp>

namespace momentree {

class Quantity;
class World;

/// A body; or the ground, which is the floor, too; or the bodies of a mechanism, all those whose names begin with its name and a
/// slash. They belong to it whether or not they broke off.
class ContactBodies {
 public:
  /// The name must outlive this object.
  ContactBodies(const Model& model, std::string_view name);
  ContactBodies(const Model& model, BodyId body) : model_(&model), body_(body) {}

  bool holds(BodyId body) const;
  /// `body`: its name, or "ground".
  bool holds(std::string_view body) const;
  bool empty() const;
  /// False if all of them left the world.
  bool exist(const World& world) const;

 private:
  const Model* model_;
  std::optional<std::string_view> mechanism_{};  // otherwise body_
  BodyId body_ = ground;
};

/// Why a condition on contacts can never be met: a name that nothing has, bodies without a collision, or that pass through each
/// other.
std::optional<Error> cannot_touch(const Model& model, const Quantity& what);

}  // namespace momentree

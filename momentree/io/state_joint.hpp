#pragma once
// One joint of a state document, compared with the model. Internal to the reader: other code uses state_document.hpp.
#include <string>
#include <vector>

#include <momentree/io/json_document.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree::io {

/// A joint as described in a document.
struct DescribedJoint {
  std::string name;
  const JsonNode* node = nullptr;
  Joint joint;
  JointParameters parameters;
  BodyId child, parent;
  bool reversed = false;
  unsigned resting = 0;
  std::vector<ActiveLimit> active_limits;  ///< joint numbers are not yet set
};

class JointReader {
 public:
  JointReader(const JsonDocument& document, const Model& model) : doc_(document), model_(model) {}

  /// The body of that name; throws Error with the nearest one.
  BodyId body_named(const std::string& name, const JsonNode& node) const;
  /// The joint as described; missing values are taken from the model's joint `like` (null: the description must be complete).
  DescribedJoint describe(const std::string& name, const JsonNode& node, const BodySpec* like, BodyId child) const;
  /// The coordinates of a joint of that kind and shape; empty if they are absent or null.
  JointStart start(const DescribedJoint& joint, JointId number) const;
  /// The first key in which a joint differs from that of the model, or null. `exact`: compared to the last bit, except for
  /// signs of quaternions; else up to rounding.
  const char* difference(const DescribedJoint& joint, const BodySpec& model, bool exact) const;

 private:
  Vec3 vector(const JsonNode& node, const char* what) const;
  Pose pose(const JsonNode& node, const char* what) const;
  Values numbers(const DescribedJoint& joint, const char* key, int count) const;
  void read_locks(const JsonNode& node, DescribedJoint& joint) const;

  const JsonDocument& doc_;
  const Model& model_;
};

}  // namespace momentree::io

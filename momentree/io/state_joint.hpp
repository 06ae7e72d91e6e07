#pragma once
// One joint of a state document, held against the model. Internal to the reader: state_document.hpp is what others use.
#include <string>
#include <vector>

#include <momentree/io/json_document.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree::io {

/// A joint as a document describes it.
struct DescribedJoint {
  std::string name;
  const JsonNode* node = nullptr;
  Joint joint;
  JointParameters parameters;
  BodyId child, parent;
  bool reversed = false;
  unsigned resting = 0;
  std::vector<ActiveLimit> active_limits;  ///< numbers of joints not yet known
};

class JointReader {
 public:
  JointReader(const JsonDocument& document, const Model& model) : doc_(document), model_(model) {}

  /// The body of that name; throws Error with the nearest one.
  BodyId body_named(const std::string& name, const JsonNode& node) const;
  /// What stands there; what does not is as in the model's joint `like` (null: there must be enough without it).
  DescribedJoint describe(const std::string& name, const JsonNode& node, const BodySpec* like, BodyId child) const;
  /// Coordinates of a joint of that kind and shape; empty where they are absent or null.
  JointStart start(const DescribedJoint& joint, JointId number) const;
  /// The first thing in which a joint differs from that of the model: its key, or null. `exact`: to the last bit, signs of
  /// quaternions apart; else to what rounding would hide.
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

#pragma once
// One joint of a state document, compared with the model. Internal to the reader: other code uses state_document.hpp.
#include <optional>
#include <string>
#include <vector>

#include <momentree/scenario/keys/fields.hpp>
#include <momentree/simulate/stepping/stepping_state.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// A joint as described in a document.
struct DescribedJoint {
  const Value::Entry* entry = nullptr;  ///< its name and its table
  Joint joint;
  JointParameters parameters;
  BodyId child, parent;
  bool reversed = false, loop = false;
  bool made = false;  ///< when its body broke off: it is not the model's joint of that name
  unsigned resting = 0;
  std::vector<ActiveLimit> active_limits;  ///< joint numbers are not yet set
  std::vector<DeeperStop> deeper;          ///< likewise
  std::vector<SteppedContact> stepped;     ///< likewise: stops that are stepped through
  Values q, v, p;                          ///< empty if they are absent or null
  const std::string& name() const { return entry->key; }
};

class JointReader {
 public:
  JointReader(const Model& model, Diagnostics& out) : model_(model), out_(out) {}

  /// The body of that name; nothing, with a report that names the nearest one, if there is none.
  std::optional<BodyId> body_named(const std::string& name, Place place);
  /// "did you mean …" for the first few unknown names.
  std::string suggest(const std::string& name, std::string BodySpec::*kind);
  /// The joint as described, or nothing, with reports. Missing values are taken from the model's joint `like` (null: the
  /// description must be complete).
  std::optional<DescribedJoint> describe(const Value::Entry& entry, const BodySpec* like, BodyId child);
  /// The first key in which a joint differs from that of the model, or null. `exact`: compared to the last bit, except for
  /// signs of quaternions; else up to rounding.
  static const char* difference(const DescribedJoint& joint, const BodySpec& model, bool exact);

 private:
  void read_shape(Fields& fields, DescribedJoint& joint, JointSpec& spec, const BodySpec* like);
  void read_pose(Fields& fields, const char* key, Pose& pose);
  void read_locks(Fields& fields, DescribedJoint& joint);
  void read_start(Fields& fields, DescribedJoint& joint);
  Values read_values(Fields& fields, const char* key, int count);

  const Model& model_;
  Diagnostics& out_;
  int suggestions_left_ = 20;  // each compares all names
};

}  // namespace momentree::io

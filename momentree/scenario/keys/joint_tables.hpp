#pragma once
// [mechanism.joint.NAME]: parameters and initial values that a mechanism gives to joints of its model or chain. Internal to the
// reader.
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

/// A table of parameters under a name that may contain a wildcard; it then applies to all matching joints that can have them.
class JointTable {
 public:
  using Entries = std::vector<std::pair<const char*, const Value*>>;  ///< by key; the keys are literals
  /// The entries of the table that apply to joints of one kind.
  struct Part {
    Entries entries;  ///< those that this kind can have
    JointParameters parameters;
    Values q, v;
  };

  /// `fields`: the fields of the table, whose name is at `place`; the keys of parameters are read from it, and those of initial
  /// values if `starts` is true. `pattern`: the name.
  JointTable(Fields& fields, Place place, bool starts, std::string pattern, std::string where);

  const std::string& pattern() const { return pattern_; }
  bool wild() const { return pattern_.find('*') != std::string::npos; }
  Place place() const { return place_; }
  /// True if the table has that key.
  bool has(std::string_view key) const { return value_of(key) != nullptr; }
  Place place_of(std::string_view key) const;

  /// Reads the table for the kinds of its joints. Reports errors, values that no joint can have, and values that some joints
  /// cannot have.
  void read(const std::vector<Kind>& kinds, Diagnostics& out);
  /// Null if joints of that kind take nothing from the table.
  const Part* part(Kind kind) const;
  bool empty() const { return entries_.empty(); }
  /// Reports values that are invalid for every joint of their kind, whatever its other parameters.
  void check(Diagnostics& out) const;

 private:
  const Value* value_of(std::string_view key) const;
  Part read_part(const KindInfo& kind, const Entries& entries, Diagnostics& out) const;
  bool can_have(const KindInfo& kind, const char* key, const Value* value) const;
  void read_wild(const std::vector<Kind>& kinds, Diagnostics& out);

  std::string pattern_, where_;
  Place place_;
  bool starts_;
  Entries entries_;
  std::map<Kind, Part> parts_;
};

/// All joint tables of a mechanism. Exact names take precedence over wildcards, and later wildcards over earlier ones.
class JointTables {
 public:
  /// `value`: the mechanism's key `joint`; null if it is absent. `of`: "model" or "chain", for messages.
  JointTables(const Value* value, const char* of, Reading& reading);

  bool any() const { return !tables_.empty(); }
  /// `joints`: all joints of the mechanism by bare name. Reads the tables for their kinds, and reports names that match
  /// nothing. `bodies`: names of bodies and of their joints, if those differ.
  void read(const std::vector<std::pair<std::string, Kind>>& joints,
            const std::unordered_map<std::string, std::string>& bodies = {});
  /// Applies every matching table to the joint.
  void apply(const std::string& joint, BodySpec& spec) const;
  /// The same for a joint that closes a loop. What such joints don't have is an error in a table under its name, and left out
  /// with a note if the name has a wildcard.
  void apply(const std::string& joint, LoopSpec& spec);
  /// Reports if the result is not a valid joint, for the first such joint. Call it once the joint has its initial values.
  void check(const std::string& joint, const BodySpec& spec);
  /// The place that gives the initial values of a joint under its own name, if there is one.
  std::optional<Place> start_of(const std::string& joint) const;
  /// True if a table, under whatever name, gives the initial position of a joint of that kind.
  bool gives_position(const std::string& joint, Kind kind) const;

 private:
  template <class Visit>
  void each_for(const std::string& joint, Visit visit) const;  // visits wildcards before the exact name
  // The last places that give q, v and parameters; empty if there are none.
  std::unordered_map<std::string_view, Place> places_for(const std::string& joint, Kind kind) const;

  Reading& reading_;
  const char* of_;
  std::vector<JointTable> tables_;                      // in the order of the file
  std::vector<std::size_t> wild_;                       // indices of those with wildcards
  std::unordered_map<std::string, std::size_t> exact_;  // by name
  bool sound_ = true;
  std::set<const Value*> left_out_;  // values of tables with wildcards that loop joints don't have
};

/// Reports an error if the mechanism's `state` and a table under the joint's name both give its initial values.
void check_start(const JointTables& tables, const std::string& joint, const Value& state, Diagnostics& out);

}  // namespace momentree::io

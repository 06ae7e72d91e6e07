#pragma once
// [mechanism.joint.NAME]: parameters and start values that a mechanism gives to joints of its model or chain. Internal to the
// reader.
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

/// A table of parameters under a name that may have a wildcard, which stands for all joints that it matches and that can have
/// them.
class JointTable {
 public:
  using Entries = std::vector<std::pair<const char*, const Value*>>;  ///< by keys, which are literals
  /// What the table says to joints of one kind.
  struct Part {
    Entries entries;  ///< those that they can have
    JointParameters parameters;
    Values q, v;
  };

  /// `fields`: of the table, whose name stands at `place`; they are asked for the keys of parameters, and of start values where
  /// `starts`. `pattern`: the name.
  JointTable(Fields& fields, Place place, bool starts, std::string pattern, std::string where);

  const std::string& pattern() const { return pattern_; }
  bool wild() const { return pattern_.find('*') != std::string::npos; }
  Place place() const { return place_; }
  /// True where it says that.
  bool has(std::string_view key) const { return value_of(key) != nullptr; }
  Place place_of(std::string_view key) const;

  /// Reads it for the kinds of joints that it is for. Reports what is wrong, what no joint can have, and what some can't.
  void read(const std::vector<Kind>& kinds, Diagnostics& out);
  /// Null where joints of that kind take nothing from it.
  const Part* part(Kind kind) const;
  bool empty() const { return entries_.empty(); }
  /// Reports what no joint of its kind could have, whatever else it has.
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

/// All of a mechanism. Exact names win over wildcards, and of several wildcards the later one.
class JointTables {
 public:
  /// `value`: of the mechanism's key `joint`; null if the mechanism has no such key. `of`: "model" or "chain", for messages.
  JointTables(const Value* value, const char* of, Reading& reading);

  bool any() const { return !tables_.empty(); }
  /// The joints that there are, by their bare names: reads the tables for their kinds, and reports names that mean nothing.
  /// `bodies`: names of bodies and of their joints, where those differ.
  void read(const std::vector<std::pair<std::string, Kind>>& joints,
            const std::unordered_map<std::string, std::string>& bodies = {});
  /// Applies every matching table to the joint.
  void apply(const std::string& joint, BodySpec& spec) const;
  /// Reports where that made no sound joint, of the first one; to be called once it has its start.
  void check(const std::string& joint, const BodySpec& spec);
  /// Where the start of a joint is given under its own name; nothing where it is not.
  std::optional<Place> start_of(const std::string& joint) const;

 private:
  template <class Visit>
  void each_for(const std::string& joint, Visit visit) const;  // wildcards before the exact name
  // Where q, v and parameters are given last; empty where nothing is.
  std::unordered_map<std::string_view, Place> places_for(const std::string& joint, Kind kind) const;

  Reading& reading_;
  const char* of_;
  std::vector<JointTable> tables_;                      // in the order of the file
  std::vector<std::size_t> wild_;                       // of them
  std::unordered_map<std::string, std::size_t> exact_;  // by name
  bool sound_ = true;
};

/// Reports where the mechanism's `state` gives the start of a joint that a table under its name gives already.
void check_start(const JointTables& tables, const std::string& joint, const Value& state, Diagnostics& out);

}  // namespace momentree::io

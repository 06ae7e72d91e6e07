#pragma once
// Reads an action from a scenario. Internal to the reader.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

/// A visitor that leaves all fields as they are.
struct IgnoredFields : ActionFields {
  void joint(const char*, std::string&) override {}
  void made_joint(const char*, std::string&) override {}
  void body(const char*, std::string&, bool) override {}
  void dofs(const char*, const std::string&, std::vector<int>&) override {}
  void vector(const char*, Vec3&, const Dimension&, const char*) override {}
  void placement(const char*, std::optional<Pose>&, const char*) override {}
  void description(JointDescription&, bool) override {}
  void parameters(const std::string&, JointParameters&) override {}
};

/// The keys of the actions that scenario files can use.
const std::vector<std::string>& scenario_actions();
/// True for an action that sets parameters of a joint: their units depend on its kind, which another event may determine.
bool sets_parameters(ActionBase& action);

class ActionReader final : public ActionFields {
 public:
  /// `value`: a name if the action has a plain_field(), else a table. `match`: the name that its wildcard stands for in this
  /// event; empty: no wildcard. `time` (s): of its event.
  ActionReader(const Value& value, ActionBase& action, const std::string& match, double time, Reading& reading);
  /// False, with reports, if something is wrong.
  bool read();

  /// The kinds that a joint can have when the action takes effect, the likeliest first; empty: unknown.
  std::function<std::vector<const KindInfo*>(const std::string& joint)> kinds_of;

  void joint(const char* key, std::string& name) override;
  void made_joint(const char* key, std::string& name) override;
  void body(const char* key, std::string& name, bool ground_too) override;
  void dofs(const char* key, const std::string& of, std::vector<int>& numbers) override;
  void vector(const char* key, Vec3& value, const Dimension& dimension, const char* about) override;
  void placement(const char* key, std::optional<Pose>& value, const char* about) override;
  void description(JointDescription& joint, bool keeps_axes) override;
  void parameters(const std::string& of, JointParameters& parameters) override;

 private:
  static constexpr const char* hint_ = "degrees of freedom are numbered in the order of v: [0, 2]";
  const Value* given(const char* key, bool required);
  bool fits(const KindInfo& kind) const;
  std::optional<std::string> name(const char* key, bool required, Place& place);

  const Value& value_;
  ActionBase& action_;
  std::string key_;
  const char* plain_field_;
  bool sets_parameters_;
  const std::string& match_;
  double time_;
  Reading& reading_;
  Diagnostics& out_;
  std::optional<Fields> fields_;
  bool asked_ = false, acts_ = true;  // whether a wrench is required; whether the action would have any effect
};

/// The part of a name before the first '/'.
std::string mechanism_of(const std::string& name);

}  // namespace momentree::io

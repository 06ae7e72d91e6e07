#pragma once
// The keys of a joint's parameters and of a signal, each described once. The readers and writers of scenarios and state
// documents, the converter and the schema iterate over these lists: a new parameter gets an entry here, and all of them know it.
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include <momentree/base/units.hpp>
#include <momentree/joint/joint.hpp>

namespace momentree::io {

/// The quantity of a number. All but the last three depend on whether the coordinate or DoF is an angle or a length.
enum class Quantity { q, v, damping, stiffness, armature, effort, none, force, torque };
/// The dimension for one coordinate or DoF, given by its letter in KindInfo.
Dimension dimension_of(Quantity quantity, char letter);

/// The range of a number.
enum class Range { any, not_negative, positive, fraction };  ///< fraction: from 0 to 1

/// The parameters of a joint, with its drive unpacked.
struct JointSettings {
  JointParameters parameters;  ///< its `drive` is not used
  JointDrive drive;            ///< its `motion` is not used
  std::vector<Signal> motion;  ///< at most one

  JointSettings() = default;
  explicit JointSettings(const JointParameters& packed);
  JointParameters packed() const;
};

struct JointKey;

/// A table of keys.
struct JointGroup {
  std::span<const JointKey> keys;
  /// At least one of these two keys is needed; null: any or none.
  const char* either[2] = {nullptr, nullptr};
  const char *missing = "", *hint = "";  ///< the message if both are missing
  /// Only for kinds whose velocities are the rates of their coordinates: other kinds have no coordinates that could `rates`;
  /// null: for all kinds.
  const char* rates = nullptr;
};

/// One key: where its value is stored, and its meaning.
struct JointKey {
  using PerDof = Values& (*)(JointSettings&);                ///< one number for all DoFs, or a list with one per DoF
  using Number = double& (*)(JointSettings&);                ///< one number
  using Signals = std::vector<Signal>& (*)(JointSettings&);  ///< one signal per DoF, without a list if there is only one

  const char* key;
  const char* about;  ///< its meaning, in one line
  std::variant<PerDof, Number, Signals, JointGroup> value;
  Quantity quantity = Quantity::none;
  Range range = Range::any;
  const char* hint = "";           ///< for a number out of range
  bool by_model = false;           ///< check_joint() reports numbers out of range, not the reader
  const char* required = nullptr;  ///< the hint if the key is missing from its table; null: it may be missing
  double infinite = 0;     ///< ±infinity if numbers may be infinite: the value of an absent key, and of null in state documents
  bool each = false;       ///< one number for all DoFs is not accepted
  bool one_dof = false;    ///< only for kinds with one coordinate and one DoF
  bool documents = false;  ///< in state documents only

  const JointGroup* group() const { return std::get_if<JointGroup>(&value); }
};

/// The keys of a joint's parameters, in the order in which state documents have them.
std::span<const JointKey> joint_keys();

/// A signal as the numbers from which it is made.
struct SignalParts {
  enum class Form { number, table, sine, ramp } form = Form::number;
  std::vector<Signal::Knot> table;
  Signal::Ends ends = Signal::Ends::rest;
  double amplitude = 0, frequency = 0, phase = 0, offset = 0, rate = 0;
  bool from_here = false;

  SignalParts() = default;
  explicit SignalParts(const Signal& signal);
  /// Throws Error as the functions of Signal do.
  Signal signal() const;
};

/// A number of a sine or of a ramp.
struct SignalKey {
  enum class Unit { value, value_per_time, frequency, angle };  ///< value: that of the signal
  const char* key;
  const char* about;
  Unit unit;
  double SignalParts::*number;
  const char* required = nullptr;  ///< as in JointKey
  Range range = Range::any;

  Dimension dimension(const Dimension& value) const;
};

/// A signal is a number, or a table with one of these: { table = [[time, value], …], ends = "rest" | "free" },
/// { sine = { sine_keys } }, { ramp_keys }; in state documents a ramp can also have `from_here`, true or false.
std::span<const SignalKey> sine_keys();
std::span<const SignalKey> ramp_keys();

}  // namespace momentree::io

#pragma once
// The keys of a joint's parameters and of a signal, each described once. The readers and writers of scenarios and state
// documents, the converter and the schema iterate over these lists: a new parameter needs one entry here.
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include <momentree/base/describe.hpp>
#include <momentree/joint/joint.hpp>

namespace momentree::io {

/// The quantity of a number. All but the last three depend on whether the coordinate or DoF is an angle or a length.
enum class Quantity { q, v, damping, stiffness, armature, effort, none, force, torque };
/// The dimension for one coordinate or DoF, given by its letter in KindInfo.
Dimension dimension_of(Quantity quantity, char letter);

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
  /// Not null if the table needs a kind whose velocities are the rates of its coordinates: what the coordinates of other kinds
  /// cannot do, for messages ("be limited").
  const char* rates = nullptr;

  bool needs(std::string_view key) const { return either[0] != nullptr && (key == either[0] || key == either[1]); }
};

/// What is special about a key.
struct JointKeyOptions {
  const char* hint = "";           ///< for a number out of range
  bool by_model = false;           ///< check_joint() reports numbers out of range, not the reader
  const char* required = nullptr;  ///< the hint if the key is missing from its table; null: it may be missing
  double infinite = 0;     ///< ±infinity if numbers may be infinite: the value of an absent key, and of null in state documents
  bool each = false;       ///< one number for all DoFs is not accepted
  bool one_dof = false;    ///< only for kinds with one coordinate and one DoF
  bool documents = false;  ///< in state documents only
};

/// One key: where its value is stored, and its meaning.
struct JointKey : JointKeyOptions {
  using PerDof = Values& (*)(JointSettings&);                ///< one number for all DoFs, or a list with one per DoF
  using Number = double& (*)(JointSettings&);                ///< one number
  using Signals = std::vector<Signal>& (*)(JointSettings&);  ///< one signal per DoF, without a list if there is only one
  using Place = std::variant<PerDof, Number, Signals, JointGroup>;

  constexpr JointKey(const char* key_, Place value_, Quantity quantity_, Range range_, const char* about_,
                     const JointKeyOptions& options = {})
      : JointKeyOptions(options), key(key_), about(about_), value(value_), quantity(quantity_), range(range_) {}
  /// A table of further keys.
  constexpr JointKey(const char* key_, const JointGroup& group, const char* about_)
      : key(key_), about(about_), value(group), quantity(Quantity::none), range(Range::any) {}

  const char* key;
  const char* about;  ///< its meaning, in one line
  Place value;
  Quantity quantity;
  Range range;
};

/// The keys of a joint's parameters, in the order in which state documents have them.
std::span<const JointKey> joint_keys();

/// True if `same` holds for every two values of these keys.
template <class Same>
bool alike(std::span<const JointKey> keys, JointSettings& a, JointSettings& b, const Same& same) {
  for (const JointKey& key : keys) {
    const auto agree = [&](const auto& value) {
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, JointGroup>)
        return alike(value.keys, a, b, same);
      else
        return static_cast<bool>(same(value(a), value(b)));
    };
    if (!std::visit(agree, key.value)) return false;
  }
  return true;
}

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
  Unit unit;
  double SignalParts::*number;
  const char* about;
  const char* required = nullptr;  ///< as in JointKey
  Range range = Range::any;

  Dimension dimension(const Dimension& value) const;
};

/// A signal is a number, or a table with one of these: { table = [[time, value], …], ends = "rest" | "free" },
/// { sine = { sine_keys } }, { ramp_keys }; in state documents a ramp can also have `from_here`, true or false.
std::span<const SignalKey> sine_keys();
std::span<const SignalKey> ramp_keys();

}  // namespace momentree::io

#pragma once
// Springs and cables between two points of bodies: ropes, guys, tethers, suspension springs.
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <momentree/base/describe.hpp>
#include <momentree/math/vec.hpp>
#include <momentree/model/ids.hpp>

namespace momentree {

struct BodySpec;

/// Handle of a spring: its place in the order in which the springs of the model were added.
struct SpringId {
  int index = -1;
  friend bool operator==(SpringId, SpringId) = default;
};

/// A point of a body, or of the ground.
struct SpringEnd {
  BodyId body = ground;
  Vec3 point{};  ///< in the body's user frame, of the ground in the world (m)
  friend bool operator==(const SpringEnd&, const SpringEnd&) = default;
};

/// What determines the force of a spring: tension = stiffness·(length − rest) + damping·rate of the length. With `tension_only`
/// the tension is never negative, and zero while the length is below `rest`.
struct SpringLaw {
  double stiffness = 0;        ///< N/m
  double rest = 0;             ///< m
  double damping = 0;          ///< N s/m
  bool tension_only = false;   ///< a rope: it pulls and never pushes
  double strength = HUGE_VAL;  ///< the spring breaks when its tension, or its push, exceeds this force (N)
  friend bool operator==(const SpringLaw&, const SpringLaw&) = default;

  /// True if a spring of that length exerts no force whatever its rate.
  bool slack(double length) const { return tension_only && !(length > rest); }
  /// Tension (N; negative: it pushes) at a length (m) that changes at a rate (m/s).
  double tension(double length, double rate) const {
    if (slack(length)) return 0;
    const double all = stiffness * (length - rest) + damping * rate;
    return tension_only && !(all > 0) ? 0 : all;
  }
  /// The energy that it stores (J).
  double energy(double length) const { return slack(length) ? 0 : 0.5 * stiffness * (length - rest) * (length - rest); }
  /// Power that it dissipates (W), never negative.
  double dissipated(double length, double rate) const {
    if (slack(length)) return 0;
    const double elastic = stiffness * (length - rest), damper = damping * rate;
    return tension_only && !(elastic + damper > 0) ? -elastic * rate : damper * rate;
  }
};

/// The members of a SpringLaw, or of a Spring.
template <class Visitor, class S>
void describe_law(Visitor& visit, S& s) {
  using namespace dimension;
  visit("stiffness", s.stiffness, Field{"Stiffness", force / length, Range::not_negative});
  visit("rest", s.rest, Field{"Length without force", length, Range::not_negative}.by_default("the distance at the start"));
  visit("damping", s.damping, Field{"Force per rate of the length", force / speed, Range::not_negative});
  visit("tension_only", s.tension_only, Field{"A rope: it pulls and never pushes"});
  visit("strength", s.strength, Field{"It breaks when its force exceeds this", force, Range::positive}.or_infinite());
}
template <class Visitor, Like<SpringLaw> S>
void describe(Visitor& visit, S& law) {
  describe_law(visit, law);
}

/// A spring with a damper between two points, with a force along the line between them. It belongs to the bodies, whatever these
/// are attached to, until it breaks or one of the bodies leaves the world.
struct Spring {
  std::string name;  ///< unique among springs and joints
  SpringEnd from{}, to{};
  double stiffness = 0;          ///< N/m
  std::optional<double> rest{};  ///< length without force (m); absent: the distance in the start values of the model
  double damping = 0;            ///< N s/m
  bool tension_only = false;     ///< a rope: it pulls and never pushes
  double strength = HUGE_VAL;    ///< it breaks when its force exceeds this (N)
  bool inextensible = false;     ///< a cable of length `rest`: see Cable
  double restitution = 0;        ///< of a cable
  friend bool operator==(const Spring&, const Spring&) = default;
};

template <class Visitor, Like<Spring> S>
void describe(Visitor& visit, S& spring) {
  visit("name", spring.name, Field{"Name, for events and results"}.needed("name = \"rope\""));
  visit("from", spring.from,
        Field{"Its first end: a point of a body, or of the \"ground\"; a name alone: the origin"}.needed(
            "for example from = { body = \"crane/jib\", point = [2, 0, 0] }"));
  visit("to", spring.to, Field{"Its second end"}.needed("for example to = { body = \"ground\", point = [0, 0, 3] }"));
  describe_law(visit, spring);
}

/// An inextensible cable between two points: they are never farther apart than its length. It becomes taut by an impact, then
/// exerts the tension that this takes, and is slack from the instant at which it would have to push. In a model it is a Spring
/// that is `inextensible`.
struct Cable {
  std::string name;  ///< unique among springs, cables and joints
  SpringEnd from{}, to{};
  std::optional<double> length{};  ///< m; absent: the distance in the start values of the model
  double restitution = 0;  ///< 0 (the ends stay apart by the length) to 1 (they rebound with the speed at which it became taut)
  double strength = HUGE_VAL;  ///< it breaks when its tension exceeds this (N)
};
template <class Visitor, Like<Cable> C>
void describe(Visitor& visit, C& cable) {
  using namespace dimension;
  visit("name", cable.name, Field{"Name, for events and results"}.needed("name = \"tether\""));
  visit("from", cable.from,
        Field{"Its first end: a point of a body, or of the \"ground\"; a name alone: the origin"}.needed(
            "for example from = { body = \"tug/hull\", point = [1, 0, 0] }"));
  visit("to", cable.to, Field{"Its second end"}.needed("for example to = { body = \"ground\", point = [0, 0, 3] }"));
  visit("length", cable.length,
        Field{"Its ends are never farther apart", length, Range::positive}.by_default("the distance at the start"));
  visit("restitution", cable.restitution,
        Field{"How its ends rebound when it becomes taut: 0 (not at all) to 1", number, Range::not_negative});
  visit("strength", cable.strength, Field{"It breaks when its tension exceeds this", force, Range::positive}.or_infinite());
}
inline Spring spring_of(Cable cable) {
  Spring spring{std::move(cable.name), cable.from, cable.to};
  spring.rest = cable.length, spring.strength = cable.strength;
  spring.inextensible = true, spring.restitution = cable.restitution;
  return spring;
}
/// A spring of a model that is `inextensible`.
inline Cable cable_of(const Spring& s) { return {s.name, s.from, s.to, s.rest, s.restitution, s.strength}; }
/// The law of a spring of a model, whose rest length is known.
inline SpringLaw law_of(const Spring& s) { return {s.stiffness, s.rest.value_or(0), s.damping, s.tension_only, s.strength}; }
/// The spring with that law.
inline Spring with_law(Spring spring, const SpringLaw& law) {
  spring.stiffness = law.stiffness, spring.rest = law.rest, spring.damping = law.damping;
  spring.tension_only = law.tension_only, spring.strength = law.strength;
  return spring;
}

/// The faults of a single spring, except its name and its bodies; empty if there are none. `field` is the key of the scenario
/// file at fault.
struct SpringProblem {
  std::string field, what, hint;
};
std::vector<SpringProblem> check_spring(const Spring& spring);

/// The place of a point of a body (or of the ground) in the world, at the start values of these bodies, each after its parent.
/// Prescribed motions are at time 0.
Vec3 start_place(const std::vector<BodySpec>& bodies, const SpringEnd& end);

}  // namespace momentree

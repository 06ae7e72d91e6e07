#pragma once
// What a run that steps through contacts remembers between steps.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <momentree/base/describe.hpp>
#include <momentree/math/vec.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree {

/// A point of contact in the last step, or a joint at its hard stop.
struct SteppedContact {
  int pair = -1;           ///< number of the pair of solids, or of the cable; −1: a stop
  std::uint64_t id = 0;    ///< of its features in that pair; of a stop the degree of freedom
  int a = -1, b = -1;      ///< bodies; −1: the ground
  Vec3 point{}, normal{};  ///< in the world (m); the normal points from b to a
  Vec3 force{};            ///< on a: mean over the step (N), world axes
  Vec3 slip{};             ///< velocity of a, less that of b, along the surface at the end of the step (m/s)
  int cable = -1;          ///< the spring of the model that is taut; −1: bodies touch
  int joint = -1;          ///< of a stop, whose force (N or N m) is the first number of `force`, positive
  int side = 0;            ///< of a stop: 1: the upper one, −1: the lower one
  bool rests = false;      ///< the joint rests on it
  Vec3 moment{};           ///< on a, of torsional and rolling friction: mean over the step (N m), world axes
  friend bool operator==(const SteppedContact&, const SteppedContact&) = default;
};

/// Whether the contacts of a body are stepped through at present, although the method locates them.
struct SteppedBody {
  bool on = false;
  double since_impact = 0;  ///< when it last hit something, or stepping began (s)
  double patience = 0.1;    ///< time without impacts after which its contacts are located again (s)
  friend bool operator==(const SteppedBody&, const SteppedBody&) = default;
};
template <class Visitor, Like<SteppedBody> B>
void describe(Visitor& visit, B& body) {
  visit("on", body.on, Field{"Its contacts are stepped through"});
  visit("since_impact", body.since_impact, Field{"When it last hit something, or stepping began", dimension::time});
  visit("patience", body.patience, Field{"Time without impacts after which its contacts are located again", dimension::time});
}

/// Bodies that steps could not keep from overlapping.
struct KeptOverlap {
  Overlap deepest;
  double since = 0;  ///< when it was found first (s)
  friend bool operator==(const KeptOverlap&, const KeptOverlap&) = default;
};

struct SteppingState {
  bool on = false;   ///< of any bodies
  bool all = false;  ///< of all mechanisms
  std::vector<SteppedBody> bodies;
  // Changes of contacts in a short time, and in a very short one, and when these times began (s).
  int changes = 0, changes_at_once = 0;
  double window = 0, instant = 0;
  std::array<std::string, 2> last{};   ///< the bodies of the last event, if it was at a contact
  int short_steps = 0;                 ///< in a row in which a contact that is located crept
  int steps = 0;                       ///< with closed contacts since these were last judged by their length
  double steps_began = 0;              ///< when that was (s)
  std::vector<SteppedContact> points;  ///< of the last step
  bool released = false;               ///< forces or the state changed since the last step: its forces no longer act
  bool placed = true;                  ///< no run has begun since the state was set: bodies may overlap
  std::vector<KeptOverlap> overlaps;   ///< of the run, one of each two bodies
  /// The norm of the rates of all momenta without contacts, in documents: another model, or other forces, give another one.
  /// −1: unknown.
  double unloaded = -1;
  /// In documents, ContactsBetweenRuns::excess_of_closed(): a run that continues keeps closed contacts if it is no larger then.
  double excess = -1;
  /// In documents: the deepest overlap that the run could not avoid (m). A run that continues accepts it.
  double overlap = 0;
  /// In documents: the largest kinetic energy of the run (J), to which what contacts gain is compared.
  double largest_kinetic = 0;
  friend bool operator==(const SteppingState&, const SteppingState&) = default;
};

/// The members that documents have together; `points` are contacts there.
template <class Visitor, Like<SteppingState> S>
void describe_in_documents(Visitor& visit, S& s) {
  using namespace dimension;
  visit("everywhere", s.all, Field{"All mechanisms are stepped through"}.left_out_at(0));
  visit("bodies", s.bodies, Field{"By name: those that are not as at first"});
  visit("released", s.released, Field{"The forces of the last step no longer act"}.left_out_at(0));
  visit("unloaded", s.unloaded, Field{"Norm of the rates of all momenta without contacts"}.left_out_at(-1));
  visit("excess", s.excess, Field{"The largest force that closed contacts cannot exert, of the largest of all"}.left_out_at(-1));
  visit("overlap", s.overlap, Field{"The deepest overlap that could not be avoided", length}.left_out_at(0));
  visit("on", s.on, Field{"Some bodies are stepped through"});
  visit("changes", s.changes, Field{"Changes of contacts in a short time"});
  visit("changes_at_once", s.changes_at_once, Field{"And in a very short one"});
  visit("last", s.last, Field{"The bodies of the last event"});
  visit("window", s.window, Field{"When the short time began", time});
  visit("instant", s.instant, Field{"When the very short one began", time});
  visit("short_steps", s.short_steps, Field{"Steps in a row in which a contact that is located crept"});
  visit("steps", s.steps, Field{"Steps with closed contacts since these were last judged by their length"});
  visit("steps_began", s.steps_began, Field{"When that was", time});
  visit("largest_kinetic", s.largest_kinetic, Field{"The largest kinetic energy of the run", force * length});
}

}  // namespace momentree

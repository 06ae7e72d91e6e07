#pragma once
// The two regimes of contact, and every threshold that decides between them or says what counts as touching, resting or slipping.
//
// Contacts are *located*: each change happens at its instant, as an event, and in between closed contacts are equations of
// motion. An island with too many points or changes for that is *stepped* through, until its bodies have hit nothing for a while
// (contact_runs.cpp, contact_islands.cpp). Tolerances of geometry and of the solver are next to their code, in momentree/contact.
#include <cstddef>

namespace momentree::policy {

// When stepping begins.

/// Points of an island. Each stage solves a dense system of their size.
inline constexpr std::size_t most_points = 32;
/// The same before a run, which solves it once.
inline constexpr std::size_t most_pending = 64;
/// With more points than this, a change of contact or a short step counts more than once: each takes longer.
inline constexpr std::size_t crowded = 8;
/// More changes of contacts than this within `window_length` (s) are a flood.
inline constexpr int most_changes = 200;
inline constexpr double window_length = 1e-2;
/// More changes than this within `instant_length` (s) have no end.
inline constexpr int most_changes_at_once = 300;
inline constexpr double instant_length = 1e-6;
/// So many adaptive steps, fewer if points are crowded, may be shorter on average than this part of `step`.
inline constexpr int most_steps = 2000, least_steps = 500;
inline constexpr double shortest_steps = 3e-4;
/// Energy that contacts may gain in a step: a part of the largest kinetic energy, and of that of an island. Where friction leaves
/// hardly any force that keeps a contact closed, forces grow without bounds (Painlevé).
inline constexpr double most_gained = 1e-2, most_gained_by_island = 0.1;
/// A gain below this part of the energy of falling by their own size is no growth.
inline constexpr double least_height = 1e-3;
/// Impacts of an island at one instant.
inline constexpr int most_impacts = 200;
/// How often what stays closed is chosen again after bodies were stopped.
inline constexpr int most_choices = 3;
/// Part of the largest force by which closed contacts may miss their law.
inline constexpr double most_lacking = 1e-3;

/// The length of steps (s) of a method with that step; 0: of one that adapts it.
inline constexpr double usual_step(double step) { return step > 0 ? step : 1e-3; }

// When it ends: after 0.1 s without hits, and after twice the time with each attempt that did not last, up to this (s).
inline constexpr double longest_patience = 10;

// What touches, where contacts are located. Lengths are relative to coordinates (m).

inline constexpr double touching_within = 1e-10;
/// More cannot come from the tolerances of steps.
inline constexpr double overlapping = 1e-8;
/// Lower flights count as rest.
inline constexpr double resolved_flight = 1e-12;
/// Of quantities whose zero is located.
inline constexpr double rounding = 1e-13;

// Speeds, where contacts are located.

/// Of the fastest point: slower bodies do not approach each other.
inline constexpr double no_approach = 1e-10;
/// Slip that is slower (m/s) is stopped where steps would become too short to follow it, after so many short steps in a row.
inline constexpr double creeping = 1e-7;
inline constexpr int most_short_steps = 20;
/// Slip that has just begun keeps the direction that friction would turn in this time (s), so that steps need not be shorter.
inline constexpr double slow_slip = 1e-5;
/// Slip may turn by this much less (m/s) because it keeps its direction; it keeps so many times more with each step that goes
/// straight on.
inline constexpr double most_turned = 2e-9, keeps_more = 5;
/// Adaptive steps are at most so many times as long as friction takes to turn slip. Fixed ones are not divided further than to
/// this part.
inline constexpr double stable_turning = 4, shortest_step_of_slip = 0.05;
/// With more restitution, flights shorter than this part of the usual step are summed in closed form.
inline constexpr double nearly_elastic = 0.99, shortest_flight = 1e-2;

// Where contacts are stepped through, which leaves small gaps, overlaps and speeds.

/// Bodies that are nearer (m) touch.
inline constexpr double step_touch = 1e-6;
/// Smaller overlaps and gaps are left, relative to coordinates (m).
inline constexpr double least_depth = 1e-9;
/// Bodies that approach more slowly (m/s) do not hit each other.
inline constexpr double slow_impact = 1e-3;
/// Nor bodies that gravity would stop in fewer steps: flights as short as these are not resolved, and could go on for ever.
inline constexpr double least_flight = 4;
/// Of bodies that lie on each other: slower approach and slower slip (m/s) count as rest.
inline constexpr double step_approach = 1e-5, step_slip = 1e-6;
/// A body that is slower (m/s, rad/s) stands still: it would move by 1e-11 m in 10 s. Rounding leaves 1e-16.
inline constexpr double standing_still = 1e-12;
/// Fast bodies shorten steps to this part at least.
inline constexpr double shortest_of_fast = 1e-3;

}  // namespace momentree::policy

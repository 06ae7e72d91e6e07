#pragma once
// The two regimes of contact, and every threshold that decides between them or says what counts as touching, resting or slipping.
//
// Contacts are *located*: each change happens at its instant, as an event, and in between closed contacts are equations of
// motion. An island whose changes or points are too many for that is *stepped* through, until its bodies have hit nothing for a
// while (contact_runs.cpp, contact_islands.cpp). Tolerances of geometry and of the solver stand with these: momentree/contact.
#include <cstddef>

namespace momentree::policy {

// When stepping begins.                                          unit, why                                     test of
inline constexpr std::size_t most_points = 32;              // of an island: dense equations at each stage   contact_islands
inline constexpr std::size_t most_pending = 64;             // the same, before a run, which needs them once contact_start
inline constexpr std::size_t crowded = 8;                   // points: above, a change or step counts more   contact_steps
inline constexpr int most_changes = 200;                    // of contacts, in `window_length`: a flood      contact_steps
inline constexpr double window_length = 1e-2;               // s
inline constexpr int most_changes_at_once = 300;            // in `instant_length`: chatter without an end   contact_stops
inline constexpr double instant_length = 1e-6;              // s
inline constexpr int most_steps = 2000, least_steps = 500;  // after so many adaptive steps, fewer if crowded, contact_accuracy
inline constexpr double shortest_steps = 3e-4;              // they are this short on average, of `step`
inline constexpr double most_gained = 1e-2;                 // of the largest kinetic energy, in one step:   contact_stops
inline constexpr double most_gained_by_island = 0.1;        // of its own: forces grow without bounds
inline constexpr double least_height = 1e-3;                // of the energy of falling by their own size: less is no growth
inline constexpr int most_impacts = 200;                    // of an island at one instant                   contact_instants
inline constexpr int most_choices = 3;                      // of what stays closed, after the first one     contact_first_forces
inline constexpr double most_lacking = 1e-3;                // of the largest force, that closed contacts may lack

// When it ends: no hits for 0.1 s, then for twice that time after each attempt that did not last.
inline constexpr double longest_patience = 10;  // s                                             contact_islands

// What touches, located: exact but for rounding; relative to coordinates (m).
inline constexpr double touching_within = 1e-10;  // a gap                                         contacts
inline constexpr double overlapping = 1e-8;       // more cannot come from tolerances of steps     overlaps
inline constexpr double resolved_flight = 1e-12;  // lower flights count as rest                   contacts
inline constexpr double rounding = 1e-13;         // of conditions that are located

// How fast.
inline constexpr double no_approach = 1e-10;           // of the fastest point: bodies do not approach  contacts
inline constexpr double creeping = 1e-7;               // m/s: slip that short steps can't follow stops slow_slip
inline constexpr double slow_slip = 1e-5;              // s of friction: slip that has just begun       slow_slip
inline constexpr double most_turned = 2e-9;            // m/s by which kept directions may turn less    slow_slip
inline constexpr double keeps_more = 5;                // times as much with each step that goes straight on
inline constexpr double stable_turning = 4;            // times of turning friction in an adaptive step slow_slip
inline constexpr double shortest_step_of_slip = 0.05;  // of the given step
inline constexpr int most_short_steps = 20;            // in a row, before slow slip is stopped         slow_slip
inline constexpr double nearly_elastic = 0.99;         // restitution: above, flights shorter than      contact_accuracy
inline constexpr double shortest_flight = 1e-2;        // this, of the usual step, are summed

// The same where contacts are stepped through, which leaves small gaps, overlaps and speeds.
inline constexpr double step_touch = 1e-6;        // m                                             contact_steps
inline constexpr double least_depth = 1e-9;       // m, relative to coordinates: such overlaps stay contact_stacks
inline constexpr double slow_impact = 1e-3;       // m/s: a slower approach is no hit              contact_steps
inline constexpr double step_approach = 1e-5;     // m/s                                           contact_first_forces
inline constexpr double step_slip = 1e-6;         // m/s
inline constexpr double standing_still = 1e-12;   // m/s, rad/s: what rests moves 1e-11 m in 10 s  resting_islands
inline constexpr double shortest_of_fast = 1e-3;  // of the given step, for fast bodies            contact_steps

}  // namespace momentree::policy

#pragma once
// A floor under any scenario, for pages on which mechanisms are thrown.
#include <momentree/scenario/scenario.hpp>

namespace momentree::io {

/// Lets all bodies of a scenario touch a floor: its own, or else a plane below what mechanisms can reach that are attached to the
/// ground, and below the other bodies at the start. Of a mechanism that stands on its joint to the ground, with its centre of
/// mass within 45° above it, what counts is where its bodies are at the start, and the root does not touch the floor. Bodies
/// without a collision touch it, and nothing else, with their shapes; without shapes with capsules along their lines, or a
/// sphere; bodies without mass and shape do not. Contacts are then stepped through in steps of 1 ms. Returns false, and leaves
/// the scenario as it is, if nothing would change.
bool put_on_floor(Scenario& scenario);

/// The height of that plane above the origin, against gravity (m). `scenario`: with the floor.
double floor_height(const Scenario& scenario);

}  // namespace momentree::io

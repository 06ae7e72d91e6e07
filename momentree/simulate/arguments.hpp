#pragma once
// What a Simulation refuses of what it is given, before anything is done with it.
#include <optional>
#include <string>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/simulate/event_queue.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

struct Integration;

namespace detail {
/// A number for a message.
std::string text(double x);
}  // namespace detail

/// The same, or throws Error.
const Integration& checked(const Integration& how);

/// What is wrong with a period that is not positive and finite, or that does not move a clock that stands at `clock` (s) on;
/// nothing where that is fine. `what` it is, for the message.
std::optional<Error> wrong_period(double period, double clock, const char* what);

/// Names that can never be: of no joint that is, was or is to be made, of no body.
std::optional<Error> unknown_name(const World& world, const EventQueue& queue, const std::vector<std::string>& joints,
                                  const std::vector<std::string>& bodies);

/// Throws Error for a condition that can never come true, or means nothing.
void check_condition(const World& world, const EventQueue& queue, const Condition& condition);

}  // namespace momentree

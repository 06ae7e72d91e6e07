#pragma once
// Checks of a Simulation's arguments, before anything is done with them.
#include <optional>
#include <string>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/simulate/events/event_queue.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

struct Integration;
class Model;
struct WorldSnapshot;

/// Why a run with contact is impossible; nothing for a model without contact.
std::optional<Error> unfit_for_contact(const Model& model, const std::string& method);
/// Throws Error if bodies were added to the snapshot's world that touch others, and the method does not support that.
void require_contact_method(const WorldSnapshot& snapshot, const std::string& method);

namespace detail {
/// A number for a message.
std::string text(double x);
}  // namespace detail

/// Its argument, with the name of the method that the engine uses; or throws Error.
Integration checked(Integration how);

/// The error of a period that is not positive and finite, or that is too short to advance a clock at `clock` (s); nothing if the
/// period is valid. `what` names the period in the message.
std::optional<Error> wrong_period(double period, double clock, const char* what);

/// An error if a name can never exist: neither a joint that exists, existed or will be made, nor a body. `springs`: names of
/// springs may take the place of those of joints.
std::optional<Error> unknown_name(const World& world, const EventQueue& queue, const std::vector<std::string>& joints,
                                  const std::vector<std::string>& bodies, bool springs);

/// An error if closed loops do not determine the reaction in a condition.
std::optional<Error> open_reaction(const World& world, const Condition& condition);

/// Throws Error for a condition that can never be met or is meaningless.
void check_condition(const World& world, const EventQueue& queue, const Condition& condition);

}  // namespace momentree

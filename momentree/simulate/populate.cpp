// Bodies that are added to a running simulation, and those that are removed.
#include <momentree/simulate/simulation_impl.hpp>
#include <momentree/simulate/stepping/separate.hpp>

namespace momentree {

// The energy that bodies bring into the world and take out of it is work; the event's certificate states it.
template <class Act>
void Simulation::Impl::populate(const char* what, const std::string& body, Act act) {
  energy.settle(world);
  continues = contact.keeps_closed = false;
  struct Preview {  // of the contacts that the next run closes, also if `act` throws
    Impl& of;
    bool renew;
    ~Preview() {
      if (renew) of.contact.update_pending();
    }
  } preview{*this, contact.between_runs.has_pending()};
  contact.between_runs.open_pending();
  const During working(activity.doing, Doing::working);
  Event event;
  event.time = world.time();
  event.name = what;
  const Membership members(world);
  const std::vector<JointId> joints = present_joints(world);
  std::vector<std::string> names;
  for (const JointId joint : joints) names.emplace_back(world.joint_name(joint));
  std::vector<int> springs;  // that act
  for (int s = 0; s < world.springs(); ++s)
    if (spring_acts(world.tree(), s)) springs.push_back(s);
  const std::vector<unsigned char> coupled = acting_couplings(world.tree());
  event.mechanisms_before = world.mechanism_names();
  event.before = world.totals();
  std::optional<SimulationSnapshot> past;
  if (history.keeps()) past = snapshot();
  act();  // throws if nothing happened
  if (past) history.keep({events.size(), std::move(*past), {}});
  world.edit().take_own_variables();
  std::vector<SteppedContact> points = contact.steps.points.all();
  make_methods();
  const auto is_gone = [this](int each) { return each >= 0 && !world.alive({each}); };
  std::erase_if(points, [&](const SteppedContact& point) { return is_gone(point.a) || is_gone(point.b); });
  if (!points.empty()) contact.steps.points.set(std::move(points), true);
  evaluate_state();
  event.after = world.totals();
  event.mechanisms_after = world.mechanism_names();
  event.work = event.after.kinetic + event.after.potential - event.before.kinetic - event.before.potential;
  event.actions = {{what, body, {}, body, {}, {}}};
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (is_loop(joints[i]) ? world.tree().loops().find(joints[i]) == nullptr : world.tree().carrier(joints[i].index) < 0)
      event.topology.gone.push_back(std::move(names[i]));
  for (const int s : springs)
    if (!spring_acts(world.tree(), s))
      event.topology.broken_springs.push_back(world.model().springs()[static_cast<std::size_t>(s)].name);
  for (std::size_t c = 0; c < coupled.size(); ++c)
    if (coupled[c] != 0 && !world.tree().coupling_acts(static_cast<int>(c)))
      event.topology.ended_couplings.push_back(coupling_names(world, {static_cast<int>(c)}));
  if (world.tree().bodies() > members.bodies()) event.topology.joints.push_back(joint_record(world, {world.tree().bodies() - 1}));
  event.topology.moved = members.moved(Membership(world));
  energy.balance.work += event.work;
  events.push_back(std::move(event));
  queue.forget_looks();
  static_cast<void>(contact.resolve_in_turn(true));  // what can't be resolved ends the next run, which says why
  preview.renew = contact.some_step() || contact.steps_through();
}

// What the body overlaps is an error, or pushed apart.
std::optional<Error> Simulation::Impl::find_room(BodyId body) {
  if (std::optional<Error> unfit = unfit_for_contact(world.model(), integration.method)) return unfit;
  world.edit().take_own_variables();
  contact.geometry.pairs.renew();
  const std::optional<Overlap> overlap = contact.geometry.overlaps.with(body);
  if (!overlap) return std::nullopt;
  if (!integration.resolve)
    return Error{overlap->text(), "",
                 "move one of them, let them pass through each other by a contact rule that is off, or push them apart by "
                 "resolve = true"};
  const std::vector<Contact> closed(world.tree().contacts().begin(), world.tree().contacts().end());
  contact.geometry.world.open(), contact.geometry.stepped.set({});
  std::optional<Error> error = Separator(contact.geometry).run().error();
  contact.geometry.stepped.set(contact.stepped_bodies());
  if (!error) contact.geometry.world.close(closed);
  return error;
}

BodyId Simulation::Impl::add_with_room(BodySpec spec, std::vector<contact::Solid> collision) {
  if (collision.empty()) return world.edit().add(std::move(spec), {});
  const WorldSnapshot before = world.snapshot();
  const BodyId body = world.edit().add(std::move(spec), std::move(collision));
  if (std::optional<Error> error = find_room(body)) {
    world.restore(before);
    contact.geometry.pairs.renew();
    contact.steps.points.set(contact.steps.points.all(), contact.steps.points.released());
    evaluate_state();
    throw_error(std::move(*error));
  }
  return body;
}

BodyId Simulation::Impl::add(BodySpec spec, std::vector<contact::Solid> collision) {
  const std::string name = spec.name;
  BodyId body;
  populate("add", name, [&] { body = add_with_room(std::move(spec), std::move(collision)); });
  return body;
}

void Simulation::Impl::remove(BodyId body) {
  if (!world.alive(body)) throw_error({"the body is no longer in this world", "", ""});
  populate("remove", world.model()[body].name, [&] { world.edit().remove(body); });
}

BodyId Simulation::add(BodySpec spec, std::vector<contact::Solid> collision) {
  return changing().add(std::move(spec), std::move(collision));
}
void Simulation::remove(BodyId body) { changing().remove(body); }

}  // namespace momentree

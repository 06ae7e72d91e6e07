// Applies state documents to a simulation.
#include <algorithm>
#include <cmath>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/scenario/state/changed_start.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

struct Entry {
  const JointStart* start = nullptr;
  const std::string* where = nullptr;
};

/// The tree: by body its parent, by joint the body that carries it, and the kind.
struct Places {
  Places(const World& world, const Forest& forest) {
    const Model& model = world.model();
    const int bodies = forest.places.empty() ? world.start().bodies : static_cast<int>(forest.places.size());
    for (int b = 0; b < bodies; ++b) {
      carrier.push_back(b);
      parent.push_back(model[{b}].parent.index);
      nv.push_back(info(model[{b}].joint.kind).nv);
    }
    for (std::size_t b = 0; b < forest.places.size(); ++b) {
      parent[b] = forest.places[b].parent;
      carrier[static_cast<std::size_t>(forest.places[b].joint)] = static_cast<int>(b);
    }
    for (const Forest::Changed& changed : forest.changed) nv[static_cast<std::size_t>(changed.joint)] = info(changed.as.kind).nv;
    roots.assign(parent.size(), -1);
    std::vector<std::size_t> way;
    for (std::size_t b = 0; b < parent.size(); ++b) {
      std::size_t a = b;
      for (way.clear(); roots[a] < 0 && parent[a] >= 0; a = static_cast<std::size_t>(parent[a])) way.push_back(a);
      const int root = roots[a] < 0 ? static_cast<int>(a) : roots[a];
      roots[a] = root;
      for (const std::size_t passed : way) roots[passed] = root;
    }
  }
  std::size_t root_of_joint(std::size_t joint) const {
    return static_cast<std::size_t>(roots[static_cast<std::size_t>(carrier[joint])]);
  }

  std::vector<int> parent, carrier, nv, roots;
};

/// Momenta depend on the velocities of the whole mechanism: they are used if every joint of it has one.
void choose_momenta(const World& world, const Forest& forest, const std::vector<Entry>& entries,
                    std::vector<JointStart>& starts) {
  const Places places(world, forest);
  std::vector<char> complete(entries.size(), 1);
  for (std::size_t j = 0; j < places.nv.size(); ++j)
    if (places.nv[j] > 0 && (entries[j].start == nullptr || entries[j].start->p.empty())) complete[places.root_of_joint(j)] = 0;
  for (JointStart& start : starts) {
    const auto j = static_cast<std::size_t>(start.joint.index);
    if (start.p.empty() || complete[places.root_of_joint(j)] != 0) continue;
    if (start.v.empty())
      throw_error({"joint '" + world.model().bodies()[j].joint_name +
                       "' has `p` and no `v`, but other joints of its mechanism have no `p`",
                   *entries[j].where, "give `v`, or `p` of every joint of the mechanism"});
    start.p = {};
  }
}

double fastest_body(const World& world) {
  double speed = 0;
  for (const BodyMotion& motion : world.motions()) speed = std::max({speed, norm(motion.linear), norm(motion.angular)});
  return speed;
}

/// The velocities of the restored world as they follow from the momenta that the joints start with.
std::vector<double> velocities_of(const World& world, const std::vector<JointStart>& starts) {
  const Tree& tree = world.tree();
  if (world.state().variables() == Variables::momenta) return {world.v().begin(), world.v().end()};
  std::vector<double> q(world.state().q().begin(), world.state().q().end()), p(world.p().begin(), world.p().end());
  for (const JointStart& start : starts)
    for (int i = 0; i < start.p.size(); ++i)
      p[static_cast<std::size_t>(tree.first_p(tree.carrier(start.joint.index)) + i)] = start.p[i];
  follow_motions(tree, world.time(), q.data(), p.data());
  State state(tree);
  state.assign(world.time(), q, p, tree);
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  return {workspace.v.get(), workspace.v.get() + p.size()};
}

/// `where`: `file:line:col`.
Diagnostic warning_at(const std::string& where, const ChangedStart& changed) {
  const std::size_t column = where.rfind(':'), line = where.rfind(':', column - 1);
  return {Severity::warning,
          where.substr(0, line),
          std::stoi(where.substr(line + 1)),
          std::stoi(where.substr(column + 1)),
          changed.what,
          changed.hint,
          ""};
}

}  // namespace

std::vector<Diagnostic> restore(Simulation& simulation, const std::vector<RestoredState>& documents) {
  const Model& model = simulation.world().model();
  std::vector<Entry> entries(model.bodies().size());
  Forest forest;
  double time = simulation.time();
  for (const RestoredState& document : documents) {
    for (std::size_t i = 0; i < document.joints.size(); ++i) {
      const int number = document.joints[i].joint.index;
      MT_REQUIRE(number >= 0 && number < model.size(), "documents that were read for the simulation's model");
      const auto same = [number](const Forest::Changed& changed) { return changed.joint == number; };
      if (document.forest.places.empty() && std::any_of(forest.changed.begin(), forest.changed.end(), same))
        throw_error({"joint '" + model.bodies()[static_cast<std::size_t>(number)].joint_name +
                         "' is different, or does not exist, in the document of the whole world",
                     document.where[i], "restore the whole world from one document"});
      entries[static_cast<std::size_t>(number)] = {&document.joints[i], &document.where[i]};
    }
    if (!document.forest.places.empty()) {
      forest = document.forest;
      forest.gravity = document.forest.gravity.value_or(simulation.world().start().gravity);
    } else if (!document.forest.springs.empty()) {
      forest.springs = document.forest.springs;
    }
    if (!document.forest.contacts.empty()) forest.contacts = document.forest.contacts;
    time = document.time.value_or(time);
    if (document.forest.gravity) forest.gravity = document.forest.gravity;
  }
  std::vector<JointStart> starts;
  for (const Entry& entry : entries)
    if (entry.start != nullptr) starts.push_back(*entry.start);
  choose_momenta(simulation.world(), forest, entries, starts);
  const auto check = [&](const World& world) {
    const Totals totals = world.totals();
    if (!std::isfinite(totals.kinetic) && !forest.places.empty())
      throw_error({"a part of the world that it describes lacks the mass or inertia to move freely", documents.front().file,
                   "is it a document of this model?"});
    if (world.tree().has_loops() && world.state().variables() == Variables::velocities) return;  // see changed_start()
    const double tolerance = 1e-6 * fastest_body(world);
    const std::vector<double> velocities = velocities_of(world, starts);
    for (const JointStart& start : starts) {
      if (start.p.empty() || start.v.empty()) continue;
      const int first = world.tree().first_p(world.tree().carrier(start.joint.index));
      for (int i = 0; i < start.v.size(); ++i) {
        const double v = velocities[static_cast<std::size_t>(first + i)];
        if (!(std::fabs(v - start.v[i]) <= tolerance))
          throw_error({"`v` of joint '" + std::string(world.joint_name(start.joint)) + "' does not fit its `p`: number " +
                           std::to_string(i + 1) + " should be " + number_text(v) + ", not " + number_text(start.v[i]),
                       *entries[static_cast<std::size_t>(start.joint.index)].where, "leave out one of the two"});
      }
    }
  };
  simulation.restore(time, forest, starts, check);
  const World& world = simulation.world();
  if (!world.tree().has_loops()) return {};
  if (world.state().variables() == Variables::momenta)
    for (JointStart& start : starts)
      if (!start.p.empty()) start.v = {};  // compared above
  const std::optional<ChangedStart> changed = changed_start(world, starts);
  if (!changed) return {};
  return {warning_at(*entries[static_cast<std::size_t>(changed->joint.index)].where, *changed)};
}

}  // namespace momentree::io

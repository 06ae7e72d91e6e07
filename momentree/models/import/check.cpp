// Checks of bodies and joints for all file formats.
#include <algorithm>
#include <utility>

#include <momentree/models/import/follow_circles.hpp>
#include <momentree/models/import/importer.hpp>
#include <momentree/models/import/massless.hpp>

namespace momentree::io {

namespace {

XmlElement or_else(XmlElement first, XmlElement second) { return first ? first : second; }

XmlElement place_of(const BodySpots& spots, const std::string& field) {
  if (field == "mass" || field == "inertia" || field == "com") return or_else(spots.inertia, spots.body);
  if (field == "name" || field == "child_at") return spots.body;
  return or_else(spots.joint, spots.body);
}

bool report(const BodySpots& spots, const std::string& field, std::string what, std::string hint) {
  spots.file->error({place_of(spots, field)}, std::move(what), std::move(hint));
  return false;
}

bool check_one(const ImportedBody& body) {
  bool sound = true;
  for (const BodyProblem& problem : check_body(body.spec)) {
    if (problem.field == "name" || problem.field == "joint_name") continue;  // reported where they were read
    sound = report(body.spots, problem.field, problem.field + ": " + problem.what, problem.hint);
  }
  return sound;
}

void check_imported_loops(const ImportedModel& model) {
  for (const ImportedLoop& loop : model.loops)
    for (const BodyProblem& problem : check_loop(loop.spec, static_cast<int>(model.bodies.size())))
      if (problem.field != "name") report(loop.spots, problem.field, problem.field + ": " + problem.what, problem.hint);
}

void check_inertias(const ImportedModel& model) {
  const auto sound = [](const ImportedBody& body) { return check_mass(body.spec.mass, body.spec.inertia).what.empty(); };
  if (std::all_of(model.bodies.begin(), model.bodies.end(), sound)) return;  // then every group of them is sound, too
  std::vector<BodySpec> specs;
  specs.reserve(model.bodies.size());
  for (const ImportedBody& body : model.bodies) specs.push_back(body.spec);
  for (const auto& [body, problem] : check_masses(specs)) {
    const BodySpots& spots = model.bodies[static_cast<std::size_t>(body.index)].spots;
    const XmlLocation at{place_of(spots, "inertia")};
    const std::string what = problem.what + " ('" + specs[static_cast<std::size_t>(body.index)].name + "')";
    if (problem.warning)
      spots.file->warning(at, what, problem.hint);
    else
      spots.file->error(at, what, problem.hint);
  }
}

void warn_of_massless(const ImportedModel& model) {
  std::vector<const BodySpec*> specs;
  specs.reserve(model.bodies.size());
  for (const ImportedBody& body : model.bodies) specs.push_back(&body.spec);
  for (const int b : massless_links(specs)) {
    const BodySpots& spots = model.bodies[static_cast<std::size_t>(b)].spots;
    if (spots.body.name() == "joint") continue;  // a joint made by the importer
    spots.file->warning({spots.body}, massless_link(specs[static_cast<std::size_t>(b)]->name), massless_hint);
  }
}

// A joint that follows itself through others has no leader: whatever the multipliers, its position is undetermined.
void check_followers(const ImportedModel& model) {
  const auto name = [&](int body) { return in_quotes(model.bodies[static_cast<std::size_t>(body)].spec.joint_name); };
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(model.followers.size());
  for (const Follower& each : model.followers)
    if (!each.exact) pairs.emplace_back(each.body, each.leader);
  for (const std::vector<int>& circle : circles_of(pairs)) {
    const auto first = std::find_if(model.followers.begin(), model.followers.end(),
                                    [&](const Follower& each) { return each.body == circle[0] && each.leader == circle[1]; });
    first->file->error({first->element}, "mimic: " + circle_text(circle, name), "one of them must lead and follow no other");
  }
}

}  // namespace

void check_imported(ImportedModel& model) {
  bool sound = true;
  for (const ImportedBody& body : model.bodies) {
    if (body.spots.file->enough()) return;
    sound = check_one(body) && sound;
  }
  check_imported_loops(model);
  check_followers(model);
  check_inertias(model);
  if (sound) warn_of_massless(model);
}

}  // namespace momentree::io

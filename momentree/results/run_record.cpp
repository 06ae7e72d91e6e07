#include <momentree/results/run_record.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include <momentree/integrate/integrator.hpp>
#include <momentree/results/columns/contact_columns.hpp>
#include <momentree/results/columns/energy_columns.hpp>
#include <momentree/results/columns/row_numbers.hpp>
#include <momentree/results/columns/spring_columns.hpp>

namespace momentree::io {

namespace {

constexpr double absent = std::numeric_limits<double>::quiet_NaN();

// Makes quaternions in a column of coordinates continuous in sign, as in the tables.
void make_continuous(std::vector<double>& q, std::size_t width, std::size_t first) {
  ContinuousQuaternions signs(1);
  for (std::size_t at = first; at + 4 <= q.size(); at += width) {
    double* const now = q.data() + at;
    if (std::isnan(now[0])) continue;
    const Quat next = signs.next(0, {now[0], now[1], now[2], now[3]});
    now[0] = next.w, now[1] = next.x, now[2] = next.y, now[3] = next.z;
  }
}

}  // namespace

RunRecord::RunRecord(const Simulation& simulation, RunOrigin origin, std::string model_json, bool reactions)
    : origin_(std::move(origin)),
      model_(simulation.world().model()),
      model_json_(std::move(model_json)),
      reactions_(reactions),
      events_before_(simulation.events().size()) {}

void RunRecord::begin_epoch(const Simulation& simulation) {
  const World& world = simulation.world();
  const Tree& tree = world.tree();
  if (world.model().size() != model_.size()) model_ = world.model();
  Epoch epoch{times_.size(), tree.revision(), world.snapshot(), {}, tree.nq(), tree.nv(), 0, 0, 0};
  epoch.world.engine.q.clear(), epoch.world.engine.y.clear();
  for (int j = 0; j < tree.bodies(); ++j) {
    Layout layout;
    if (const int body = tree.carrier(j); body >= 0) {
      const KindInfo& kind = info(tree.joint(body).kind);
      layout = {std::string(world.joint_name({j})), tree.first_q(body), kind.nq, tree.first_p(body), kind.nv, kind.q_units};
    }
    epoch.joints.push_back(std::move(layout));
  }
  for (const JointId loop : world.loops()) {
    const KindInfo& kind = info(world.joint(loop).kind);
    epoch.joints.push_back(
        {std::string(world.joint_name(loop)), epoch.loop_q, kind.nq, epoch.loop_v, kind.nv, kind.q_units, loop.index});
    epoch.loop_q += kind.nq, epoch.loop_v += kind.nv, ++epoch.loops;
  }
  epochs_.push_back(std::move(epoch));
}

std::size_t RunRecord::row_size(const Epoch& epoch) const {
  const auto nq = static_cast<std::size_t>(epoch.nq), nv = static_cast<std::size_t>(epoch.nv);
  const auto loops = static_cast<std::size_t>(epoch.loop_q + epoch.loop_v + 2 * epoch.loops);
  return nq + 2 * nv + loops + (reactions_ ? nv + 6 * epoch.joints.size() : 0);
}

void RunRecord::drop_last_row() {
  numbers_.resize(offsets_.back());
  times_.pop_back(), offsets_.pop_back(), energy_.pop_back(), progress_.pop_back();
  contacts_.resize(std::min(contacts_.size(), times_.size()));
  if (epochs_.back().first_row == times_.size() && times_.size() > 0) epochs_.pop_back();
  if (times_.empty()) epochs_.clear();
}

void RunRecord::add_loops(const World& world, const Epoch& epoch) {
  for (const Layout& joint : epoch.joints)
    if (joint.loop >= 0)
      for (const double x : world.joint({joint.loop}).q) numbers_.push_back(x);
  for (const Layout& joint : epoch.joints)
    if (joint.loop >= 0)
      for (const double x : world.joint({joint.loop}).v) numbers_.push_back(x);
  const std::vector<Turns>& turns = world.state().turns();
  for (std::size_t i = 0; i < static_cast<std::size_t>(epoch.loops); ++i) {
    const Turns own = i < turns.size() ? turns[i] : Turns{};
    numbers_.push_back(own.first), numbers_.push_back(own.second);
  }
}

void RunRecord::add_progress(const Simulation& simulation) {
  Progress progress{simulation.snapshot(), {}};
  progress.run.world = {};
  progress.run.queue.reset();  // strengths of joints are looked at anew
  std::vector<EventStatus> armed = std::exchange(progress.run.armed, {});
  for (EventStatus& each : armed) each.excess = each.excess_before = 0, each.looked = each.looked_before = -1;
  const bool same = !progress_.empty() && *progress_.back().armed == armed;
  progress.armed = same ? progress_.back().armed : std::make_shared<const std::vector<EventStatus>>(std::move(armed));
  progress_.push_back(std::move(progress));
}

void RunRecord::observe(const Simulation& simulation) {
  const World& world = simulation.world();
  if (!times_.empty() && times_.back() == world.time()) drop_last_row();
  if (epochs_.empty() || epochs_.back().revision != world.tree().revision()) begin_epoch(simulation);
  const Epoch& epoch = epochs_.back();
  const std::size_t offset = numbers_.size();
  try {
    const std::size_t needed = offset + row_size(epoch);
    if (needed > numbers_.capacity()) numbers_.reserve(std::max(needed, 2 * numbers_.capacity()));
    const auto add = [&](std::span<const double> some) { numbers_.insert(numbers_.end(), some.begin(), some.end()); };
    add(world.state().q());
    add(world.v());
    add(world.p());
    if (epoch.loops > 0) add_loops(world, epoch);
    if (reactions_) {
      add(world.a());
      for (std::size_t j = 0; j < epoch.joints.size(); ++j) {
        const Layout& joint = epoch.joints[j];
        const Wrench w = joint.name.empty() ? Wrench{} : world.reaction({joint.loop < 0 ? static_cast<int>(j) : joint.loop});
        add(wrench_numbers(w));
      }
    }
    if (reactions_) contact_rows(contacts_.emplace_back(), world);
    const EnergyBalance energy = simulation.energy();
    add_progress(simulation);
    offsets_.push_back(offset);
    energy_.push_back(energy);
    times_.push_back(world.time());
  } catch (...) {  // out of memory: no partial row
    numbers_.resize(offset);
    offsets_.resize(times_.size()), energy_.resize(times_.size()), progress_.resize(times_.size());
    contacts_.resize(std::min(contacts_.size(), times_.size()));
    throw;
  }
}

void RunRecord::finish(const Simulation& simulation, std::string status, const Armed& armed) {
  observe(simulation);
  status_ = std::move(status);
  const std::vector<Event>& all = simulation.events();
  events_.assign(all.begin() + static_cast<std::ptrdiff_t>(std::min(events_before_, all.size())), all.end());
  summary_ = summary_json(origin_, status_, simulation);
  final_ = state_json(simulation.world(), armed, step_memory(simulation));
}

std::vector<JointKinds> RunRecord::joint_kinds() const {
  std::vector<JointKinds> all;
  std::unordered_map<std::string_view, std::size_t> known;
  for (const Epoch& epoch : epochs_)
    for (const Layout& layout : epoch.joints) {
      if (layout.name.empty()) continue;
      const auto [place, fresh] = known.try_emplace(layout.name, all.size());
      if (fresh) all.push_back({layout.name});
      JointKinds& joint = all[place->second];
      joint.nq = std::max(joint.nq, layout.nq), joint.nv = std::max(joint.nv, layout.nv);
    }
  return all;
}

std::vector<std::string> RunRecord::joints() const {
  std::vector<std::string> names;
  for (JointKinds& joint : joint_kinds()) names.push_back(std::move(joint.name));
  return names;
}

template <class Visit>
void RunRecord::each_row(const Visit& visit) const {
  for (std::size_t e = 0; e < epochs_.size(); ++e) {
    const std::size_t end = e + 1 < epochs_.size() ? epochs_[e + 1].first_row : rows();
    for (std::size_t row = epochs_[e].first_row; row < end; ++row) visit(epochs_[e], row, numbers_.data() + offsets_[row]);
  }
}

JointRows RunRecord::joint(std::string_view name) const {
  const auto found_in = [&](const Epoch& epoch) {
    return std::find_if(epoch.joints.begin(), epoch.joints.end(), [&](const Layout& each) { return each.name == name; });
  };
  JointRows table;
  bool found = false, quaternion[8] = {};
  for (const Epoch& epoch : epochs_) {
    const auto layout = found_in(epoch);
    if (layout == epoch.joints.end()) continue;
    found = true;
    table.nq = std::max(table.nq, static_cast<std::size_t>(layout->nq));
    table.nv = std::max(table.nv, static_cast<std::size_t>(layout->nv));
    const std::size_t first = std::string_view(layout->q_units).find('n');
    if (first != std::string_view::npos) quaternion[first] = true;
  }
  if (!found) throw_error({"the run had no joint '" + std::string(name) + "'", "", did_you_mean(name, joints())});
  table.q.assign(rows() * table.nq, absent);
  table.v.assign(rows() * table.nv, absent), table.p = table.v;
  if (reactions_) table.a = table.v, table.wrench.assign(rows() * 6, absent);
  const Epoch* last = nullptr;
  std::size_t number = 0;
  each_row([&](const Epoch& epoch, std::size_t row, const double* numbers) {
    if (&epoch != last) last = &epoch, number = static_cast<std::size_t>(found_in(epoch) - epoch.joints.begin());
    if (number == epoch.joints.size()) return;
    const Layout& at = epoch.joints[number];
    const bool in_tree = at.loop < 0;
    const double* const loops = numbers + epoch.nq + std::ptrdiff_t{2} * epoch.nv;
    const double* const q = in_tree ? numbers : loops;
    const double* const v = in_tree ? numbers + epoch.nq : loops + epoch.loop_q;
    std::copy_n(q + at.first_q, at.nq, table.q.data() + row * table.nq);
    std::copy_n(v + at.first_p, at.nv, table.v.data() + row * table.nv);
    if (in_tree) std::copy_n(v + epoch.nv + at.first_p, at.nv, table.p.data() + row * table.nv);
    if (!reactions_) return;
    const double* const a = loops + epoch.loop_q + epoch.loop_v + epoch.loops;
    if (in_tree) std::copy_n(a + at.first_p, at.nv, table.a.data() + row * table.nv);
    std::copy_n(a + epoch.nv + 6 * number, 6, table.wrench.data() + row * 6);
  });
  for (std::size_t first = 0; first < 4; ++first)
    if (quaternion[first]) make_continuous(table.q, table.nq, first);
  return table;
}

WorldSnapshot RunRecord::state(std::size_t row) const {
  MT_REQUIRE(row < rows(), "a row of the record");
  const auto after = std::upper_bound(epochs_.begin(), epochs_.end(), row,
                                      [](std::size_t r, const Epoch& epoch) { return r < epoch.first_row; });
  const Epoch& epoch = *std::prev(after);
  WorldSnapshot snapshot = epoch.world;
  const double* const numbers = numbers_.data() + offsets_[row];
  snapshot.engine.time = times_[row];
  snapshot.engine.q.assign(numbers, numbers + epoch.nq);
  const double* const y = numbers + epoch.nq + (snapshot.engine.variables == Variables::momenta ? epoch.nv : 0);
  snapshot.engine.y.assign(y, y + epoch.nv);
  const double* const turns = numbers + epoch.nq + std::ptrdiff_t{2} * epoch.nv + epoch.loop_q + epoch.loop_v;
  snapshot.engine.turns.clear();
  for (int i = 0; i < epoch.loops; ++i) snapshot.engine.turns.push_back({turns[2 * i], turns[2 * i + 1]});
  return snapshot;
}

SimulationSnapshot RunRecord::snapshot(std::size_t row) const {
  SimulationSnapshot snapshot = progress_[row].run;
  snapshot.world = state(row);
  snapshot.armed = *progress_[row].armed;
  return snapshot;
}

template <class Visit>
void RunRecord::each_world(const Visit& visit) const {
  if (rows() == 0) return;
  Model first = model_;
  first.keep(model_.size() - static_cast<int>(epochs_.back().world.added.size()));
  World world(first);
  for (std::size_t row = 0; row < rows(); ++row) {
    world.restore(state(row));
    visit(world, row);
  }
}

std::vector<double> RunRecord::body(BodyId body) const {
  std::vector<double> all;
  all.reserve(rows() * 13);
  each_world([&](const World& world, std::size_t) {
    const auto numbers = body_numbers(world, body);
    all.insert(all.end(), numbers.begin(), numbers.end());
  });
  make_continuous(all, 13, 3);
  return all;
}

std::vector<double> RunRecord::spring(std::string_view name) const {
  const SpringId spring = model_.spring(name);
  std::vector<double> all;
  all.reserve(rows() * 3);
  each_world([&](const World& world, std::size_t) {
    const auto numbers = spring_numbers(world, spring.index);
    all.insert(all.end(), numbers.begin(), numbers.end());
  });
  return all;
}

const std::vector<std::string>& RunRecord::energy_columns() {
  static const std::vector<std::string> names = energy_column_names();
  return names;
}

std::vector<double> RunRecord::energies() const {
  std::vector<double> all;
  all.reserve(rows() * 14);
  each_world([&](const World& world, std::size_t row) {
    const auto numbers = energy_numbers(world, energy_[row]);
    all.insert(all.end(), numbers.begin(), numbers.end());
  });
  return all;
}

std::string RunRecord::contact_table() const {
  std::string text;
  contact_header(text);
  for (const std::string& rows : contacts_) text += rows;
  return text;
}

std::string RunRecord::write(const std::string& folder, const ReportPage& report, const std::string& meshes) const {
  const bool with_contacts = reactions_ && !model_.colliders().empty();
  const TableChoice choice{.joints = joint_kinds()};
  std::vector<std::string> files = RunTables::files(model_, choice);
  files.insert(files.end(), {"summary.json", "model.json", "final.json"});
  if (with_contacts) files.emplace_back("contacts.csv");
  if (!meshes.empty()) files.emplace_back("meshes.json");
  if (report) files.emplace_back("report.html");
  ResultDirectory directory(folder, files);
  directory.write("model.json", model_json_);
  if (!meshes.empty()) directory.write("meshes.json", meshes);
  std::optional<RunTables> tables;
  each_world([&](const World& world, std::size_t row) {
    if (!tables) tables.emplace(directory, world, choice);
    tables->row(world, energy_[row]);
    if (tables->is_full()) tables->flush();
  });
  MT_REQUIRE(tables.has_value(), "a record that is finished");
  for (const Event& event : events_) tables->add(event);
  tables->events().close(false);
  for (RunTables::File& table : tables->tables()) table.file.close(false);
  if (with_contacts) directory.write("contacts.csv", contact_table());  // reactions are not computed anew
  directory.write("final.json", final_);
  if (report) directory.write("report.html", report(directory.working(), summary_));
  directory.write("summary.json", summary_);
  if (status_ != "done") {
    directory.keep();
    return directory.working().string();
  }
  (void)directory.publish();
  return directory.destination().string();
}

}  // namespace momentree::io

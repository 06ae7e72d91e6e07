#include <momentree/results/run_tables.hpp>

#include <algorithm>
#include <utility>

#include <momentree/results/columns/contact_columns.hpp>
#include <momentree/results/columns/energy_columns.hpp>
#include <momentree/results/columns/spring_columns.hpp>
#include <momentree/results/summary.hpp>

namespace momentree::io {

namespace {

using Ranges = std::vector<std::pair<int, int>>;  // of bodies: the first number, and how many

/// The bodies that have places, as ranges of these.
Ranges by_place(const Ranges& ranges, const std::vector<int>& places) {
  Ranges all;
  for (const auto& [first, count] : ranges)
    for (int b = first; b < first + count; ++b) {
      const int place = b < static_cast<int>(places.size()) ? places[static_cast<std::size_t>(b)] : -1;
      if (place < 0) continue;
      if (!all.empty() && all.back().first + all.back().second == place)
        ++all.back().second;
      else
        all.emplace_back(place, 1);
    }
  return all;
}

}  // namespace

std::vector<std::string> RunTables::files(const Model& model, const TableChoice& choice) {
  std::vector<std::string> names = {"events.jsonl", "bodies.csv", "joints.csv"};
  if (choice.energy) names.emplace_back("energy.csv");
  if (!model.springs().empty()) names.emplace_back("springs.csv");
  if (choice.contacts) names.emplace_back("contacts.csv");
  return names;
}

bool RunTables::fit(const World& start, const TableChoice& choice, const RecorderState& from) {
  const auto same = [](const std::string& name, const RecorderState::Table& table) { return name == table.file; };
  return std::ranges::equal(files(start.model(), choice), from.tables, same) &&
         from.body_quaternions.size() == static_cast<std::size_t>(start.model().size()) &&
         from.joint_quaternions.size() == choice.joints.size() + 1;
}

RunTables::RunTables(ResultDirectory& folder, const World& start, const TableChoice& choice, bool keep_checksums,
                     const RecorderState* from)
    : bodies_(start), joints_(choice.joints, choice.reactions) {
  const Model& model = start.model();
  int place = 0;
  for (int b = 0; b < model.size(); ++b) places_.push_back(start.alive({b}) ? place++ : -1);
  all_have_places_ = place == model.size();
  const auto open = [&](const char* name, const auto& header, Row row) {
    const std::string path = folder.file(name);
    if (from != nullptr) {
      const RecorderState::Table& table = from->tables[files_.size()];
      files_.push_back({name, TextFile(path, table.mark), std::move(row)});
      files_.back().file.text() = table.last;
    } else {
      files_.push_back({name, TextFile(path), std::move(row)});
      if (keep_checksums) files_.back().file.keep_checksum();
      header(files_.back().file.text());
    }
  };
  open("events.jsonl", [](std::string&) {}, {});
  open(
      "bodies.csv", [&](std::string& text) { bodies_.header(text, model); },
      [this](std::string& text, const World& world, const EnergyBalance&) { bodies_.row(text, world); });
  open(
      "joints.csv", [&](std::string& text) { joints_.header(text); },
      [this](std::string& text, const World& world, const EnergyBalance&) { joints_.row(text, world); });
  if (choice.energy) open("energy.csv", energy_header, energy_row);
  if (!model.springs().empty())
    open(
        "springs.csv", [&](std::string& text) { spring_header(text, model); },
        [](std::string& text, const World& world, const EnergyBalance&) { spring_row(text, world); });
  if (choice.contacts)
    open("contacts.csv", contact_header,
         [](std::string& text, const World& world, const EnergyBalance&) { contact_rows(text, world); });
  if (from == nullptr) return;
  bodies_.quaternions().continue_from(from->body_quaternions);
  joints_.quaternions().continue_from(from->joint_quaternions);
}

/// `moved` has the places of bodies in bodies.csv.
void RunTables::add(const Event& event) {
  const auto in_place = [this](const std::pair<int, int>& range) {
    const auto [first, count] = range;
    return all_have_places_ && first + count <= static_cast<int>(places_.size());
  };
  Event line;
  const std::vector<TopologyRecord::Moved>& moved = event.topology.moved;
  const bool same =
      std::ranges::all_of(moved, [&](const TopologyRecord::Moved& each) { return std::ranges::all_of(each.bodies, in_place); });
  if (!same) {
    line = event;
    for (TopologyRecord::Moved& each : line.topology.moved) each.bodies = by_place(each.bodies, places_);
  }
  events().text() += event_json(same ? event : line) + '\n';
}

void RunTables::row(const World& world, const EnergyBalance& balance, bool replaces) {
  const auto drop = [this] {
    for (File& each : tables()) each.file.text().resize(each.last);
  };
  if (replaces) drop();
  for (File& each : tables()) each.last = each.file.text().size();
  try {
    for (File& each : tables()) each.row(each.file.text(), world, balance);
  } catch (...) {  // out of memory
    drop();
    throw;
  }
}

bool RunTables::is_full() const {
  return std::ranges::any_of(files_, [](const File& each) { return each.file.is_full(); });
}

void RunTables::flush() {
  for (File& each : files_) each.file.flush();
}

void RunTables::save(RecorderState& state) {
  files_.front().last = events().text().size();
  for (File& each : files_) {
    each.file.flush(std::exchange(each.last, 0));
    state.tables.push_back({each.name, each.file.mark(), each.file.text()});
  }
  state.body_quaternions = bodies_.quaternions().last();
  state.joint_quaternions = joints_.quaternions().last();
}

}  // namespace momentree::io

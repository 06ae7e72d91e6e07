// An MCAP file with the messages of Foxglove in JSON (.mcap). Times are those of the run; if it starts before zero, its start is
// at zero.
//
// /tf: foxglove.FrameTransforms, the poses of all bodies in the frame `world`, a message per row. /scene: foxglove.SceneUpdate,
// solids in the colours of mechanisms, at the start and at each change; /scene/own_colours: the others, at the start;
// /scene/bars: springs and the bars of joints that were made, at each row. /joints, /springs, /energy: the tables. /events:
// foxglove.Log.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <momentree/export/exporter.hpp>
#include <momentree/export/foxglove_schemas.hpp>
#include <momentree/export/mcap_file.hpp>
#include <momentree/export/scene_messages.hpp>
#include <momentree/results/recording/number_table.hpp>

namespace momentree::io {

namespace {

/// A table in memory, its columns grouped by what stands before the last dot of their names.
struct Grouped {
  struct Column {
    std::string field;
    std::size_t at;
  };
  struct Group {
    std::string owner;
    std::vector<Column> columns;
  };
  std::vector<double> times{}, numbers{};
  std::size_t width = 0;
  std::vector<Group> groups{};

  const double* row(std::size_t number) const { return numbers.data() + number * width; }
};

std::optional<Grouped> grouped(const std::filesystem::path& file) {
  const std::optional<NumberTable> table = find_table(file);
  if (!table) return std::nullopt;
  Grouped result{.times = table->times(), .numbers = table->read(), .width = table->columns().size()};
  std::map<std::string, std::size_t> known;
  for (std::size_t c = 0; c < result.width; ++c) {
    const std::string& column = table->columns()[c];
    const std::size_t dot = column.rfind('.');
    const std::string owner = dot == std::string::npos ? "" : column.substr(0, dot);
    const auto [group, is_new] = known.try_emplace(owner, result.groups.size());
    if (is_new) result.groups.push_back({owner, {}});
    result.groups[group->second].columns.push_back({dot == std::string::npos ? column : column.substr(dot + 1), c});
  }
  return result;
}

/// The lists of a joint's numbers: the member's name, and which columns belong to it.
constexpr std::pair<const char*, std::string_view> joint_members[] = {
    {"q", "q"}, {"v", "v"}, {"p", "p"}, {"force", "f"}, {"torque", "m"}};

/// A message with its time, and the members that `write` writes.
template <class Write>
std::string stamped(std::uint64_t time, const Write& write) {
  std::string text;
  JsonWriter json(text);
  json.begin_object();
  foxglove::write_time(json, "timestamp", time);
  write(json);
  json.end_object();
  return text;
}

std::string joints_message(const Grouped& table, std::size_t row, std::uint64_t time) {
  return stamped(time, [&](JsonWriter& json) {
    json.key("joints").begin_array();
    const double* const numbers = table.row(row);
    for (const Grouped::Group& joint : table.groups) {
      const auto there = [numbers](const Grouped::Column& column) { return !std::isnan(numbers[column.at]); };
      if (!std::any_of(joint.columns.begin(), joint.columns.end(), there)) continue;  // it does not exist now
      json.begin_object().member("name", joint.owner);
      for (const auto& [member, first] : joint_members) {
        std::vector<double> values;
        for (const Grouped::Column& column : joint.columns)
          if (column.field.starts_with(first) && there(column)) values.push_back(numbers[column.at]);
        if (!values.empty() || first == "q" || first == "v" || first == "p") json.member(member, std::span<const double>(values));
      }
      json.end_object();
    }
    json.end_array();
  });
}

std::string springs_message(const Grouped& table, std::size_t row, std::uint64_t time) {
  return stamped(time, [&](JsonWriter& json) {
    json.key("springs").begin_array();
    for (const Grouped::Group& spring : table.groups) {
      if (std::isnan(table.row(row)[spring.columns.front().at])) continue;  // broken
      json.begin_object().member("name", spring.owner);
      for (const Grouped::Column& column : spring.columns) json.member(column.field, table.row(row)[column.at]);
      json.end_object();
    }
    json.end_array();
  });
}

std::string energy_message(const Grouped& table, std::size_t row, std::uint64_t time) {
  return stamped(time, [&](JsonWriter& json) {
    for (const Grouped::Group& group : table.groups) {
      if (!group.owner.empty()) json.key(group.owner).begin_object();
      for (const Grouped::Column& column : group.columns) json.member(column.field, table.row(row)[column.at]);
      if (!group.owner.empty()) json.end_object();
    }
  });
}

/// A name for the frame of the world that no body has.
std::string world_frame(const Recording& run) {
  std::string name = "world";
  const auto taken = [&](const RecordedBody& body) { return body.name == name; };
  while (std::any_of(run.bodies.begin(), run.bodies.end(), taken)) name += '_';
  return name;
}

class McapBuilder {
 public:
  explicit McapBuilder(const Drawing& drawing)
      : drawing_(drawing),
        world_(world_frame(drawing.run)),
        joints_(grouped(drawing.run.folder / "joints.csv")),
        springs_(grouped(drawing.run.folder / "springs.csv")),
        energy_(grouped(drawing.run.folder / "energy.csv")),
        zero_(std::min(drawing.times.front(), 0.0)) {}

  std::string build() {
    using namespace foxglove;
    tf_ = file_.add_channel("/tf", "foxglove.FrameTransforms", frame_transforms_schema());
    scene_ = file_.add_channel("/scene", "foxglove.SceneUpdate", scene_update_schema());
    const std::size_t own = file_.add_channel("/scene/own_colours", "foxglove.SceneUpdate", scene_update_schema());
    bars_ = file_.add_channel("/scene/bars", "foxglove.SceneUpdate", scene_update_schema());
    events_ = file_.add_channel("/events", "foxglove.Log", log_schema());
    const std::size_t joints = file_.add_channel("/joints", "momentree.JointStates", joint_states_schema());
    const std::size_t springs = file_.add_channel("/springs", "momentree.SpringStates", spring_states_schema());
    const std::size_t energy = file_.add_channel("/energy", "momentree.Energy", energy_schema());

    const std::uint64_t start = nanoseconds(drawing_.times.front());
    add(own, start, scene(drawing_, Solids::own_colours, drawing_.colourings.front(), start));
    const auto add_row = [&](std::size_t channel, const std::optional<Grouped>& table, std::size_t row, const auto& message) {
      if (!table || row >= table->times.size()) return;
      const std::uint64_t time = nanoseconds(table->times[row]);
      file_.add_message(channel, time, message(*table, row, time));
    };
    for (std::size_t row = 0; row < drawing_.times.size(); ++row) {
      add_changes(drawing_.times[row]);
      const std::uint64_t time = nanoseconds(drawing_.times[row]);
      file_.add_message(tf_, time, frame_transforms(drawing_, row, time, world_));
      if (!drawing_.bars.empty()) file_.add_message(bars_, time, bars(drawing_, row, time, world_));
      add_row(joints, joints_, row, joints_message);
      add_row(springs, springs_, row, springs_message);
      add_row(energy, energy_, row, energy_message);
    }
    add_changes(HUGE_VAL);
    if (!drawing_.status.empty() && drawing_.status != "done") {
      const std::vector<RecordedEvent>& events = drawing_.run.events;
      const std::uint64_t end = nanoseconds(std::max(drawing_.times.back(), events.empty() ? -HUGE_VAL : events.back().time));
      file_.add_message(events_, end, log(Level::error, "run", drawing_.status, end));
    }
    return file_.finish(
        "momentree",
        {{"version", MOMENTREE_VERSION}, {"title", drawing_.run.title}, {"status", drawing_.status}, {"world_frame", world_}});
  }

 private:
  std::uint64_t nanoseconds(double time) const {
    return static_cast<std::uint64_t>(std::llround(std::clamp(1e9 * (time - zero_), 0.0, 9e18)));
  }

  void add(std::size_t channel, std::uint64_t time, const std::string& message) {
    if (!message.empty()) file_.add_message(channel, time, message);
  }

  /// Changes of colours, and events, up to that time.
  void add_changes(double until) {
    for (; next_colouring_ < drawing_.colourings.size() && drawing_.colourings[next_colouring_].from <= until;
         ++next_colouring_) {
      const Colouring& colouring = drawing_.colourings[next_colouring_];
      const std::uint64_t time = nanoseconds(std::max(colouring.from, drawing_.times.front()));
      add(scene_, time, foxglove::scene(drawing_, foxglove::Solids::mechanism_colours, colouring, time));
    }
    for (; next_event_ < drawing_.run.events.size() && drawing_.run.events[next_event_].time <= until; ++next_event_) {
      const RecordedEvent& event = drawing_.run.events[next_event_];
      std::string actions;
      for (const std::string& action : event.actions) actions += (actions.empty() ? "" : ", ") + action;
      const std::uint64_t time = nanoseconds(event.time);
      const foxglove::Level level = event.name == "stop" ? foxglove::Level::debug : foxglove::Level::info;
      file_.add_message(events_, time, foxglove::log(level, event.name, actions, time));
    }
  }

  const Drawing& drawing_;
  const std::string world_;
  const std::optional<Grouped> joints_, springs_, energy_;
  const double zero_;
  McapFile file_{"momentree " MOMENTREE_VERSION};
  std::size_t tf_ = 0, scene_ = 0, bars_ = 0, events_ = 0;
  std::size_t next_colouring_ = 0, next_event_ = 0;
};

/// Reads joints.csv, energy.csv and springs.csv, if they exist. Throws Error with the file and the line.
std::string mcap_of(const Drawing& drawing) { return McapBuilder(drawing).build(); }

}  // namespace

Exporter exporters::mcap() {
  return {.ending = ".mcap", .format = "MCAP", .content = "Foxglove", .readers = "Foxglove", .bytes = &mcap_of};
}

}  // namespace momentree::io

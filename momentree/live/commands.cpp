// What the readers of the pages ask for: the messages of web/src/engine/messages.ts.
#include <algorithm>
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/live/view_impl.hpp>
#include <momentree/text/json.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::live {

namespace {

const Value* member(const Value& message, std::string_view key) {
  const Value::Entry* const found = message.find(key);
  return found != nullptr ? &found->value : nullptr;
}

std::string text_of(const Value& message, std::string_view key) {
  const Value* const value = member(message, key);
  return value != nullptr && value->string() != nullptr ? *value->string() : "";
}

std::optional<double> number_of(const Value& message, std::string_view key) {
  const Value* const value = member(message, key);
  const std::optional<double> number = value != nullptr ? value->number() : std::nullopt;
  return number && std::isfinite(*number) ? number : std::nullopt;
}

/// A number of a joint or body; −2: there is none.
int index_of(const Value& message, std::string_view key) {
  const std::optional<double> number = number_of(message, key);
  return number && std::fabs(*number) < 2e9 ? static_cast<int>(*number) : -2;
}

std::optional<Vec3> vector_of(const Value& message, std::string_view key) {
  const Value* const value = member(message, key);
  const Value::Array* const items = value != nullptr ? value->array() : nullptr;
  if (items == nullptr || items->size() != 3) return std::nullopt;
  double all[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<double> number = (*items)[i].number();
    if (!number || !std::isfinite(*number)) return std::nullopt;
    all[i] = *number;
  }
  return Vec3{all[0], all[1], all[2]};
}

std::string status_json(std::string_view type, std::string_view message) {
  std::string text;
  io::JsonWriter(text).begin_object().member("type", type).member("message", message).end_object();
  return text;
}

}  // namespace

void View::Impl::refuse(const std::string& why) { feed.post(status_json("refused", why)); }

void View::Impl::apply(const std::vector<Action>& actions) {
  if (actions.empty()) return;
  const RunResult result = simulation.try_apply(actions);
  if (result == Status::refused) refuse(result.reason);
}

void View::Impl::act(const Value& action) {
  const std::string what = text_of(action, "action");
  const World& world = simulation.world();
  if (what == "weld") {
    const auto body = io::body_name(world, index_of(action, "body")), to = io::body_name(world, index_of(action, "to"), true);
    return body && to ? apply({weld(*body, *to)}) : refuse("one of the bodies is no longer there");
  }
  const std::optional<std::string> joint = io::joint_name(world, index_of(action, "joint"));
  if (!joint) return refuse("the joint no longer exists");
  if (what == "break") return apply({break_joint(*joint)});
  if (what == "free") return apply({free_joint(*joint)});
  if (what == "lock") return apply({lock(*joint)});
  if (what == "unlock") return apply({unlock(*joint)});
  refuse("there is no action '" + what + "'");
}

void View::Impl::set_joint(const Value& message) {
  const std::optional<std::string> joint = io::joint_name(simulation.world(), index_of(message, "joint"));
  if (!joint) return refuse("the joint no longer exists");
  JointParameters all;
  if (const auto damping = number_of(message, "damping")) all.damping = *damping;
  if (const auto stiffness = number_of(message, "stiffness")) all.stiffness = *stiffness;
  apply({set_parameters(*joint, all)});
}

bool View::Impl::has_grip() const {
  if (grip.body < 0 || !simulation.world().alive({grip.body})) return false;
  const auto& loaded = simulation.world().tree().loads().functions;
  return std::ranges::any_of(
      loaded, [this](const Topology::Loaded& each) { return each.body == grip.body && each.function == grip_function; });
}

void View::Impl::apply_grip() {
  simulation.force(simulation.world().model()[{grip.body}].name,
                   [grip = grip](const EvaluationContext& context) { return io::pull(grip, context); });
  for (const Topology::Loaded& each : simulation.world().tree().loads().functions)
    if (each.body == grip.body) grip_function = each.function;
}

void View::Impl::grab(const Value& message) {
  release();
  const World& world = simulation.world();
  const int body = index_of(message, "body");
  const std::optional<Vec3> point = vector_of(message, "point"), target = vector_of(message, "target");
  if (!io::body_name(world, body) || !point || !target) return refuse("the body is no longer there");
  const auto& loaded = world.tree().loads().functions;
  if (std::ranges::any_of(loaded, [body](const Topology::Loaded& each) { return each.body == body; }))
    return refuse("the program applies a force to this body, which a grip would replace");
  grip = io::grip_on(world, body, *point, 1);
  grip.target = *target;
  apply_grip();
}

void View::Impl::pull(const Value& message) {
  const std::optional<Vec3> target = vector_of(message, "target");
  if (grip.body < 0 || !target) return;
  if (!has_grip()) {
    grip = {};
    return refuse("the program now applies a force to this body, which has replaced the grip");
  }
  grip.target = *target;
  apply_grip();
}

void View::Impl::release() {
  if (has_grip()) simulation.force(simulation.world().model()[{grip.body}].name, {});
  grip = {};
}

void View::Impl::move_slider(const Value& message) {
  const auto found = std::ranges::find(sliders, text_of(message, "name"), &Slider::name);
  const std::optional<double> value = number_of(message, "value");
  if (found == sliders.end() || !value) return;
  const double now = found->value = std::clamp(*value, found->least, found->most);
  known.sliders_moved = true;
  if (const std::function<void(double)> function = found->changed) function(now);  // which may add sliders
}

void View::Impl::obey(const std::string& text) {
  std::optional<Value> message;
  try {
    message = io::parse_json(text, "page");
    carry_out(*message);
  } catch (const Error& error) {  // of a text that no page of this project sends, or of an impossible change
    refuse(error.what());
  }
}

void View::Impl::carry_out(const Value& message) {
  const std::string type = text_of(message, "type");
  const Value* const on = member(message, "on");
  if (type == "play" && on != nullptr && on->boolean() != nullptr) {
    playing = *on->boolean();
    pace.due = 0;
  } else if (type == "speed") {
    if (const auto factor = number_of(message, "factor"); factor && *factor > 0 && *factor <= 1000) pace.speed = *factor;
  } else if (type == "act") {
    if (const Value* const action = member(message, "action")) act(*action);
  } else if (type == "set") {
    set_joint(message);
  } else if (type == "gravity") {
    if (const auto value = vector_of(message, "value")) simulation.set_gravity(*value);
  } else if (type == "damping") {
    const auto factor = number_of(message, "factor"), offset = number_of(message, "offset");
    if (factor && offset) apply(io::scaled_damping(simulation.world(), simulation.world().model(), *factor, *offset));
  } else if (type == "grab") {
    grab(message);
  } else if (type == "pull") {
    pull(message);
  } else if (type == "release") {
    release();
  } else if (type == "slider") {
    move_slider(message);
  } else if (type == "stop") {
    stopped = true;
    playing = false;
    feed.post(status_json("stopped", "The run was stopped from this page"));
  }
}

}  // namespace momentree::live

#include <momentree/pages/page_session.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/text/json_writer.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

constexpr double snapshot_interval = 0.25;  // s of simulated time
constexpr double frames_per_second = 60;    // of simulated time
constexpr double budget = 0.012;            // the part of the page's frame time that the engine may use (s)
constexpr double patience = 4;              // a world that needs more for a thousandth of a frame makes no progress (s)

}  // namespace

bool Pace::obey(Message& message) {
  static constexpr MessageHandler<Pace> handlers[] = {{"play",
                                                       [](Pace& pace, Message& m) {
                                                         if (const bool on = m.flag("on"); m.ok())
                                                           pace.playing = on, pace.due = 0;
                                                       }},
                                                      {"speed", [](Pace& pace, Message& m) {
                                                         const double factor = m.number("factor");
                                                         if (!(factor > 0 && factor <= 1000))
                                                           m.refuse("a speed is a factor above 0, of 1000 at most");
                                                         if (m.ok()) pace.speed = factor;
                                                       }}};
  return carry_out(message, *this, handlers);
}

PageSession::PageSession(PageHost host) : PageSession(host, std::make_unique<PageRun>(host)) {}

void PageSession::obey(Message& message) {
  static constexpr MessageHandler<PageSession> handlers[] = {{"load", [](PageSession& to, Message& m) { to.load(m); }},
                                                             {"check",
                                                              [](PageSession& to, Message& m) {
                                                                if (const std::string text = m.text("text"); m.ok())
                                                                  to.host_.post(checked_json(text), {});
                                                              }},
                                                             {"rewind", [](PageSession& to, Message& m) { to.rewind(m); }},
                                                             {"undo", [](PageSession& to, Message& m) { to.undo(m); }},
                                                             {"branch", [](PageSession& to, Message& m) { to.resume(m); }}};
  const std::string& type = message.type();
  bool changes = false;
  if (pace_.obey(message)) {
    // of every world, even without a scenario
  } else if (!now_.run->loaded() && type != "load" && type != "check") {
    message.refuse("load a scenario first");
  } else if (!carry_out(message, *this, handlers)) {
    changes = type != "pull" && type != "release";
    if (changes) take_snapshot();
    if (!now_.run->controls().obey(message)) message.refuse("there is no message '" + type + "' for this world");
  }
  if (!message.ok()) host_.post(report_json("refused", message.refusal()), {});
  if (changes) report(0);
}

void PageSession::tick(double seconds) {
  if (!pace_.playing || !now_.run->loaded()) return;
  // Computation that was not finished in time is not caught up on: the simulation is slower then.
  double& due = pace_.due;
  due = std::min(due + seconds * pace_.speed, 2 / frames_per_second);
  const double frame = std::min(1.0, pace_.speed) / frames_per_second;
  if (due < 0.999 * frame) return;
  const double began = host_.clock(), from = simulation().time(), step = simulation().integration().step;
  // Stops at whole steps, so that the run is the same as without a page.
  const double target = std::max(std::floor((from + due) / step + 1e-6), std::floor(from / step + 1e-6) + 1) * step;
  const RunResult result = now_.run->run(target, budget);
  due = result == Status::interrupted ? 0 : std::max(0.0, due - (simulation().time() - from));
  const double used = host_.clock() - began, time = simulation().time();
  report(used);
  if (!result && result != Status::interrupted) return stop(result.reason);
  stuck_ += used;
  if (time < progress_ || time > progress_ + 1e-3 * frame) progress_ = time, stuck_ = 0;
  if (stuck_ <= patience) return;
  stuck_ = 0;
  stop("No progress at t = " + rounded_text(time, 6) + " s: too much happens at once. Go back, or restart.");
}

void PageSession::load(Message& message) {
  const std::string text = message.text("text");
  const bool floor = message.flag("floor", false);
  auto fresh = std::make_unique<PageRun>(host_);
  if (!message.ok() || !fresh->load(text, floor)) return;
  now_ = {std::move(fresh)};
  branches_.clear();
  pace_.due = 0;
  known_.read(simulation());
  take_snapshot();
}

void PageSession::take_snapshot() {
  now_.snapshots.push_back({simulation().time(), std::make_shared<const SimulationSnapshot>(simulation().snapshot())});
}

void PageSession::report(double seconds) {
  std::string lines;
  known_.tell(
      simulation(), [this](const std::string& text) { host_.post(text, {}); }, lines);
  now_.run->post_frame(seconds);
  const double time = simulation().time();
  if (now_.times.empty() || time > now_.times.back()) now_.times.push_back(time);
  if (time >= now_.snapshots.back().time + snapshot_interval) take_snapshot();
}

void PageSession::stop(const std::string& message) {
  pace_.playing = false;
  host_.post(message_json("playing", "on", "false"), {});
  host_.post(report_json("stopped", message), {});
}

const SimulationSnapshot& PageSession::snapshot_before(double time, bool strictly) const {
  const auto& all = now_.snapshots;
  const auto later = [&](const TimedSnapshot& each) { return strictly ? each.time >= time : each.time > time; };
  const auto first_later = std::find_if(all.begin(), all.end(), later);
  return first_later == all.begin() ? *all.front().snapshot : *std::prev(first_later)->snapshot;
}

std::size_t PageSession::keep_branch() {
  branches_.push_back({now_.run->branch(), now_.snapshots, now_.times});
  return branches_.size() - 1;
}

void PageSession::report_jump(std::string_view type, const char* key, std::size_t number, std::size_t saved_as) {
  pace_.due = 0;
  known_.events = simulation().events().size();
  std::string text;
  JsonWriter json(text);
  json.begin_object().member("type", type).member("time", simulation().time()).member(key, static_cast<long>(number));
  json.member("savedAs", static_cast<long>(saved_as)).end_object();
  host_.post(text, {});
  report(0);
}

void PageSession::rewound(std::size_t saved_as) {
  const double time = simulation().time();
  std::erase_if(now_.snapshots, [time](const TimedSnapshot& each) { return each.time > time; });
  std::erase_if(now_.times, [time](double each) { return each > time; });
  if (now_.snapshots.empty()) take_snapshot();
  report_jump("rewound", "events", simulation().events().size(), saved_as);
}

void PageSession::rewind(Message& message) {
  const double time = message.number("time");
  if (!message.ok() || time >= simulation().time()) return;
  const std::size_t saved_as = keep_branch();
  now_.run->restore(snapshot_before(time, false));
  for (const double each : now_.times)
    if (each > simulation().time() && each <= time) (void)now_.run->run(each, HUGE_VAL);
  rewound(saved_as);
}

void PageSession::undo(Message& message) {
  const int event = message.index("event");
  const auto number = static_cast<std::size_t>(event);
  if (number >= simulation().events().size()) message.refuse("there is no event " + std::to_string(event));
  if (!message.ok()) return;
  const double time = simulation().events()[number].time;
  const std::size_t saved_as = keep_branch();
  if (!now_.run->undo(event)) now_.run->restore(snapshot_before(time, true));
  rewound(saved_as);
}

void PageSession::resume(Message& message) {
  const auto number = static_cast<std::size_t>(message.index("branch"));
  if (number >= branches_.size() || branches_[number].run == nullptr)
    message.refuse("there is no branch " + std::to_string(number));
  if (!message.ok()) return;
  branches_.push_back(std::exchange(now_, std::move(branches_[number])));
  report_jump("resumed", "branch", number, branches_.size() - 1);
}

}  // namespace momentree::io

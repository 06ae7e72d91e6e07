#include <momentree/live/view.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/live/page.hpp>
#include <momentree/live/page_server.hpp>
#include <momentree/live/view_impl.hpp>
#include <momentree/models/mesh/pack.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/report/page.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::live {

namespace {

std::string playing_json(bool on) { return io::message_json("playing", "on", on ? "true" : "false"); }

std::string gravity_json(const Vec3& gravity) {
  std::string text;
  io::JsonWriter(text).begin_object().member("type", "gravity").member("value", gravity).end_object();
  return text;
}

}  // namespace

View::Impl::Impl(Simulation& simulation_, ViewOptions options_, const io::Scenario* given)
    : simulation(simulation_), options(std::move(options_)), controls(simulation) {
  pace.playing = !options.paused, pace.speed = options.speed;
  if (!(pace.speed > 0) || !std::isfinite(pace.speed))
    throw_error({"the speed of a view must be positive and finite", "speed", "1 is real time"});
  scenario.title = options.title, scenario.until = HUGE_VAL, scenario.integration = simulation.integration();
  if (given != nullptr) {
    if (options.title.empty()) options.title = given->title;
    if (options.shapes.empty()) options.shapes = given->shapes;
    scenario.title = options.title, scenario.until = given->until, scenario.output_every = given->output_every;
    scenario.events = given->events;
    thresholds = io::thresholds_of(*given, simulation.world());
  }
  step = is_adaptive(simulation.integration().method) ? 0 : simulation.integration().step;
  Listener listener = listen_on(options.port);
  const io::PackedMeshes meshes = io::pack_meshes(io::mesh_sources(options.shapes));
  for (const io::Diagnostic& each : meshes.warnings) warnings.push_back(each.what);
  reload();
  serve(std::move(listener), meshes.json);
}

void View::Impl::close() {
  ending = true;
  if (server.joinable()) server.join();
  controls.release();
}

void View::Impl::serve(Listener listener, const std::string& meshes) {
  Site site = site_of(io::live_page(live_html(), meshes), io::content_policy(live_html()), listener.port, &feed);
  address = address_of(site);
  if (options.open_browser) open_in_browser(site);
  server = std::thread([this, listener = std::move(listener), site = std::move(site)]() mutable {
    PageServer(std::move(listener), std::move(site)).run([this] { return ending.load(); });
  });
}

std::string View::Impl::sliders_json() const {
  std::string text;
  io::JsonWriter json(text);
  json.begin_object().member("type", "sliders").key("sliders").begin_array();
  for (const Slider& each : sliders)
    json.begin_object()
        .member("name", each.name)
        .member("least", each.least)
        .member("most", each.most)
        .member("value", each.value)
        .member("unit", each.unit)
        .end_object();
  json.end_array().end_object();
  return text;
}

std::vector<std::string> View::Impl::greeting() const {
  return {
      io::loaded_json("[]", io::scenario_json(scenario, known.gravity), known.model_text, known.world.topology, known.frame_text),
      io::message_json("events", "events", "[" + known.events_text + "]"), sliders_json(), playing_json(pace.playing)};
}

void View::Impl::reload() {
  const World& world = simulation.world();
  known.model_text = io::model_json(world, options.title, options.shapes);
  known.world.read(simulation);
  known.events_text = io::event_list(simulation.events(), 0);
  known.frame_text = io::frame_json(io::frame_of(simulation, thresholds), true);
  known.bodies = world.model().size();
  known.time = simulation.time();
  known.gravity = world.model().gravity();
  known.playing = pace.playing, known.sliders_moved = false;
  feed.greet(greeting(), true);
}

void View::Impl::tell_frame(bool now) {
  if (!now && simulation.time() == known.time && Clock::now() - pace.framed < frame_time) return;
  pace.framed = Clock::now();
  known.time = simulation.time();
  std::string text = io::frame_json(io::frame_of(simulation, thresholds), true);
  if (text == known.frame_text) return;
  known.frame_text = std::move(text);
  std::string shown;
  io::JsonWriter(shown)
      .begin_object()
      .member("type", "frame")
      .member("seconds", std::exchange(pace.spent, 0))
      .key("frame")
      .raw(known.frame_text)
      .end_object();
  feed.show(std::move(shown));
}

void View::Impl::tell() {
  const World& world = simulation.world();
  pace.told = Clock::now();
  // Bodies that were added, and a run that went back, are a new world for the pages.
  if (world.model().size() != known.bodies || simulation.events().size() < known.world.events || simulation.time() < known.time)
    return reload();
  std::string lines;
  bool news = known.world.tell(
      simulation, [this](const std::string& text) { feed.post(text); }, lines);
  if (!lines.empty()) known.events_text += (known.events_text.empty() ? "" : ",") + lines;
  if (!(world.model().gravity() == known.gravity)) {
    known.gravity = world.model().gravity();
    feed.post(gravity_json(known.gravity));
    news = true;
  }
  if (std::exchange(known.sliders_moved, false)) feed.post(sliders_json()), news = true;
  if (pace.playing != known.playing) feed.post(playing_json(known.playing = pace.playing)), news = true;
  tell_frame(news);
  if (news) feed.greet(greeting(), false);
}

View::View(Simulation& simulation, ViewOptions options)
    : impl_(std::make_unique<Impl>(simulation, std::move(options), nullptr)) {}
View::View(Simulation& simulation, const io::Scenario& scenario, ViewOptions options)
    : impl_(std::make_unique<Impl>(simulation, std::move(options), &scenario)) {}
View::~View() = default;

const std::string& View::address() const { return impl_->address; }
const std::vector<std::string>& View::warnings() const { return impl_->warnings; }
bool View::playing() const { return impl_->pace.playing; }
bool View::stopped() const { return impl_->stopped; }
void View::close() { impl_->close(); }
void View::abandon() {
  impl_->controls.forget();
  impl_->close();
}
int View::pages() const { return impl_->feed.pages(); }
void View::wait(std::chrono::nanoseconds most) { impl_->feed.wait(most); }

void View::slider(Slider slider) {
  const auto same = [&slider](const Slider& each) { return each.name == slider.name; };
  if (std::ranges::any_of(impl_->sliders, same))
    throw_error({"there is a slider '" + slider.name + "' already", "slider", "give each slider a name of its own"});
  const bool finite = std::isfinite(slider.least) && std::isfinite(slider.most);
  if (!finite || !(slider.least < slider.most) || !(slider.least <= slider.value && slider.value <= slider.most))
    throw_error(
        {"the numbers of the slider '" + slider.name + "' are not in order", "slider", "least <= value <= most, all finite"});
  impl_->sliders.push_back(std::move(slider));
  impl_->known.sliders_moved = true;
  impl_->tell();
}

double View::value(const std::string& slider) const {
  const auto found = std::ranges::find(impl_->sliders, slider, &Slider::name);
  if (found == impl_->sliders.end()) throw_error({"there is no slider '" + slider + "'", "slider", "add it with slider()"});
  return found->value;
}

void View::exchange() {
  for (const std::string& text : impl_->feed.take()) impl_->obey(text);
  impl_->tell();
}

bool View::update() {
  Impl& view = *impl_;
  for (;;) {
    if (!view.pace.playing || view.feed.has_texts() || Impl::Clock::now() - view.pace.told >= Impl::frame_time) exchange();
    if (view.pace.playing || view.stopped) break;
    wait(std::chrono::milliseconds(100));
  }
  view.pace.paced = Impl::Clock::now();
  return !view.stopped;
}

double View::next(double until) {
  Impl& view = *impl_;
  const double now = view.simulation.time();
  const Impl::Clock::time_point clock = Impl::Clock::now();
  const double passed = std::chrono::duration<double>(clock - std::exchange(view.pace.paced, clock)).count();
  // Steps that took longer than they should are not caught up on: the simulation is slower then.
  view.pace.due = std::min(view.pace.due + passed * view.pace.speed, 2 * view.pace.speed * Impl::frame_time.count());
  if (view.pace.due < 0.999 * std::min(1.0, view.pace.speed) * Impl::frame_time.count()) return now;
  const double least = view.step > 0 ? view.step * std::max(1.0, std::floor(view.pace.due / view.step + 1e-6)) : view.pace.due;
  const double target = std::min(now + least, until);
  view.pace.due -= target - now;  // negative after a step that is longer than a frame: the next one waits
  return target;
}

void View::report(const RunResult& result) {
  Impl& view = *impl_;
  view.pace.spent += std::chrono::duration<double>(Impl::Clock::now() - view.pace.paced).count();  // next() has set it
  if (result || result == Status::interrupted) return;
  view.pace.playing = false;
  view.tell();
  view.feed.post(io::report_json("stopped", result.reason));
}

RunResult View::run_until(double time, const std::function<bool()>& goes_on) {
  Impl& view = *impl_;
  view.pace.paced = Impl::Clock::now();
  view.pace.due = 0;
  while (view.simulation.time() < time) {
    exchange();
    if (view.stopped || (goes_on && !goes_on())) return {Status::interrupted, ""};
    if (!view.pace.playing) {
      wait(std::chrono::milliseconds(100));
      view.pace.paced = Impl::Clock::now();
      continue;
    }
    const double target = next(time);
    if (target <= view.simulation.time()) {
      wait(std::chrono::milliseconds(4));
      continue;
    }
    const RunResult result = view.simulation.run_until(target);
    report(result);
    if (!result) return result;
  }
  exchange();
  return {};
}

}  // namespace momentree::live

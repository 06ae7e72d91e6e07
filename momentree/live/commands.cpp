// What the readers of the pages ask for.
#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/live/view_impl.hpp>

namespace momentree::live {

void View::Impl::obey(const std::string& text) {
  static constexpr io::MessageHandler<Impl> handlers[] = {{"slider", [](Impl& view, io::Message& m) { view.move_slider(m); }},
                                                          {"stop", [](Impl& view, io::Message&) { view.stop(); }}};
  std::string refusal;
  try {
    io::Message message(text);
    if (!pace.obey(message) && !io::carry_out(message, *this, handlers) && !controls.obey(message))
      message.refuse("a program's simulation has no message '" + message.type() + "'");
    refusal = message.refusal();
  } catch (const Error& error) {  // of a text that no page of this project sends, or of an impossible change
    refusal = error.what();
  }
  if (!refusal.empty()) feed.post(io::report_json("refused", refusal));
}

void View::Impl::move_slider(io::Message& message) {
  const auto found = std::ranges::find(sliders, message.text("name"), &Slider::name);
  const double value = message.number("value");
  if (found == sliders.end()) message.refuse("there is no such slider");
  if (!message.ok()) return;
  const double now = found->value = std::clamp(value, found->least, found->most);
  known.sliders_moved = true;
  if (const std::function<void(double)> function = found->changed) function(now);  // which may add sliders
}

void View::Impl::stop() {
  stopped = true;
  pace.playing = false;
  feed.post(io::report_json("stopped", "The run was stopped from this page"));
}

}  // namespace momentree::live

#include <momentree/export/picture/svg.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/export/picture/annotations.hpp>
#include <momentree/export/picture/frame_svg.hpp>
#include <momentree/export/picture/labels.hpp>
#include <momentree/export/picture/scene.hpp>
#include <momentree/export/picture/svg_text.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {
namespace {

constexpr double width = 960, margin = 32, tallest = 680, around = 30;  // px; `around`: space for labels around the motion

/// Early frames are pale, the last one is opaque; if shapes cover one another, the early ones are only a trace.
double opacity(const Scene& scene, std::size_t k) {
  if (scene.frames.size() < 2) return 1;
  const double t = static_cast<double>(k) / static_cast<double>(scene.frames.size() - 1);
  return scene.has_areas ? 0.12 + 0.88 * t * t : 0.25 + 0.75 * t;
}

/// Scales metres to pixels so that `bounds` fills `room`, centred; a motion without extent gets a scale, too.
Placement fit(const Box2& bounds, const Rect& room) {
  const double least = 1e-9;
  const double scale = std::min(room.width / std::max(bounds.width(), least), room.height / std::max(bounds.height(), least));
  const double s = std::min(scale, 1e7);
  return {s,
          {room.x + 0.5 * room.width - 0.5 * s * (bounds.low.x + bounds.high.x),
           room.y + 0.5 * room.height - 0.5 * s * (bounds.low.y + bounds.high.y)}};
}

void append_label(std::string& svg, const std::string& text, const Rect& box, const Point2& anchor) {
  const Point2 middle{box.x + 0.5 * box.width, box.y + 0.5 * box.height};
  if (std::hypot(middle.x - anchor.x, middle.y - anchor.y) > 26) {
    const Point2 near{std::clamp(anchor.x, box.x, box.x + box.width), std::clamp(anchor.y, box.y, box.y + box.height)};
    svg += "<path d=\"M" + pixels(anchor) + "L" + pixels(near) + "\" stroke=\"#8a94a3\" stroke-width=\"0.8\"/>\n";
  }
  svg += svg_words(text, {middle.x, box.y + box.height - 3}, {.size = 12, .anchor = "middle", .halo = true});
}

/// The times of the frames next to the far ends of the mechanisms, if there is space.
void append_time_labels(std::string& svg, const Scene& scene, double every, const Placement& place, const Rect& picture) {
  LabelPlacer placer(picture);
  for (const SceneFrame& frame : scene.frames)
    for (const Primitive& p : frame.primitives)
      for (std::size_t i = 0; i + 1 < p.points.size(); ++i) placer.add_line(place(p.points[i]), place(p.points[i + 1]));
  for (const Point2& anchor : scene.anchors) placer.add_box({place(anchor).x - 7, place(anchor).y - 7, 14, 14});
  std::vector<Point2> labelled;
  for (std::size_t k = scene.frames.size(); k-- > 0;) {  // the last ones first: they are the most interesting
    const SceneFrame& frame = scene.frames[k];
    const std::string text = frame_time(frame.time, every) + (k + 1 == scene.frames.size() ? " s" : "");
    for (std::size_t m = 0; m < frame.ends.size() && m < 4; ++m) {
      const Point2 end = place(frame.ends[m]), root = place(frame.roots[m]);
      const auto near = [&](const Point2& p) { return std::hypot(p.x - end.x, p.y - end.y) < 16; };
      if (std::any_of(labelled.begin(), labelled.end(), near)) continue;  // it hardly moves: one label is enough
      const auto box = placer.place(end, {end.x - root.x, end.y - root.y}, text_width(text, 12), 14);
      if (!box) continue;
      append_label(svg, text, *box, end);
      labelled.push_back(end);
    }
  }
}

void append_marks(std::string& svg, const Scene& scene, const Placement& place) {
  for (const Point2& anchor : scene.anchors)
    svg += "<circle cx=\"" + pixels(place(anchor).x) + "\" cy=\"" + pixels(place(anchor).y) +
           "\" r=\"5\" fill=\"#1b2430\" stroke=\"#fff\" stroke-width=\"1.5\"/>\n";
  for (const SceneEvent& event : scene.events)
    for (const Point2& at : event.places) svg += event_mark(place(at));
}

/// All frames in one picture; returns its height.
double append_overlay(std::string& svg, const Scene& scene, double every, double top, Placement& place) {
  const double room = width - 2 * margin - 2 * around;
  const double ratio = scene.bounds.height() / std::max(scene.bounds.width(), 1e-9);
  const double height = std::clamp(ratio * room, 160.0, tallest) + 2 * around;
  place = fit(scene.bounds, {margin + around, top + around, room, height - 2 * around});
  const double thick = link_width(scene, place.scale);
  append_ground(svg, scene, place);
  for (std::size_t k = 0; k < scene.frames.size(); ++k) append_frame(svg, scene.frames[k], place, thick, opacity(scene, k));
  append_marks(svg, scene, place);
  append_time_labels(svg, scene, every, place, {margin, top, width - 2 * margin, height});
  return height;
}

/// One small picture per frame, all at the same scale.
double append_multiples(std::string& svg, const Scene& scene, double every, double top, Placement& place) {
  const double ratio = std::max(scene.bounds.height(), 1e-9) / std::max(scene.bounds.width(), 1e-9);
  const int columns = std::clamp(static_cast<int>(scene.frames.size()), 1, ratio < 0.7 ? 4 : 5);
  const double cell = (width - 2 * margin) / columns, tall = std::clamp(ratio * (cell - 20), 90.0, 260.0) + 30;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    const int column = static_cast<int>(k) % columns, row = static_cast<int>(k) / columns;
    const Rect box{margin + column * cell, top + row * tall, cell, tall};
    place = fit(scene.bounds, {box.x + 10, box.y + 24, cell - 20, tall - 30});
    svg += "<rect x=\"" + pixels(box.x + 2) + "\" y=\"" + pixels(box.y + 2) + "\" width=\"" + pixels(cell - 4) + "\" height=\"" +
           pixels(tall - 4) + "\" rx=\"4\" stroke=\"#e3e7ec\"/>\n";
    append_ground(svg, scene, place);
    append_frame(svg, scene.frames[k], place, std::min(link_width(scene, place.scale), 4.0), 1);
    for (const Point2& anchor : scene.anchors)
      svg += "<circle cx=\"" + pixels(place(anchor).x) + "\" cy=\"" + pixels(place(anchor).y) + "\" r=\"3\" fill=\"#1b2430\"/>\n";
    svg += svg_words(frame_time(scene.frames[k].time, every) + " s", {box.x + 10, box.y + 18}, {.size = 12});
  }
  return tall * ((static_cast<int>(scene.frames.size()) + columns - 1) / columns) + 12;
}

}  // namespace

std::string draw_svg(const Recording& run, const PictureOptions& options) {
  const View view = options.look ? view_along(*options.look, run.gravity) : choose_view(drawn_points(run), run.gravity);
  const Scene scene = build_scene(run, view);
  const bool overlay = options.layout == PictureOptions::Layout::overlay;
  std::string body;
  const double top = append_header(body, run, scene, overlay, {width, margin}) + 8;
  Placement place;
  const double bottom =
      top + (overlay ? append_overlay(body, scene, run.every, top, place) : append_multiples(body, scene, run.every, top, place));
  append_axes(body, view, {margin + 28, bottom + 34});
  append_scale_bar(body, place.scale, {width - margin, bottom + 40});
  const std::string size = pixels(width) + " " + pixels(bottom + 64);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + size + "\" width=\"" + pixels(width) + "\" height=\"" +
         pixels(bottom + 64) +
         "\" role=\"img\" font-family=\"system-ui, 'Segoe UI', Helvetica, Arial, sans-serif\" fill=\"none\" " +
         "stroke-linecap=\"round\" stroke-linejoin=\"round\">\n<title>" + xml_escaped(run.title) + "</title>\n<desc>" +
         xml_escaped(description(run)) + "</desc>\n<rect x=\"0.5\" y=\"0.5\" width=\"" + pixels(width - 1) + "\" height=\"" +
         pixels(bottom + 63) + "\" rx=\"10\" fill=\"#fff\" stroke=\"#d8dde3\"/>\n" + body + "</svg>\n";
}

void write_svg(const std::filesystem::path& directory, const std::filesystem::path& file, const PictureOptions& options) {
  write_text_file(file.string(), draw_svg(read_recording(directory, options.every), options));
}

}  // namespace momentree::io

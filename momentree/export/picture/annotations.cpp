#include <momentree/export/picture/annotations.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/export/picture/svg_text.hpp>

namespace momentree::io {
namespace {

constexpr const char* strong = "#1b2430";
constexpr const char* pale = "#66707d";
constexpr std::size_t most_named = 8;

std::string circle(const Point2& at, double radius, const std::string& attributes) {
  return "<circle cx=\"" + pixels(at.x) + "\" cy=\"" + pixels(at.y) + "\" r=\"" + pixels(radius) + "\" " + attributes + "/>\n";
}

/// Items side by side, in as many rows as needed.
class Row {
 public:
  Row(const Page& page, double y) : page_(page), x_(page.margin), y_(y) {}
  Point2 take(double needed) {
    if (x_ > page_.margin && x_ + needed > page_.width - page_.margin) x_ = page_.margin, y_ += 22;
    const Point2 here{x_, y_};
    x_ += needed;
    return here;
  }
  double bottom() const { return y_; }

 private:
  const Page& page_;
  double x_, y_;
};

std::string shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = most - 1;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a character
  return text.substr(0, end) + "…";
}

/// The time at which a mechanism appeared; 0 for those of the start.
double appeared(const Recording& run, int mechanism) {
  for (const Phase& phase : run.phases)
    if (std::find(phase.mechanism.begin(), phase.mechanism.end(), mechanism) != phase.mechanism.end()) return phase.from;
  return 0;
}

void append_mechanisms(std::string& svg, const Recording& run, Row& row) {
  for (std::size_t m = 0; m < std::min(run.mechanisms.size(), most_named); ++m) {
    const double since = appeared(run, static_cast<int>(m));
    const std::string text = shortened(run.mechanisms[m], 40) + (since > 0 ? ", from " + plain_number(since) + " s" : "");
    const Point2 at = row.take(44 + text_width(text, 13));
    svg += "<path d=\"M" + pixels(at.x + 2) + " " + pixels(at.y - 4) + "h16\" stroke=\"" + mechanism_colour(m) +
           "\" stroke-width=\"5\"/>\n";
    svg += svg_words(text, {at.x + 26, at.y});
  }
  if (run.mechanisms.size() > most_named) {
    const std::string text = "and " + std::to_string(run.mechanisms.size() - most_named) + " more";
    svg += svg_words(text, row.take(18 + text_width(text, 13)), {.colour = pale});
  }
}

void append_events(std::string& svg, const Scene& scene, Row& row) {
  for (std::size_t e = 0; e < std::min(scene.events.size(), most_named); ++e) {
    const std::string text = plain_number(scene.events[e].time) + " s: " + shortened(scene.events[e].text, 70);
    const Point2 at = row.take(44 + text_width(text, 13));
    svg += event_mark({at.x + 10, at.y - 4}) + svg_words(text, {at.x + 26, at.y});
  }
  if (scene.impacts > 0) {
    const std::string text = std::to_string(scene.impacts) + (scene.impacts == 1 ? " impact on a stop" : " impacts on stops");
    svg += svg_words(text, row.take(18 + text_width(text, 13)), {.colour = pale});
  }
  if (scene.contacts > 0) {
    const std::string text = std::to_string(scene.contacts) + (scene.contacts == 1 ? " impact of bodies" : " impacts of bodies");
    svg += svg_words(text, row.take(18 + text_width(text, 13)), {.colour = pale});
  }
  if (scene.events.size() > most_named) {
    const std::string text = "and " + std::to_string(scene.events.size() - most_named) + " more events";
    svg += svg_words(text, row.take(18 + text_width(text, 13)), {.colour = pale});
  }
}

std::string shown_numbers(const Vec3& v) {
  const auto rounded = [](double x) { return plain_number(std::round(x * 100) / 100); };
  return "(" + rounded(v.x) + ", " + rounded(v.y) + ", " + rounded(v.z) + ")";
}

}  // namespace

std::string svg_words(std::string_view text, const Point2& at, const WordStyle& style) {
  return "<text x=\"" + pixels(at.x) + "\" y=\"" + pixels(at.y) + "\" font-size=\"" + pixels(style.size) + "\" fill=\"" +
         style.colour + "\"" +
         (std::string_view(style.anchor) == "start" ? "" : " text-anchor=\"" + std::string(style.anchor) + "\"") +
         (style.bold ? " font-weight=\"600\"" : "") +
         (style.halo ? " stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\"" : "") + ">" + xml_escaped(text) + "</text>\n";
}

std::string event_mark(const Point2& at) {
  const std::string cross = "M" + pixels(Point2{at.x - 4.5, at.y - 4.5}) + "l9 9m0-9l-9 9";
  return "<path d=\"" + cross + "\" stroke=\"#fff\" stroke-width=\"4.5\"/><path d=\"" + cross +
         "\" stroke=\"#c4122f\" stroke-width=\"2\"/>\n";
}

std::string description(const Recording& run) {
  std::string text = run.bodies.size() == 1 ? "1 body, " : std::to_string(run.bodies.size()) + " bodies, ";
  text += run.frames.size() == 1 ? "1 frame" : std::to_string(run.frames.size()) + " frames";
  if (run.frames.size() > 1)
    text += " " + plain_number(run.every) + " s apart, until " + plain_number(run.frames.back().time) + " s";
  return text;
}

double append_header(std::string& svg, const Recording& run, const Scene& scene, bool faded, const Page& page) {
  svg += svg_words(shortened(run.title, 80), {page.margin, 42}, {.size = 20, .colour = strong, .bold = true});
  const char* fading = faded && run.frames.size() > 1 ? "; later ones are stronger" : "";
  svg += svg_words(description(run) + fading + "; seen along " + shown_numbers(scene.view.look), {page.margin, 65},
                   {.colour = pale});
  Row mechanisms(page, 92);
  append_mechanisms(svg, run, mechanisms);
  if (scene.events.empty() && scene.impacts == 0 && scene.contacts == 0) return mechanisms.bottom();
  Row events(page, mechanisms.bottom() + 22);
  append_events(svg, scene, events);
  return events.bottom();
}

void append_axes(std::string& svg, const View& view, const Point2& at) {
  constexpr double length = 26;
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  constexpr const char* names[3] = {"x", "y", "z"};
  for (std::size_t k = 0; k < 3; ++k) {
    const Point2 p = view(axes[k]);
    const double seen = std::hypot(p.x, p.y);
    if (seen < 0.2) {  // it points towards or away from the viewer
      const bool towards = view.depth(axes[k]) < 0;
      svg += circle(at, 4, std::string("fill=\"#fff\" stroke=\"") + pale + "\"");
      svg += towards ? circle(at, 1.3, std::string("fill=\"") + pale + "\"")
                     : std::string("<path d=\"M") + pixels(Point2{at.x - 2.5, at.y - 2.5}) + "l5 5m0-5l-5 5\" stroke=\"" + pale +
                           "\"/>\n";
      svg += svg_words(names[k], {at.x - 13, at.y + 13}, {.size = 12, .colour = pale});
      continue;
    }
    const Point2 head{at.x + length * p.x, at.y + length * p.y}, u{p.x / seen, p.y / seen};
    const Point2 left{head.x - 6 * u.x - 3 * u.y, head.y - 6 * u.y + 3 * u.x},
        right{head.x - 6 * u.x + 3 * u.y, head.y - 6 * u.y - 3 * u.x};
    svg += "<path d=\"M" + pixels(at) + "L" + pixels(head) + "M" + pixels(left) + "L" + pixels(head) + " " + pixels(right) +
           "\" stroke=\"" + pale + "\" stroke-width=\"1.3\"/>\n";
    svg += svg_words(names[k], {head.x + 9 * u.x, head.y + 9 * u.y + 4}, {.size = 12, .colour = pale, .anchor = "middle"});
  }
}

void append_scale_bar(std::string& svg, double scale, const Point2& right) {
  const double wanted = 130 / scale, decade = std::pow(10.0, std::floor(std::log10(wanted)));
  const double length = wanted >= 5 * decade ? 5 * decade : wanted >= 2 * decade ? 2 * decade : decade;
  const bool small = length < 0.9e-2, middling = length<0.9, large = length> 0.9e3;
  const std::string text = small      ? plain_number(length * 1e3) + " mm"
                           : middling ? plain_number(length * 1e2) + " cm"
                           : large    ? plain_number(length * 1e-3) + " km"
                                      : plain_number(length) + " m";
  const double left = right.x - length * scale;
  svg += "<path d=\"M" + pixels(left) + " " + pixels(right.y - 4) + "v8m0-4H" + pixels(right.x) + "m0-4v8\" stroke=\"" + strong +
         "\" stroke-width=\"1.5\"/>\n";
  svg += svg_words(text, {0.5 * (left + right.x), right.y - 8}, {.size = 12, .anchor = "middle"});
}

}  // namespace momentree::io

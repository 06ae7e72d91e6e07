#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include <cli/commands.hpp>
#include <cli/commands/serve.hpp>
#include <cli/exit_codes.hpp>
#include <cli/input.hpp>
#include <cli/interrupt.hpp>
#include <cli/page.hpp>
#include <cli/record.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/export/export.hpp>
#include <momentree/export/picture/svg.hpp>
#include <momentree/live/view.hpp>
#include <momentree/models/import/model_file.hpp>
#include <momentree/results/report/page.hpp>
#include <momentree/results/report/report.hpp>
#include <momentree/results/session.hpp>
#include <momentree/text/files/file_name.hpp>

namespace momentree::cli {

namespace {

namespace fs = std::filesystem;

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// A picture with another ending would be opened by a program that cannot read it.
void require_svg(const std::string& file) {
  const std::string ending = io::small_ending(file);
  if (ending.empty() || ending == ".svg") return;
  throw_error({"'" + ending + "' pictures cannot be drawn, only SVG", file,
               "name a file that ends in .svg, and convert it with another program"});
}

/// Writes a file from a result, or from that of a scenario, which is run for it.
int write_from(const ViewOptions& options, Purpose purpose, const std::function<void(const std::string& folder)>& write) {
  if (is_folder(options.source)) {
    write(options.source);
    return done;
  }
  const std::shared_ptr<const io::Scenario> scenario = load(options.source, {}, notes_of(options.verbose));
  if (!scenario) return bad_input;
  refuse_to_overwrite(options.exported.empty() ? options.svg : options.exported, *scenario);
  const TemporaryFolder folder;
  const Recorded recorded = record(*scenario, folder.result(), purpose);
  if (recorded.code == done) write(recorded.folder);
  return recorded.code;
}

int export_run(const ViewOptions& options) {
  if (!options.svg.empty()) throw_error({"--svg and --export cannot be used together", "", "call the command once for each"});
  io::require_export_name(options.exported);
  return write_from(options, Purpose::report, [&](const std::string& folder) {
    io::export_result(folder, options.exported);
    show(stdout, printable(options.exported) + '\n');
  });
}

int draw(const ViewOptions& options) {
  require_svg(options.svg);
  io::PictureOptions picture;
  picture.every = options.every;
  if (!options.look.empty()) picture.look = io::parse_direction(options.look);
  if (options.layout == "multiples")
    picture.layout = io::PictureOptions::Layout::multiples;
  else if (options.layout != "overlay")
    throw_error({"there is no layout '" + options.layout + "'", "--layout", "one of: overlay, multiples"});
  return write_from(options, Purpose::picture, [&](const std::string& folder) {
    if (options.svg == "-") {
      std::fputs(io::draw_svg(io::read_recording(folder, options.every), picture).c_str(), stdout);
    } else {
      io::write_svg(folder, options.svg, picture);
      show(stdout, printable(options.svg) + '\n');
    }
  });
}

Page page_of_report(const std::string& folder) { return {report_of(folder), io::content_policy(report_html())}; }

/// The page, or nothing, with an exit code: the report of a result, or of a scenario that is run for it (as far as it gets), or
/// sliders for the joints of a model.
std::optional<Page> page_of(const std::string& source, Notes notes, int& code) {
  if (is_folder(source)) return page_of_report(source);
  const std::shared_ptr<const io::Scenario> scenario = load(source, {}, notes);
  code = bad_input;
  if (!scenario) return std::nullopt;
  if (io::is_model(scenario->path, scenario->text)) {
    code = done;
    const PlaygroundContent content = playground_content(*scenario, {});
    return Page{io::model_page(playground_html(), content.text, content.meshes), io::content_policy(playground_html())};
  }
  const TemporaryFolder folder;
  const Recorded recorded = record(*scenario, folder.result(), Purpose::report);
  code = recorded.code;
  if (code == interrupted) return std::nullopt;
  return page_of_report(recorded.folder);
}

/// Runs the scenario in real time until Ctrl-C, or until the reader stops it.
int show_live(const ViewOptions& options) {
  for (const auto& [option, given] : {std::pair{"--svg", !options.svg.empty()},
                                      {"--export", !options.exported.empty()},
                                      {"--every", options.every != 0},
                                      {"--look", !options.look.empty()},
                                      {"--layout", options.layout != "overlay"}})
    if (given) throw_error({std::string("--live and ") + option + " exclude each other", option, "leave one of them out"});
  if (is_folder(options.source))
    throw_error({"a result cannot be run", options.source, "name the scenario, or leave out --live to view the result"});
  const std::shared_ptr<const io::Scenario> scenario = load(options.source, options.overrides, notes_of(options.verbose));
  if (!scenario) return bad_input;
  io::Session session(scenario);
  show(stderr, io::rendered(session.schedule()));
  live::View page(session.simulation(), *scenario, {.port = options.port, .open_browser = !options.no_browser});
  for (const std::string& warning : page.warnings()) show(stderr, "warning: " + printable(warning) + '\n');
  const InterruptGuard guard;
  std::printf("%s\n", page.address().c_str());
  if (std::fflush(stdout) != 0) return failed;  // nobody would find the page
  std::fprintf(stderr, "Press Ctrl-C to stop.\n");
  const auto goes_on = [] { return !InterruptGuard::interrupted(); };
  const RunResult ended = page.run_until(HUGE_VAL, goes_on);
  if (ended || ended == Status::interrupted) return done;
  show(stderr, printable(scenario->path) + ": error: " + ended.reason + '\n');
  while (goes_on() && !page.stopped()) {  // the page shows where it ended
    page.exchange();
    page.wait(std::chrono::milliseconds(100));
  }
  return failed;
}

}  // namespace

std::string report_of(const std::filesystem::path& folder, const std::string& summary) {
  return io::report_page(report_html(), io::report_data(folder, {.summary = summary}));
}

int view(const ViewOptions& options) {
  if (options.live) return show_live(options);
  if (!options.overrides.empty())
    throw_error({"--set applies only to live runs", "--set", "add --live, or change the scenario's text"});
  if (!options.svg.empty() && options.exported.empty()) return draw(options);
  if (options.every != 0 || !options.look.empty() || options.layout != "overlay")
    throw_error({"--every, --look and --layout apply only to pictures", "", "draw the run with --svg FILE, or leave them out"});
  if (!options.exported.empty()) return export_run(options);
  live::Listener listener = live::listen_on(options.port);  // before a run that takes time
  int code = done;
  std::optional<Page> page = page_of(options.source, notes_of(options.verbose), code);
  if (!page) return code;
  const int served = serve(std::move(*page), std::move(listener), !options.no_browser);
  return code != done ? code : served;
}

}  // namespace momentree::cli

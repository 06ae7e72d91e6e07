// The command line: turns arguments into options, and errors into messages and exit codes. No physics.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include <cli/commands.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/base/error.hpp>

namespace {

using momentree::Error;
using namespace momentree::cli;

constexpr const char* closing =
    "Exit codes: 0 done, 1 the simulation failed, 2 bad input or usage, 3 interrupted (what was computed is kept).";

struct CommandLine {
  CommandLine();
  CLI::App* command(const char* name, const char* does, std::function<int()> action);
  void overrides(CLI::App* sub, std::vector<std::string>& values);
  void served(CLI::App* sub, int& port, bool& no_browser);
  void not_yet(const char* name, const char* does);
  /// Throws Error for arguments that no option takes.
  void require_known_arguments() const;

  CLI::App app{"momentree: dynamics of mechanisms whose topology changes while they move", "momentree"};
  RunOptions run_options;
  CheckOptions check_options;
  EvaluateOptions evaluate_options;
  ExplainOptions explain_options;
  ConvertOptions convert_options;
  CompileOptions compile_options;
  ViewOptions view_options;
  PlayOptions play_options;
  BenchOptions bench_options;
  std::vector<std::pair<CLI::App*, std::function<int()>>> commands;
  std::vector<const CLI::App*> without_code;  ///< they take any arguments
};

CLI::App* CommandLine::command(const char* name, const char* does, std::function<int()> action) {
  CLI::App* sub = app.add_subcommand(name, does);
  sub->footer(closing);
  sub->allow_extras();  // require_known_arguments has better words for them
  commands.emplace_back(sub, std::move(action));
  return sub;
}

void CommandLine::overrides(CLI::App* sub, std::vector<std::string>& values) {
  sub->add_option("--set", values, "Replace a value of the scenario: a dotted path = a TOML value, as in integrate.step=1e-4")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

void CommandLine::served(CLI::App* sub, int& port, bool& no_browser) {
  sub->add_option("--port", port, "Of 127.0.0.1; default: any that is free")->type_name("N")->check(CLI::Range(0, 65535));
  sub->add_flag("--no-browser", no_browser, "Print the address and open nothing");
}

// Commands of the interface that have no code yet are named, so that nobody looks for a slip of the pen.
void CommandLine::not_yet(const char* name, const char* does) {
  CLI::App* sub = command(name, (std::string(does) + " (not supported yet)").c_str(), [name]() -> int {
    throw Error{"`momentree " + std::string(name) + "` is not supported yet", "", ""};
  });
  without_code.push_back(sub);
}

CommandLine::CommandLine() {
  app.set_version_flag("--version", "momentree " MOMENTREE_VERSION);
  app.footer(closing);
  app.require_subcommand(0, 1);
  app.allow_extras();

  CLI::App* run_command = command("run", "Run a scenario or a model and write the results", [this] { return run(run_options); });
  run_command->add_option("scenario", run_options.scenario, "A scenario (.toml) or a model (.urdf, .sdf, .xml)")
      ->required()
      ->type_name("SCENARIO|MODEL");
  run_command->add_option("--out", run_options.out, "Where the results go; default results/ and the scenario's name")
      ->type_name("DIR");
  overrides(run_command, run_options.overrides);
  run_command->add_option("--until", run_options.until, "End the run at this time instead")->type_name("T");
  run_command->add_option("--format", run_options.format, "csv, or hdf5 (not supported yet)")->type_name("csv|hdf5");
  run_command->add_flag("--report", run_options.report, "Also write report.html: the motion, events and plots in one page");
  run_command->add_flag("--reactions", run_options.reactions,
                        "Add to joints.csv what each joint carries: fx, fy, fz, mx, my, mz");
  run_command->add_flag("--generate", run_options.generate,
                        "Compile code for each topology as it comes, and run that (short chains and arms)");
  run_command->add_option("--checkpoint", run_options.checkpoint, "Save the run now and then (not supported yet)")
      ->type_name("EVERY");
  run_command->add_flag("--resume", run_options.resume, "Go on from a checkpoint (not supported yet)");
  run_command->add_flag("--quiet", run_options.quiet, "Print nothing but warnings and errors");
  run_command->add_flag("--json", run_options.json, "Print summary.json and nothing else");

  CLI::App* check_command =
      command("check", "Say what is wrong with scenarios and models, as file:line:col", [this] { return check(check_options); });
  check_command->add_option("files", check_options.files, "Scenarios (.toml) or models (.urdf, .sdf, .xml)")
      ->required()
      ->type_name("FILE");
  check_command->add_flag("--json", check_options.json, "Print one JSON document and nothing else: problems for an editor");

  CLI::App* evaluate_command = command("evaluate", "Evaluate a scenario or a model once, at its start or at a state",
                                       [this] { return evaluate(evaluate_options); });
  evaluate_command->add_option("scenario", evaluate_options.scenario, "A scenario (.toml) or a model (.urdf, .sdf, .xml)")
      ->required()
      ->type_name("SCENARIO|MODEL");
  evaluate_command->add_option("--state", evaluate_options.state, "A state document, such as the final.json of a run")
      ->type_name("STATE.json");
  overrides(evaluate_command, evaluate_options.overrides);
  evaluate_command->add_flag("--json", evaluate_options.json, "Print the state document and nothing else");

  CLI::App* explain_command = command("explain", "Draw the tree in the terminal, with masses and degrees of freedom",
                                      [this] { return explain(explain_options); });
  explain_command->add_option("scenario", explain_options.scenario, "A scenario (.toml) or a model (.urdf, .sdf, .xml)")
      ->required()
      ->type_name("SCENARIO|MODEL");
  overrides(explain_command, explain_options.overrides);

  CLI::App* convert_command = command("convert", "Write a scenario or a model as a scenario (.toml) or a model (.urdf)",
                                      [this] { return convert(convert_options); });
  convert_command->add_option("source", convert_options.source, "A scenario (.toml) or a model (.urdf, .sdf, .xml)")
      ->required()
      ->type_name("SCENARIO|MODEL");
  convert_command->add_option("-o,--out", convert_options.out, "The file to write: .toml or .urdf; - is TOML on standard output")
      ->required()
      ->type_name("FILE");
  convert_command->add_option("--mechanism", convert_options.mechanism, "Which one, for a URDF of a scenario with several")
      ->type_name("NAME");
  overrides(convert_command, convert_options.overrides);

  CLI::App* compile_command = command("compile", "Write code that is specialised for one topology, as a C++ file",
                                      [this] { return compile(compile_options); });
  compile_command->add_option("scenario", compile_options.scenario, "A scenario file (.toml)")->required()->type_name("SCENARIO");
  compile_command->add_option("-o,--out", compile_options.out, "The file to write; - is standard output")
      ->required()
      ->type_name("FILE");
  compile_command->add_option("--name", compile_options.name, "What its names begin with; default: the scenario's name")
      ->type_name("NAME");
  compile_command->add_flag("--without-joint-forces", compile_options.without_joint_forces,
                            "The recursion alone, without dampers, springs and efforts");
  overrides(compile_command, compile_options.overrides);

  CLI::App* view_command =
      command("view", "Look at a run in the browser, or draw it as a picture", [this] { return view(view_options); });
  view_command->add_option("source", view_options.source, "A result directory of `momentree run`, or a scenario or model")
      ->required()
      ->type_name("DIR|SCENARIO|MODEL");
  view_command->add_option("--svg", view_options.svg, "Draw frames of the run into this file instead")->type_name("FILE");
  view_command->add_option("--every", view_options.every, "Time between frames in seconds; default 0.2, or what suits the run")
      ->type_name("T");
  view_command
      ->add_option("--look", view_options.look, "Direction in which the viewer looks, as in 0,0,-1; default: what shows most")
      ->type_name("X,Y,Z");
  view_command
      ->add_option("--layout", view_options.layout,
                   "overlay: all frames in one picture; multiples: one beside the other; default overlay")
      ->type_name("LAYOUT");

  served(view_command, view_options.port, view_options.no_browser);

  CLI::App* play_command = command("play", "Play with a scenario or a model in the browser: cut, lock, weld, throw",
                                   [this] { return play(play_options); });
  play_command->add_option("source", play_options.source, "A scenario (.toml) or a model (.urdf, .sdf, .xml); default: a gallery")
      ->type_name("SCENARIO|MODEL");
  overrides(play_command, play_options.overrides);
  served(play_command, play_options.port, play_options.no_browser);

  CLI::App* bench_command = command("bench", "Measure this machine: the tables of the paper, or models of one's own",
                                    [this] { return bench(bench_options); });
  bench_command
      ->add_option("models", bench_options.models,
                   "Scenarios (.toml) or models (.urdf, .sdf, .xml) to measure instead of the tables")
      ->type_name("SCENARIO|MODEL");
  bench_command->add_flag("--json", bench_options.json, "Print one JSON document and nothing else");
  bench_command->add_option("--peers", bench_options.peers, "Run the programs peer-* in this folder, too: other engines")
      ->type_name("FOLDER");
  bench_command->add_option("--bodies", bench_options.bodies, "Bodies of the largest chains; default 1000000, which takes 2 GB")
      ->type_name("N")
      ->check(CLI::Range(1000, 100000000));

  not_yet("sweep", "Run many worlds");
}

void CommandLine::require_known_arguments() const {
  std::vector<std::string> names, options = {"--help", "--version"};
  for (const auto& [sub, action] : commands) names.push_back(sub->get_name());
  const CLI::App* parsed = app.get_subcommands().empty() ? &app : app.get_subcommands().front();
  const std::string help = "see `momentree " + (parsed == &app ? "" : parsed->get_name() + " ") + "--help`";
  const auto suggestion = [&help](const std::string& word, const std::vector<std::string>& known) {
    const std::string guess = momentree::did_you_mean(word, known);
    return guess.empty() ? help : guess;
  };
  if (std::ranges::count(without_code, parsed) > 0) return;
  const std::vector<std::string> extras = parsed->remaining();
  if (!extras.empty()) {
    const auto option_like = std::ranges::find_if(extras, [](const std::string& e) { return e.starts_with('-'); });
    const bool about_command = parsed == &app && !extras.front().starts_with('-');
    std::string word = option_like == extras.end() || about_command ? extras.front() : *option_like;
    word = word.substr(0, word.find('='));
    if (word.starts_with('-')) {
      for (const CLI::Option* option : parsed->get_options())
        for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
      throw Error{"unknown option '" + word + "'", "", suggestion(word, options)};
    }
    if (parsed == &app) throw Error{"unknown command '" + word + "'", "", suggestion(word, names)};
    throw Error{"one argument too many: '" + word + "'", "", help};
  }
  if (parsed == &app) throw Error{"no command is given", "", help};
}

int call(int argc, char** argv) {
  CommandLine line;
  try {
    line.app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return line.app.exit(e) == 0 ? done : bad_input;
  } catch (const CLI::CallForVersion& e) {
    return line.app.exit(e) == 0 ? done : bad_input;
  } catch (const CLI::ParseError& e) {
    line.require_known_arguments();  // a slip in an option's name may be why another is missing
    const auto parsed = line.app.get_subcommands();
    throw Error{e.what(), "", "see `momentree " + (parsed.empty() ? "" : parsed.front()->get_name() + " ") + "--help`"};
  }
  line.require_known_arguments();
  for (const auto& [sub, action] : line.commands)
    if (sub->parsed()) return action();
  return bad_input;
}

}  // namespace

int main(int argc, char** argv) {
  int code = failed;
  try {
    code = call(argc, argv);
  } catch (const Error& error) {
    show(stderr, (error.where.empty() ? "momentree: " : "") + error.message() + '\n');
    code = bad_input;
  } catch (const std::bad_alloc&) {
    std::fputs("momentree: error: the memory that is free is not enough; a model takes some 3 kB for each body\n", stderr);
    code = failed;
  } catch (const std::exception& error) {
    show(stderr, "momentree: error: " + momentree::printable(error.what()) + '\n');
    code = failed;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    std::fputs("momentree: error: cannot write to standard output\n", stderr);
    if (code == done) code = failed;
  }
  return code;
}

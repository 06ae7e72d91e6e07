#include <cli/command_line.hpp>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <iterator>
#include <string_view>
#include <utility>

#include <cli/arguments.hpp>
#include <cli/commands/version.hpp>
#include <cli/completion/completion.hpp>
#include <cli/completion/man_page.hpp>
#include <momentree/base/error.hpp>
#include <momentree/export/export.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/keys/schema.hpp>
#include <momentree/sweep/plan/sweep_keys.hpp>

namespace momentree::cli {

namespace {

constexpr const char* closing =
    "Exit codes: 0 done, 1 the simulation failed, 2 bad input or usage, 3 interrupted (what was computed is kept).";
constexpr const char* a_source = "A scenario (.toml) or a model (.urdf, .sdf, .xml); - is standard input";

bool offered(const std::string& group) { return !group.empty(); }

std::string quoted(const std::string& words) { return "`momentree " + words + "`"; }

class CommandLine {
 public:
  CommandLine(Bench bench, std::string_view commit);
  int call(int argc, char** argv);

 private:
  CLI::App* command(const char* name, const char* does, std::function<int()> action);
  void add_run();
  void add_compare();
  void add_sweep();
  void add_readers();
  void add_writers();
  void add_pages();
  void add_helpers();
  void overrides(CLI::App* sub, std::vector<std::string>& values);
  void verbose(CLI::App* sub, bool& value);
  void served(CLI::App* sub, int& port, bool& no_browser);
  CLI::Option* source(CLI::App* sub, const char* name, std::string& value, const char* type, const char* does);

  CommandTable table() const;
  /// The commands that help offers, in their order.
  std::vector<const CLI::App*> commands() const;
  /// The help of a command, or of the program if no command has that name.
  std::string help(std::string_view command) const;
  const CLI::App* parsed() const;
  void require_known_arguments() const;
  void require_one_standard_input() const;
  int print_help() const;

  CLI::App app_{"momentree: dynamics of mechanisms whose topology changes while they move", "momentree"};
  RunOptions run_;
  SweepOptions sweep_;
  CompareOptions compare_;
  CheckOptions check_;
  EvaluateOptions evaluate_;
  ExplainOptions explain_;
  ConvertOptions convert_;
  CompileOptions compile_;
  ViewOptions view_;
  PlayOptions play_;
  BenchOptions bench_;
  Bench measure_;
  std::string help_on_, shell_;
  bool of_sweeps_ = false;
  std::vector<std::pair<CLI::App*, std::function<int()>>> actions_;
};

CLI::App* CommandLine::command(const char* name, const char* does, std::function<int()> action) {
  CLI::App* sub = app_.add_subcommand(name, does);
  sub->footer(closing);
  sub->allow_extras();  // require_known_arguments gives better messages
  actions_.emplace_back(sub, std::move(action));
  return sub;
}

void CommandLine::overrides(CLI::App* sub, std::vector<std::string>& values) {
  sub->add_option("--set", values, "Replace a value of the scenario: a dotted path = a TOML value, as in integrate.step=1e-4")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

void CommandLine::verbose(CLI::App* sub, bool& value) {
  sub->add_flag("-v,--verbose", value, "List the notes on a model file instead of only their number");
}

void CommandLine::served(CLI::App* sub, int& port, bool& no_browser) {
  sub->add_option_function<std::string>(
         "--port", [&port](const std::string& text) { port = number_argument("--port", text, 0, 65535); },
         "Port on 127.0.0.1; default: any free port")
      ->type_name("N");
  sub->add_flag("--no-browser", no_browser, "Print the address without opening a browser");
}

CLI::Option* CommandLine::source(CLI::App* sub, const char* name, std::string& value, const char* type, const char* does) {
  return sub->add_option(name, value, does)->type_name(type);
}

CommandLine::CommandLine(Bench bench, std::string_view commit) : measure_(bench) {
  app_.add_flag_callback(
      "-V", [text = long_version_text(commit)] { throw CLI::CallForVersion(text, 0); },
      "Print the version and all details of the build");
  app_.set_version_flag("--version", version_text(commit), "Print the version and how it was built");
  app_.footer(closing);
  app_.require_subcommand(0, 1);
  app_.allow_extras();
  add_run();
  add_sweep();
  add_compare();
  add_readers();
  add_writers();
  add_pages();
  add_helpers();
}

void CommandLine::add_run() {
  CLI::App* sub = command("run", "Run a scenario or a model and write the results", [this] { return run(run_); });
  source(sub, "scenario", run_.scenario, "SCENARIO|MODEL", a_source)->required();
  sub->add_option("--out", run_.out, "Folder for the results; default: results/ and the scenario's name")->type_name("DIR");
  overrides(sub, run_.overrides);
  sub->add_option_function<std::string>(
         "--until", [this](const std::string& text) { run_.until = time_argument("--until", text); },
         "End the run at this time instead: seconds, or with a unit as in \"2 min\"")
      ->type_name("T");
  sub->add_option_function<std::string>(
         "--format",
         [this](const std::string& text) {
           run_.format = choice_argument("--format", text, {"csv", "hdf5"});
         },
         "Write the tables as CSV files, or all of them as results.h5 (HDF5); default csv")
      ->type_name("csv|hdf5");
  sub->add_option_function<std::string>(
         "--checkpoint", [this](const std::string& text) { run_.checkpoint = interval_argument("--checkpoint", text); },
         "Save the run each time that this wall-clock time has passed: seconds, or with a unit as in 60s or \"5 min\"")
      ->type_name("T");
  sub->add_flag("--resume", run_.resume, "Go on from the last checkpoint of a run into the same folder, if there is one");
  sub->add_flag("--report", run_.report, "Also write report.html: the motion, events and plots in one page");
  sub->add_flag("--reactions", run_.reactions, "Add the reactions of the joints to joints.csv: fx, fy, fz, mx, my, mz");
  sub->add_flag("--generate", run_.generate,
                "Make one function of machine code for each topology that occurs: faster for closed loops and robots");
  sub->add_flag("--quiet", run_.quiet, "Print nothing but warnings and errors");
  verbose(sub, run_.verbose);
  sub->add_flag("--json", run_.json, "Print summary.json and nothing else");
}

void CommandLine::add_readers() {
  CLI::App* check_command =
      command("check", "Report problems in scenarios, sweeps and models, as file:line:col", [this] { return check(check_); });
  check_command
      ->add_option("files", check_.files, "Scenarios and sweeps (.toml) or models (.urdf, .sdf, .xml); - is standard input")
      ->required()
      ->type_name("FILE");
  verbose(check_command, check_.verbose);
  check_command->add_flag("--json", check_.json, "Print one JSON document and nothing else, for editors");

  CLI::App* evaluate_command = command("evaluate", "Evaluate a scenario or a model once, at its start or at a state",
                                       [this] { return evaluate(evaluate_); });
  source(evaluate_command, "scenario", evaluate_.scenario, "SCENARIO|MODEL", a_source)->required();
  evaluate_command
      ->add_option("--state", evaluate_.state, "A state document, such as the final.json of a run; - is standard input")
      ->type_name("STATE.json");
  evaluate_command->add_flag("--equilibrium", evaluate_.equilibrium,
                             "Move to the equilibrium first, and list the modes of vibration about it");
  overrides(evaluate_command, evaluate_.overrides);
  verbose(evaluate_command, evaluate_.verbose);
  evaluate_command->add_flag("--json", evaluate_.json, "Print the state document and nothing else");

  CLI::App* explain_command = command("explain", "Draw the tree in the terminal, with masses and degrees of freedom",
                                      [this] { return explain(explain_); });
  source(explain_command, "scenario", explain_.scenario, "SCENARIO|MODEL", a_source)->required();
  overrides(explain_command, explain_.overrides);
  explain_command->add_flag("--code", explain_.code,
                            "Instead, print the steps that become machine code, operation by operation with their equations");
  verbose(explain_command, explain_.verbose);
}

void CommandLine::add_sweep() {
  CLI::App* sub = command("sweep", "Run many worlds of a scenario with varied values; under mpirun on many machines",
                          [this] { return sweep(sweep_); });
  sub->add_option("sweep", sweep_.file, "A sweep (.toml)")->required()->type_name("SWEEP");
  sub->add_option("--out", sweep_.out,
                  "Folder for the results, or an HDF5 file (.h5); default: as the sweep says, or results/ and its name")
      ->type_name("DIR|FILE.h5");
  sub->add_option_function<std::string>(
         "--jobs", [this](const std::string& text) { sweep_.jobs = number_argument("--jobs", text, 1, 1024); },
         "Number of threads; default: as many as the machine has, under mpirun 1 per rank")
      ->type_name("N");
  sub->add_option(
         "--lanes", sweep_.lanes,
         "SIMD lanes for simple worlds: auto (default), baseline, avx2, avx512 or none; worlds have the bits of single runs")
      ->type_name("SET");
  sub->add_option_function<std::string>(
         "--world",
         [this](const std::string& text) {
           sweep_.world = static_cast<std::uint64_t>(number_argument("--world", text, 0, 2147483647));
         },
         "Run this world alone and write what `run` writes")
      ->type_name("K");
  sub->add_flag("--resume", sweep_.resume, "Go on from an interrupted sweep; nothing happens if it is complete");
  sub->add_flag("--restart", sweep_.restart, "Discard the results of an interrupted sweep");
  sub->add_flag("--accept-changes", sweep_.accept_changes, "Go on although the sweep, its files or the version have changed");
  sub->add_flag("--report", sweep_.report, "Also write report.html: distributions, sensitivities and the worst cases");
  sub->add_flag("--quiet", sweep_.quiet, "Print nothing but warnings and errors");
  sub->add_flag("--json", sweep_.json, "Print sweep.json and nothing else");
}

void CommandLine::add_compare() {
  CLI::App* sub =
      command("compare", "Compare two results: the first row and body where they differ", [this] { return compare(compare_); });
  sub->alias("replay");
  sub->add_option("first", compare_.one, "A result directory of `momentree run`, also one that ends in .partial")
      ->required()
      ->type_name("DIR");
  sub->add_option("second", compare_.other, "The other one")->required()->type_name("DIR");
  sub->add_option_function<std::string>(
         "--tolerance", [this](const std::string& text) { compare_.tolerance = tolerance_argument("--tolerance", text); },
         "Numbers may differ by this much, or by this part of the larger one; default 0")
      ->type_name("X");
  sub->add_flag("--json", compare_.json, "Print one JSON document and nothing else");
}

void CommandLine::add_writers() {
  CLI::App* convert_command = command("convert", "Write a scenario or a model as a scenario (.toml) or a model (.urdf)",
                                      [this] { return convert(convert_); });
  source(convert_command, "source", convert_.source, "SCENARIO|MODEL", a_source)->required();
  convert_command->add_option("-o,--out", convert_.out, "The file to write: .toml or .urdf; - is TOML on standard output")
      ->required()
      ->type_name("FILE");
  convert_command->add_option("--mechanism", convert_.mechanism, "The mechanism to write as a URDF, if the scenario has several")
      ->type_name("NAME");
  overrides(convert_command, convert_.overrides);
  verbose(convert_command, convert_.verbose);

  CLI::App* compile_command =
      command("compile", "Write code that is specialised for one topology, as a C++ file", [this] { return compile(compile_); });
  source(compile_command, "scenario", compile_.scenario, "SCENARIO|MODEL", a_source)->required();
  compile_command->add_option("-o,--out", compile_.out, "The file to write; - is standard output")->required()->type_name("FILE");
  compile_command->add_option("--name", compile_.name, "Prefix of its names; default: the scenario's name")->type_name("NAME");
  compile_command
      ->add_option_function<std::string>(
          "--variables",
          [this](const std::string& text) {
            compile_.variables = *variables_of(choice_argument("--variables", text, variable_names()));
          },
          "What the function takes with the coordinates: momenta (default) or velocities")
      ->type_name("momenta|velocities");
  compile_command->add_flag("--without-joint-forces", compile_.without_joint_forces,
                            "The recursion alone, without dampers, springs and efforts");
  overrides(compile_command, compile_.overrides);
  verbose(compile_command, compile_.verbose);
}

void CommandLine::add_pages() {
  CLI::App* view_command = command("view", "View a run in the browser, or draw it as a picture", [this] { return view(view_); });
  source(view_command, "source", view_.source, "DIR|SCENARIO|MODEL",
         "A result directory of `momentree run`, or a scenario or model; - is standard input")
      ->required();
  view_command->add_option("--svg", view_.svg, "Draw frames of the run into this file (.svg; - is standard output) instead")
      ->type_name("FILE");
  view_command
      ->add_option_function<std::string>(
          "--every", [this](const std::string& text) { view_.every = seconds_argument("--every", text); },
          "Time between frames: seconds, or with a unit; default 0.2 s, or a value that suits the run")
      ->type_name("T");
  view_command
      ->add_option("--look", view_.look, "Direction in which the viewer looks, as in 0,0,-1; default: the one that shows most")
      ->type_name("X,Y,Z");
  view_command
      ->add_option("--layout", view_.layout, "overlay: all frames in one picture; multiples: side by side; default overlay")
      ->type_name("overlay|multiples");
  view_command
      ->add_option("--export", view_.exported, "Write the run into this file for other programs instead: " + io::export_formats())
      ->type_name("FILE");
  view_command->add_flag("--live", view_.live, "Run the scenario while its page is open: pause it, slow it down, change it");
  overrides(view_command, view_.overrides);
  served(view_command, view_.port, view_.no_browser);
  verbose(view_command, view_.verbose);

  CLI::App* play_command =
      command("play", "Play with a scenario or a model in the browser: break, lock, weld, throw", [this] { return play(play_); });
  source(play_command, "source", play_.source, "SCENARIO|MODEL",
         "A scenario (.toml) or a model (.urdf, .sdf, .xml); - is standard input; default: a gallery");
  overrides(play_command, play_.overrides);
  served(play_command, play_.port, play_.no_browser);
  verbose(play_command, play_.verbose);

  CLI::App* bench_command =
      command("bench", "Measure this machine: the tables of the paper, or your own models", [this] { return measure_(bench_); });
  bench_command
      ->add_option("models", bench_.models, "Scenarios (.toml) or models (.urdf, .sdf, .xml) to measure instead of the tables")
      ->type_name("SCENARIO|MODEL");
  bench_command->add_flag("--json", bench_.json, "Print one JSON document and nothing else");
  bench_command->add_option("--peers", bench_.peers, "Also run the programs peer-* in this folder: other engines")
      ->type_name("DIR");
  bench_command
      ->add_option_function<std::string>(
          "--bodies", [this](const std::string& text) { bench_.bodies = number_argument("--bodies", text, 1000, 100000000); },
          "Bodies of the largest chains; default 1000000, which takes about 3 GB")
      ->type_name("N");
}

void CommandLine::add_helpers() {
  CLI::App* help_command = command("help", "Print the help of a command", [this] { return print_help(); });
  help_command->add_option("command", help_on_, "The command; default: all of them")->type_name("COMMAND");

  CLI::App* completion_command = command("completion", "Print a script that completes command lines in a shell", [this] {
    std::fputs(completion_script(table(), shell_).c_str(), stdout);
    return done;
  });
  completion_command->add_option("shell", shell_, "The shell")->required()->type_name("bash|zsh|fish");

  CLI::App* schema_command = command("schema", "Print the JSON Schema of scenario files, for editors", [this] {
    std::fputs((of_sweeps_ ? sweep::sweep_schema() : io::scenario_schema()).c_str(), stdout);
    return done;
  });
  schema_command->add_flag("--sweep", of_sweeps_, "That of sweep files");

  CLI::App* page = command("man-page", "", [this] {  // for the build
    std::fputs(man_page(table()).c_str(), stdout);
    return done;
  });
  page->group("");
}

std::vector<const CLI::App*> CommandLine::commands() const {
  std::vector<const CLI::App*> all;
  for (const auto& [sub, action] : actions_)
    if (offered(sub->get_group())) all.push_back(sub);
  return all;
}

CommandInfo info_on(const CLI::App& command) {
  CommandInfo info{command.get_name(), command.get_description(), {}, {}};
  for (const CLI::Option* option : command.get_options()) {
    OptionInfo each{{},
                    option->get_type_name(),
                    option->get_description(),
                    option->get_items_expected_max() > 0,
                    option->get_items_expected_max() > 1,
                    option->get_required(),
                    option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll};
    for (const std::string& name : option->get_snames()) each.flags.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) each.flags.push_back("--" + name);
    (each.positional() ? info.arguments : info.options).push_back(std::move(each));
  }
  return info;
}

CommandTable CommandLine::table() const {
  CommandTable table{info_on(app_), {}};
  for (const CLI::App* sub : commands()) table.commands.push_back(info_on(*sub));
  return table;
}

std::string CommandLine::help(std::string_view command) const {
  const CLI::App* about = &app_;
  for (const CLI::App* sub : commands())
    if (sub->get_name() == command) about = sub;
  const std::string name = about == &app_ ? "momentree" : "momentree " + about->get_name();
  std::string text = about->get_formatter()->make_help(about, name, CLI::AppFormatMode::Normal);
  for (std::size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);  // left by a hidden group
  while (text.ends_with('\n')) text.pop_back();
  return text + '\n';
}

int CommandLine::print_help() const {
  std::vector<std::string> names;
  for (const CLI::App* sub : commands()) names.push_back(sub->get_name());
  if (!help_on_.empty() && std::ranges::count(names, help_on_) == 0) {
    const std::string guess = did_you_mean(help_on_, names);
    throw Error{"unknown command '" + help_on_ + "'", "", guess.empty() ? "see `momentree help`" : guess};
  }
  std::fputs(help(help_on_).c_str(), stdout);
  return done;
}

const CLI::App* CommandLine::parsed() const {
  const std::vector<CLI::App*> subs = app_.get_subcommands();
  return subs.empty() ? &app_ : subs.front();
}

void CommandLine::require_known_arguments() const {
  const CLI::App* sub = parsed();
  const std::string help = "see " + quoted(sub == &app_ ? "help" : "help " + sub->get_name());
  const auto suggestion = [&help](const std::string& word, const std::vector<std::string>& known) {
    const std::string guess = did_you_mean(word, known);
    return guess.empty() ? help : guess;
  };
  const std::vector<std::string> extras = sub->remaining();
  if (!extras.empty()) {
    const auto option_like =
        std::ranges::find_if(extras, [](const std::string& e) { return e.size() > 1 && e.starts_with('-'); });
    const bool about_command = sub == &app_ && !extras.front().starts_with('-');
    std::string word = option_like == extras.end() || about_command ? extras.front() : *option_like;
    if (word.size() > 1 && word.starts_with('-')) {
      word = word.substr(0, word.find('='));
      std::vector<std::string> known;
      for (const OptionInfo& option : info_on(*sub).options)
        std::ranges::copy_if(option.flags, std::back_inserter(known), [](const auto& flag) { return flag.starts_with("--"); });
      throw Error{"unknown option '" + word + "'", "", suggestion(word, known)};
    }
    if (sub != &app_)
      throw Error{"one argument too many: '" + word + "'", "",
                  sub->get_name() == "run" ? "a call runs one scenario: call it once for each" : help};
    std::vector<std::string> names;
    for (const CLI::App* each : commands()) names.push_back(each->get_name());
    throw Error{"unknown command '" + word + "'", "", suggestion(word, names)};
  }
  if (sub == &app_) throw Error{"no command given", "", help};
}

void CommandLine::require_one_standard_input() const {
  long inputs = 0;
  for (const CLI::Option* option : parsed()->get_options())
    if (option->get_positional() || option->get_name() == "--state") inputs += std::ranges::count(option->results(), "-");
  if (inputs > 1) throw Error{"standard input can be read only once", "", "give one of them as a file"};
}

int CommandLine::call(int argc, char** argv) {
  bench_.command_line = argv;
  try {
    app_.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::fputs(help(parsed()->get_name()).c_str(), stdout);
    return done;
  } catch (const CLI::CallForVersion& e) {
    std::fputs(e.what(), stdout);
    return done;
  } catch (const CLI::ParseError& e) {
    require_known_arguments();  // a missing option may be caused by a misspelled one
    const CLI::App* sub = parsed();
    std::string what = e.what();
    if (const std::size_t colon = what.find(": 1 required "); colon != std::string::npos)  // "--until: 1 required T missing"
      what = "`" + what.substr(0, colon) + "` needs a value";
    for (const CLI::Option* option : sub->get_options())
      if (option->get_positional() && what == option->get_name() + " is required")
        what = option->get_type_name() + " is required";
    throw Error{what, "", "see " + quoted(sub == &app_ ? "help" : "help " + sub->get_name())};
  }
  require_known_arguments();
  require_one_standard_input();
  for (const auto& [sub, action] : actions_)
    if (sub->parsed()) return action();
  return bad_input;
}

}  // namespace

int call(int argc, char** argv, Bench bench, std::string_view commit) { return CommandLine(bench, commit).call(argc, argv); }

}  // namespace momentree::cli

#include <cli/bench/peers.hpp>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include <cli/interrupt.hpp>
#include <cli/text.hpp>
#include <momentree/base/characters.hpp>
#include <momentree/base/error.hpp>
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/text/json.hpp>

extern char** environ;

namespace momentree::cli {

namespace {

/// A program whose standard output is read; it is terminated if the reader stops first.
class Reader {
 public:
  Reader(const std::string& program, std::vector<std::string> words) {
    int ends[2];
    if (pipe(ends) != 0) throw Error{program + ": cannot create a pipe to read its output", "", ""};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    posix_spawn_file_actions_addclose(&actions, ends[1]);
    words.insert(words.begin(), program);
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int failed = posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
    if (failed == 0 && output_ != nullptr) return;
    close(ends[0]);
    throw Error{program + " cannot be started", "", ""};
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() {
    if (process_ > 0) kill(process_, SIGTERM), finish();
  }

  bool line(std::string& text) {
    text.clear();
    for (int c = 0; (c = std::fgetc(output_)) != EOF && c != '\n';) text += static_cast<char>(c);
    return !text.empty();
  }
  /// Its exit status, or −1 if it was terminated.
  int finish() {
    std::fclose(output_);
    int status = 0;
    const bool known = waitpid(process_, &status, 0) == process_;
    process_ = 0;
    return known && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t process_ = 0;
  std::FILE* output_ = nullptr;
};

PeerRow row_of(const std::string& line, const std::string& program) {
  const Value document = io::parse_json(line, program);
  io::Diagnostics out(program, "");
  io::Fields fields(document, "its output", out, "");
  for (const char* key : {"engine", "way", "model", "ns_per_body", "imbalance"}) fields.require(key);
  const PeerRow row{fields.string("engine").value_or(""), fields.string("way").value_or(""), fields.string("model").value_or(""),
                    fields.real("ns_per_body").value_or(0), fields.real("imbalance").value_or(0)};
  out.throw_first();
  return row;
}

}  // namespace

std::vector<std::string> peer_programs(const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<std::string> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const fs::path& path = entry.path();
    if (path.filename().string().starts_with("peer-") && !path.has_extension() && entry.is_regular_file(error))
      found.push_back(path.string());
  }
  if (found.empty())
    throw Error{"no programs peer-* in " + folder, "",
                "configure with -DMOMENTREE_PEERS=ON, build the target `peers`, and name the folder BUILD/bench/peers"};
  std::ranges::sort(found, {}, [](const std::string& path) {
    const std::string name = fs::path(path).filename().string();
    return std::pair(name != "peer-momentree", name);
  });
  return found;
}

void peer_evaluations(const std::string& program, const std::vector<std::string>& files,
                      const std::function<bool(const PeerRow&)>& row) {
  std::vector<std::string> words{"evaluate"};
  words.insert(words.end(), files.begin(), files.end());
  Reader reader(program, std::move(words));
  for (std::string line; reader.line(line);)
    if (!row(row_of(line, program))) return;
  if (const int status = reader.finish(); status != 0)
    throw Error{format("%s failed (exit status %d): its output gives the reason", program.c_str(), status), "", ""};
}

std::vector<PeerRow> measure_peers(const std::vector<std::string>& programs, const std::vector<std::string>& files) {
  std::vector<PeerRow> rows;
  const auto keep = [&](const PeerRow& row) {
    rows.push_back(row);
    return !InterruptGuard::interrupted();
  };
  for (const std::string& program : programs) {
    if (InterruptGuard::interrupted()) return rows;
    if (files.empty()) peer_evaluations(program, {}, keep);
    for (const std::string& file : files) {
      if (InterruptGuard::interrupted()) return rows;
      try {
        peer_evaluations(program, {file}, keep);
      } catch (const Error& error) {  // an engine may not support every model, for example bodies without mass
        show(stderr, "momentree bench: left out: " + printable(error.problem) + '\n');
      }
    }
  }
  return rows;
}

std::string peers_table(const std::vector<PeerRow>& rows) {
  std::vector<std::string> models;
  std::vector<std::vector<const PeerRow*>> ways;
  for (const PeerRow& row : rows) {
    if (std::ranges::find(models, row.model) == models.end()) models.push_back(row.model);
    const bool known = std::ranges::any_of(ways, [&](auto& way) {
      const bool same = way[0]->engine == row.engine && way[0]->way == row.way;
      if (same) way.push_back(&row);
      return same;
    });
    if (!known) ways.push_back({&row});
  }
  const auto time_of = [](const std::vector<const PeerRow*>& way, const std::string& model) {
    const auto at = std::ranges::find(way, model, &PeerRow::model);
    return at == way.end() ? 0.0 : (*at)->ns_per_body;
  };
  Table table;
  std::vector<std::string> head{""};
  head.insert(head.end(), models.begin(), models.end());
  table.row(head);
  for (const auto& way : ways) {
    std::vector<std::string> cells{way[0]->engine + ", " + way[0]->way};
    for (const std::string& model : models) {
      const double time = time_of(way, model), ours = time_of(ways[0], model);
      std::string cell = time > 0 ? format("%.0f", time) : "";
      if (&way != ways.data() && time > 0 && ours > 0) cell += format(" (%.1f)", time / ours);
      cells.push_back(cell);
    }
    table.row(cells);
  }
  return table.text("  ");
}

void write_peers(io::JsonWriter& json, const std::vector<PeerRow>& rows) {
  json.key("peers").begin_array();
  for (const PeerRow& row : rows) {
    json.begin_object().member("engine", row.engine).member("way", row.way).member("model", row.model);
    json.member("ns_per_body", row.ns_per_body).member("imbalance", row.imbalance).end_object();
  }
  json.end_array();
}

}  // namespace momentree::cli

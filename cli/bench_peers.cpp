#include <cli/bench_peers.hpp>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/io/json_document.hpp>

extern char** environ;

namespace momentree::cli {

namespace {

/// A program whose standard output is read; ended where the reader stops before it does.
class Reader {
 public:
  Reader(const std::string& program, const char* argument) {
    int ends[2];
    if (pipe(ends) != 0) throw Error{program + ": no pipe to read it", "", ""};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    posix_spawn_file_actions_addclose(&actions, ends[1]);
    std::string words[] = {program, argument};
    char* const arguments[] = {words[0].data(), words[1].data(), nullptr};
    const int failed = posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
    if (failed == 0 && output_ != nullptr) return;
    close(ends[0]);
    throw Error{program + " can't be started", "", ""};
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
  /// Its exit status, or −1 if it was ended.
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
  const io::JsonDocument document = io::parse_json(line, program);
  const auto member = [&](const char* key) -> const io::JsonNode& {
    const io::JsonNode* node = document.root.find(key);
    if (node == nullptr) document.fail_at(document.root, std::string("its output has no `") + key + "`");
    return *node;
  };
  return {document.string(member("engine"), "`engine`"), document.string(member("way"), "`way`"),
          document.string(member("model"), "`model`"), document.number(member("ns_per_body"), "`ns_per_body`"),
          document.number(member("imbalance"), "`imbalance`")};
}

}  // namespace

std::vector<std::string> peer_programs(const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<std::string> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const fs::path path = entry.path();
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

void peer_evaluations(const std::string& program, const std::function<bool(const PeerRow&)>& row) {
  Reader reader(program, "evaluate");
  for (std::string line; reader.line(line);)
    if (!row(row_of(line, program))) return;
  if (const int status = reader.finish(); status != 0)
    throw Error{format("%s failed (exit status %d): what it wrote says why", program.c_str(), status), "", ""};
}

}  // namespace momentree::cli

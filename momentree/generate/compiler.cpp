#include <momentree/generate/compiler.hpp>

#include <dlfcn.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include <momentree/base/check.hpp>
#include <momentree/generate/private_folder.hpp>

extern char** environ;

namespace momentree {

namespace {

std::string of_environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> all;
  for (std::string word; stream >> word;) all.push_back(word);
  return all;
}

bool runs(const std::string& path) {
  struct stat about {};
  return access(path.c_str(), X_OK) == 0 && stat(path.c_str(), &about) == 0 && S_ISREG(about.st_mode);
}

// Searches like execvp, but not in relative entries of PATH.
std::string path_of(const std::string& program) {
  if (program.find('/') != std::string::npos) return runs(program) ? program : "";
  std::istringstream folders(of_environment("PATH"));
  for (std::string folder; std::getline(folders, folder, ':');)
    if (folder.starts_with('/') && runs(folder + '/' + program)) return folder + '/' + program;
  return "";
}

bool write_file(const std::string& path, const std::string& text) {
  std::FILE* file = std::fopen(path.c_str(), "wx");
  if (file == nullptr) return false;
  const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  return std::fclose(file) == 0 && whole;
}

std::string first_error(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "r");
  if (file == nullptr) return "";
  std::string first, found;
  char line[400];
  while (found.empty() && std::fgets(line, sizeof line, file) != nullptr) {
    std::string text = line;
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    if (first.empty()) first = text;
    if (text.find("error") != std::string::npos) found = text;
  }
  std::fclose(file);
  return found.empty() ? first : found;
}

/// Runs a program until it ends, with its messages in a file; returns its exit status, or −1 with the reason in `why`.
int run(const std::vector<std::string>& command, const std::string& messages, std::string& why) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));  // argv is not const in C
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&files, 1, 2);
  pid_t child = 0;
  const int error = posix_spawn(&child, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) {
    why = command[0] + " could not be started: " + std::strerror(error);
    return -1;
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) {
      why = command[0] + " was lost: " + std::strerror(errno);
      return -1;
    }
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  why = command[0] + " was stopped by a signal";
  return -1;
}

constexpr const char* contraction =
#ifdef MOMENTREE_DETERMINISTIC
    "-ffp-contract=off";
#else
    "-ffp-contract=fast";
#endif

}  // namespace

std::vector<std::string> find_compiler(const std::string& asked) {
  for (const std::string& given : {asked, of_environment("MOMENTREE_CXX"), of_environment("CXX")}) {
    if (given.find('/') != std::string::npos && runs(given)) return {given};  // spaces are part of an existing path
    std::vector<std::string> command = words(given);
    if (command.empty()) continue;
    command[0] = path_of(command[0]);
    if (command[0].empty()) command.clear();
    return command;
  }
  for (const char* program : {"c++", "g++", "clang++"})
    if (const std::string path = path_of(program); !path.empty()) return {path};
  return {};
}

void* Library::symbol(const char* name) const { return handle_ == nullptr ? nullptr : dlsym(handle_.get(), name); }

Library compile_library(const std::vector<std::string>& compiler, const std::string& source, std::string& why) {
  MT_REQUIRE(!compiler.empty(), "a compiler, as find_compiler() returns it where there is one");
  Library library;
  const PrivateFolder folder;
  if (!folder.made()) {
    why = folder.problem();
    return library;
  }
  if (!write_file(folder.file("kernel.cpp"), source)) {
    why = "generated code could not be written to " + folder.file("kernel.cpp") + ": set TMPDIR to a folder with room";
    return library;
  }
  const std::string object = folder.file("kernel.so");
  for (const char* cpu : {"-march=native", "-mcpu=native", ""}) {  // not every compiler accepts each of these
    std::vector<std::string> command = compiler;
    for (const char* flag : {"-std=c++20", "-O3", cpu, "-fno-math-errno", contraction, "-fPIC", "-shared", "-w", "-o"})
      if (*flag != '\0') command.emplace_back(flag);
    command.push_back(object);
    command.push_back(folder.file("kernel.cpp"));
    const int status = run(command, folder.file("messages"), why);
    if (status < 0) return library;
    if (status != 0) {
      if (why.empty()) why = compiler[0] + " failed: " + first_error(folder.file("messages"));
      continue;
    }
    why.clear();
    if (void* handle = dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL); handle != nullptr)
      library.handle_ = std::shared_ptr<void>(handle, [](void* h) { dlclose(h); });
    else
      why = std::string("generated code could not be loaded: ") + dlerror();
    return library;
  }
  return library;
}

}  // namespace momentree

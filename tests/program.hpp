#pragma once
// For tests: a folder with a scenario, in which the program is called as a user would.
#include <doctest/doctest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::test {
struct Outcome {
  int code = -1;
  std::string output, errors;
  bool says(const char* words) const { return (output + errors).find(words) != std::string::npos; }
};

inline constexpr const char* chain = R"(format = 1
title = "Short chain"
[world]
gravity = [0, -9.81, 0]
[[mechanism]]
name = "chain"
[mechanism.chain]
links = 8
length = "5 cm"
mass = "10 g"
inertia = "20.83 g cm^2"
axis = [0, 0, 1]
damping = "1e-5 N m s"
angle = "0.2 rad"
[[event]]
name = "snap"
at = "0.1 s"
break = "chain/4"
[integrate]
step = "1 ms"
until = "0.3 s"
[output]
every = "20 ms"
)";

/// A folder with a scenario, in which the program is called.
class Workplace {
 public:
  explicit Workplace(const std::string& scenario = chain) { io::write_text_file(folder_ / "s.toml", scenario); }

  Outcome call(const std::string& arguments) const {
    const std::string out = folder_ / "stdout", err = folder_ / "stderr";
    const std::string line =
        "cd '" + (folder_ / "") + "' && '" MOMENTREE_PROGRAM "' " + arguments + " >'" + out + "' 2>'" + err + "'";
    const int status = std::system(line.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, io::read_text_file(out), io::read_text_file(err)};
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    return outcome;
  }
  std::string path(const char* name) const { return folder_ / name; }
  std::string text(const char* name) const { return io::read_text_file(folder_ / name); }
  bool has(const char* name) const { return std::filesystem::exists(folder_ / name); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_ / ""), {}));
  }

 private:
  io::test::TemporaryFolder folder_;
};

inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

inline long lines(const std::string& text) { return std::ranges::count(text, '\n'); }

}  // namespace momentree::test

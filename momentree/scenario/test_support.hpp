#pragma once
// For tests only: a temporary folder, and a small world with every kind of state.
#include <cstdlib>
#include <filesystem>
#include <string>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/model/model.hpp>

namespace momentree::io::test {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "momentree-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const char* name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// The message of the Error that `action` throws; empty if it throws none.
template <class Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.message();
  }
  return "";
}

/// A spinning base with an arm whose joints and bodies have different names, and a separate pendulum.
inline Model two_mechanisms() {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId base = model.add({.name = "arm/base",
                                 .mass = 2,
                                 .com = {0.1, 0, 0.2},
                                 .inertia = {0.3, 0.4, 0.5, 0.01, 0.02, 0.03},
                                 .joint = Free{},
                                 .q = {0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5},
                                 .v = {0.1, -0.2, 0.3, 1, 2, -3}});
  const BodyId link = model.add({.name = "arm/link",
                                 .mass = 1,
                                 .com = {0.25, 0, 0},
                                 .inertia = diagonal(0.1, 0.2, 0.3),
                                 .parent = base,
                                 .at = {0, 0, 0.5},
                                 .joint = Ball{.damping = {0.1, 0.2, 0.3}},
                                 .q = {-0.6, 0.8, 0, 0},
                                 .v = {0.5, 0.25, -0.125},
                                 .joint_name = "arm/shoulder"});
  model.add({.name = "arm/hand",
             .mass = 0.5,
             .com = {0, 0.1, 0},
             .inertia = diagonal(0.01),
             .parent = link,
             .at = {0.5, 0, 0},
             .joint = Revolute{.axis = {0, 1, 0}, .damping = 0.01, .stiffness = 2},
             .q = {0.7},
             .v = {-1},
             .joint_name = "arm/wrist"});
  model.add({.name = "pendulum", .mass = 1, .com = {0, 0, -1}, .joint = Revolute{.axis = {1, 0, 0}}, .q = {1}});
  return model;
}

}  // namespace momentree::io::test

// A program outside the project's tree runs a scenario, and gets the errors of another.
#include <momentree/momentree.hpp>
#include <momentree/results/session.hpp>

#include <cstdio>
#include <string>

int main() {
  using namespace momentree;
  const char* text =
      "format = 1\n"
      "[[mechanism]]\nname = \"m\"\n"
      "[[mechanism.body]]\nname = \"rod\"\nmass = 1\ncom = [0.5, 0, 0]\ninertia = [0, 0.1, 0.1]\n"
      "[mechanism.body.joint]\nkind = \"revolute\"\naxis = [0, 1, 0]\n";
  io::Session session = io::load_text(text, "rod.toml", {.overrides = {"integrate.until=0.1"}});
  if (const RunResult run = session.run(); !run) return std::puts(run.reason.c_str()), 1;

  try {
    static_cast<void>(io::load_text("format = 1\nmechanisms = 2\n", "bad.toml"));
  } catch (const std::exception& error) {
    std::puts(error.what());
    return std::string(error.what()).starts_with("bad.toml:2:") ? 0 : 1;
  }
  return 1;
}

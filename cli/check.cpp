#include <cstdio>

#include <cli/commands.hpp>
#include <cli/session.hpp>
#include <cli/text.hpp>

namespace momentree::cli {

namespace {

// What is wrong with a file that reads well shows when it is compiled: state documents that do not fit, events too early.
int check_one(const std::string& file) {
  const io::ReadResult result = io::read_scenario(file);
  std::fputs(io::rendered(result.diagnostics).c_str(), stdout);
  if (!result.scenario) return bad_input;
  Session session(*result.scenario);
  session.schedule();
  const World& world = session.simulation().world();
  std::printf("%s: ok: %s, %s, %s, %s\n", file.c_str(),
              count_text(static_cast<long>(world.mechanisms().size()), "mechanism", "mechanisms").c_str(),
              count_text(world.model().size(), "body", "bodies").c_str(),
              count_text(world.tree().nv(), "degree of freedom", "degrees of freedom").c_str(),
              count_text(static_cast<long>(result.scenario->events.size()), "event", "events").c_str());
  return done;
}

}  // namespace

int check(const std::vector<std::string>& files) {
  int code = done;
  for (const std::string& file : files) {
    int one = bad_input;
    try {
      one = check_one(file);
    } catch (const Error& error) {
      std::printf("%s\n", error.message().c_str());
    }
    if (one != done) code = one;
  }
  return code;
}

}  // namespace momentree::cli

#include "measure.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace peers {
namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Text without quotes or backslashes.
void field(const char* key, const std::string& text) { std::printf("\"%s\": \"%s\", ", key, text.c_str()); }
void field(const char* key, double number) { std::printf("\"%s\": %.3g, ", key, number); }

void check_start(const std::string& engine, const Experiment& experiment, const std::vector<Motion>& found) {
  const auto [off, body] = off_start(experiment, found);
  if (off < 1e-9) return;
  std::fprintf(stderr, "%s, %s: body %s does not start as it should, off by %g\n", engine.c_str(), experiment.name.c_str(),
               experiment.links[body].name.c_str(), off);
  std::exit(1);
}

}  // namespace

std::pair<double, std::size_t> off_start(const Experiment& experiment, const std::vector<Motion>& found) {
  const std::vector<Motion> wanted = start(experiment);
  std::pair<double, std::size_t> worst{0, 0};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Motion &a = found.at(i), &b = wanted[i];
    const double off = (a.R - b.R).norm() + (a.p - b.p).norm() + (a.v - b.v).norm() + (a.w - b.w).norm();
    if (!(off <= worst.first)) worst = {off, i};
  }
  return worst;
}

Judgement judge(const Experiment& experiment, const std::vector<Motion>& after, double elapsed) {
  const std::vector<Motion> right = exact(experiment), before = start(experiment);
  const EnergyLedger wanted = ledger(experiment, right), initial = ledger(experiment, before);
  const EnergyLedger found = ledger(experiment, after);
  double position = 0, velocity = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Link& link = experiment.links[i];
    const Vector3d v = centre_velocity(link, right[i]);
    position = std::max(position, (centre(link, after[i]) - centre(link, before[i]) - elapsed * v).norm());
    velocity = std::max(velocity, (centre_velocity(link, after[i]) - v).norm());
  }
  return {(found.linear - wanted.linear).norm() / wanted.linear.norm(),
          (found.angular - wanted.angular).norm() / wanted.angular.norm(),
          (found.kinetic - wanted.kinetic) / initial.kinetic,
          (initial.kinetic - wanted.kinetic) / initial.kinetic,
          position,
          velocity};
}

void measure(const std::string& engine, const Experiment& experiment, const Way& way) {
  std::unique_ptr<Trial> trial = way.make(experiment);
  check_start(engine, experiment, trial->motions());
  trial->change();
  trial->settle();
  const double elapsed = trial->elapsed();
  const Judgement found = judge(experiment, trial->motions(), elapsed);

  std::vector<double> seconds;
  const Clock::time_point begin = Clock::now();
  while (seconds.size() < 15 || (seconds.size() < 501 && since(begin) < 1.5)) {
    trial = way.make(experiment);
    const Clock::time_point at = Clock::now();
    trial->change();
    seconds.push_back(since(at));
  }
  std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());

  std::printf("{");
  field("experiment", experiment.name);
  field("engine", engine);
  field("way", way.name);
  field("linear", found.linear);
  field("angular", found.angular);
  field("energy", found.energy);
  field("exact_loss", found.exact_loss);
  field("elapsed", elapsed);
  field("position", found.position);
  field("velocity", found.velocity);
  field("microseconds", 1e6 * seconds[seconds.size() / 2]);
  std::printf("\"note\": \"%s\"}\n", way.note.c_str());
  std::fflush(stdout);
}

int run(const std::string& engine, const Ways& ways) {
  for (const Experiment& experiment : experiments()) {
    for (const Way& way : ways(experiment.change)) measure(engine, experiment, way);
  }
  return 0;
}

}  // namespace peers

// Measures evaluations with closed loops.
#include "loops.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace peers {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

double error_of(const std::vector<double>& found, const std::vector<double>& expected) {
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double error = std::abs(found[i] - expected[i]);
    if (!(error <= worst)) worst = error;
    largest = std::max(largest, std::abs(expected[i]));
  }
  return worst / largest;
}

}  // namespace

double worst_error(LoopEvaluator& engine, const LoopModel& model) {
  double worst = 0;
  for (const int k : {0, 1, 0}) {
    engine.evaluate(k);
    const double error = error_of(engine.accelerations(), model.expected[k]);
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

int evaluate_loops(const std::string& engine, const std::vector<LoopWay>& ways, const std::string& only) {
  int wrong = 0;
  const std::string of_name = only.substr(0, only.find('/')),
                    of_way = only.find('/') < only.size() ? only.substr(only.find('/') + 1) : "";
  for (const LoopModel& model : loop_models()) {
    if (model.name.find(of_name) == std::string::npos) continue;
    for (const LoopWay& way : ways) {
      if (!way.fits(model) || way.name.find(of_way) == std::string::npos) continue;
      const std::unique_ptr<LoopEvaluator> engine_with_model = way.make(model);
      const double error = worst_error(*engine_with_model, model);
      if (!(error < allowed_error)) {
        std::fprintf(stderr, "%s, %s, %s: the accelerations are wrong, by %g of the largest one\n", engine.c_str(),
                     way.name.c_str(), model.name.c_str(), error);
        wrong = 1;
        continue;
      }
      double best = HUGE_VAL;
      int turn = 0;
      const int count = static_cast<int>(1 + 300 / model.links.size());
      const Clock::time_point begin = Clock::now();
      for (int repeat = 0; repeat < 20 || since(begin) < 1; ++repeat) {
        const Clock::time_point at = Clock::now();
        for (int i = 0; i < count; ++i) turn ^= 1, engine_with_model->evaluate(turn);
        best = std::min(best, since(at) / count);
      }
      std::printf(
          "{\"model\": \"%s\", \"engine\": \"%s\", \"way\": \"%s\", \"error\": %.2g, \"microseconds\": %.4g, \"note\": \"%s\"}\n",
          model.name.c_str(), engine.c_str(), way.name.c_str(), error, best * 1e6, engine_with_model->note().c_str());
      std::fflush(stdout);
    }
  }
  return wrong;
}

}  // namespace peers

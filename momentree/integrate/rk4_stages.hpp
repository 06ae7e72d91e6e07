#pragma once
// The stages of the classical Runge–Kutta method of order 4, for one world or for worlds in lanes.

namespace momentree {

/// Coordinates, or momenta or velocities, during a step: at its start, their rates at the latest stage, and the next stage, at
/// the end the result. `sum`: scratch.
template <class T>
struct Rk4Variables {
  int n;
  const T *start, *rate;
  T *stage, *sum;

  void begin() const {
    for (int i = 0; i < n; ++i) sum[i] = T(0);
  }
  void advance(double weight, const T& h) const {
    for (int i = 0; i < n; ++i) {
      sum[i] += weight * rate[i];
      stage[i] = start[i] + h * rate[i];
    }
  }
  void end(const T& h6) const {
    for (int i = 0; i < n; ++i) stage[i] = start[i] + h6 * sum[i];
  }
};

/// evaluate(node, weight, q, y): evaluates the rates at t + node·h, which have this weight in the sum.
template <class T, class Evaluate>
void rk4_stages(const T& h, const Rk4Variables<T>& q, const Rk4Variables<T>& y, const Evaluate& evaluate) {
  constexpr double weights[4] = {1, 2, 2, 1}, nodes[5] = {0, 0.5, 0.5, 1, 0};
  q.begin(), y.begin();
  for (int stage = 0; stage < 4; ++stage) {
    evaluate(nodes[stage], weights[stage], stage > 0 ? q.stage : q.start, stage > 0 ? y.stage : y.start);
    q.advance(weights[stage], nodes[stage + 1] * h), y.advance(weights[stage], nodes[stage + 1] * h);
  }
  q.end(h / 6.0), y.end(h / 6.0);
}

}  // namespace momentree

// The experiments, the models and their judge as a shared library, for engines that are measured from Python (wheels/).
#include <algorithm>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "evaluation.hpp"
#include "measure.hpp"

namespace {

using namespace peers;

/// An array of JSON with all digits.
template <class Numbers>
void put(std::ostream& out, const char* key, const Numbers& numbers) {
  out << ", \"" << key << "\": [";
  const char* comma = "";
  for (const double x : numbers) out << comma << x, comma = ", ";
  out << ']';
}
/// By rows.
void put(std::ostream& out, const char* key, const Matrix3d& m) {
  double rows[9];
  for (int i = 0; i < 9; ++i) rows[i] = m(i / 3, i % 3);
  put(out, key, rows);
}

void put(std::ostream& out, const std::vector<Link>& links) {
  out << "\"links\": [";
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const char* joint = link.free ? "free" : link.slides ? "prismatic" : "revolute";
    out << (i > 0 ? ", {" : "{") << "\"name\": \"" << link.name << "\", \"parent\": " << link.parent << ", \"joint\": \"" << joint
        << "\", \"mass\": " << link.mass << ", \"angle\": " << link.angle << ", \"rate\": " << link.rate;
    put(out, "turn", link.turn);
    put(out, "at", link.at);
    put(out, "com", link.com);
    put(out, "inertia", inertia_of(link));
    put(out, "linear", link.linear);
    put(out, "angular", link.angular);
    out << '}';
  }
  out << ']';
}

const std::vector<Experiment>& all_experiments() {
  static const std::vector<Experiment> all = experiments();
  return all;
}
std::vector<EvaluationModel>& all_models() {
  static std::vector<EvaluationModel> all;
  return all;
}

std::vector<Motion> motions_of(const Experiment& experiment, const double* numbers) {
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < experiment.links.size(); ++i, numbers += 18) {
    Motion& motion = motions.emplace_back();
    for (int k = 0; k < 9; ++k) motion.R(k / 3, k % 3) = numbers[k];
    motion.p = Vector3d(numbers + 9), motion.v = Vector3d(numbers + 12), motion.w = Vector3d(numbers + 15);
  }
  return motions;
}

std::string text;  // of the last description

const char* keep(const std::ostringstream& out) {
  text = out.str();
  return text.c_str();
}

}  // namespace

// A motion is 18 numbers: the rotation by rows, the position, the velocity of the origin, the angular velocity.
extern "C" {

/// The experiments as JSON; valid until the next call, as is what the next function returns.
const char* peers_experiments() {
  std::ostringstream out;
  out.precision(17);
  const char* comma = "[";
  for (const Experiment& e : all_experiments()) {
    const char* change = e.change == Change::cut ? "cut" : e.change == Change::lock ? "lock" : "capture";
    out << comma << "{\"name\": \"" << e.name << "\", \"change\": \"" << change << "\", \"body\": " << e.body
        << ", \"to\": " << e.to << ", ";
    put(out, e.links);
    out << ", \"start\": [";
    const char* separator = "";
    for (const Motion& m : start(e)) {
      out << separator << "{\"of\": 0";
      put(out, "R", m.R), put(out, "p", m.p), put(out, "v", m.v), put(out, "w", m.w);
      out << '}';
      separator = ", ";
    }
    out << "]}";
    comma = ", ";
  }
  out << ']';
  return keep(out);
}

/// The models of these files, or without files those of `momentree bench`.
const char* peers_models(int count, const char** files) {
  all_models() = models({files, files + count});
  std::ostringstream out;
  out.precision(17);
  const char* comma = "[";
  for (const EvaluationModel& model : all_models()) {
    const Turns turns = turns_of(model);
    out << comma << "{\"name\": \"" << model.name << "\", \"gravity\": " << gravity << ", \"batch\": " << batch(model)
        << ", \"allowed\": " << allowed_imbalance(model) << ", \"chain\": " << (is_chain(model) ? "true" : "false");
    put(out, "q0", turns.q[0]), put(out, "q1", turns.q[1]), put(out, "u0", turns.u[0]), put(out, "u1", turns.u[1]);
    out << ", ";
    put(out, model.links);
    out << '}';
    comma = ", ";
  }
  out << ']';
  return keep(out);
}

/// How far the bodies are from the start of an experiment.
double peers_off_start(int experiment, const double* motions) {
  const Experiment& e = all_experiments().at(static_cast<std::size_t>(experiment));
  return off_start(e, motions_of(e, motions)).first;
}

/// Fills six numbers: those of Judgement.
void peers_judge(int experiment, const double* motions, double elapsed, double* found) {
  const Experiment& e = all_experiments().at(static_cast<std::size_t>(experiment));
  const Judgement j = judge(e, motions_of(e, motions), elapsed);
  const double all[] = {j.linear, j.angular, j.energy, j.exact_loss, j.position, j.velocity};
  std::copy(all, all + 6, found);
}

/// Of accelerations as Evaluator::accelerations gives them, in one of the two states of a model.
double peers_imbalance(int model, int turn, const double* accelerations) {
  const EvaluationModel& m = all_models().at(static_cast<std::size_t>(model));
  const Turns turns = turns_of(m);
  const std::size_t count = m.links.size() + (m.floating() ? 6 : 0);
  return imbalance(m, turns.q[turn], turns.u[turn], {accelerations, accelerations + count});
}
}

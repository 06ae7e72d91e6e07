#include <momentree/io/results.hpp>

#include <cmath>
#include <utility>

#include <momentree/integrate/integrator.hpp>
#include <momentree/io/energy_columns.hpp>

namespace momentree::io {

Recorder::Recorder(const Model& model, std::vector<JointKinds> joints, double every, const std::string& directory, bool reactions)
    : directory_(directory),
      bodies_(directory_.file("bodies.csv")),
      joints_(directory_.file("joints.csv")),
      body_columns_(model),
      joint_columns_(std::move(joints), reactions),
      every_(every) {
  BodyColumns::header(bodies_.text(), model);
  joint_columns_.header(joints_.text());
  bodies_.flush();
  joints_.flush();
  write_text_file(directory_.file("events.jsonl"), "");
  write_text_file(directory_.file("summary.json"), "{\"status\": \"running, or killed before it could say more\"}\n");
}

void Recorder::record_energy(const Simulation& simulation) {
  books_ = &simulation;
  energy_.emplace(directory_.file("energy.csv"));
  energy_header(energy_->text());
  energy_->flush();
}

bool Recorder::due(double time) {
  if (!(every_ > 0)) return true;
  const double slack = 1e-6 * every_;  // steps land on multiples up to rounding
  if (time < next_ * every_ - slack) return false;
  next_ = std::floor((time + slack) / every_) + 1;
  return true;
}

void Recorder::write_row(const World& world) {
  if (row_time_ == world.time()) {
    bodies_.text().resize(body_row_);
    joints_.text().resize(joint_row_);
    if (energy_) energy_->text().resize(energy_row_);
  } else {
    bodies_.settle();
    joints_.settle();
    body_row_ = bodies_.text().size();
    joint_row_ = joints_.text().size();
    if (energy_) {
      energy_->settle();
      energy_row_ = energy_->text().size();
    }
    row_time_ = world.time();
  }
  body_columns_.row(bodies_.text(), world);
  joint_columns_.row(joints_.text(), world);
  if (energy_) energy_row(energy_->text(), *books_);
}

bool Recorder::observe(const World& world) noexcept {
  try {
    if (row_time_ == world.time() || due(world.time())) write_row(world);
    return true;
  } catch (const Error& error) {
    error_ = error;
    return false;
  }
}

void Recorder::finish(const RunOrigin& origin, const std::string& status, const Simulation& simulation, const Armed& armed,
                      const std::string& model_json, const std::function<void(const std::filesystem::path&)>& last) {
  // What is small and says most comes first: on a full disk it may still fit.
  std::string events;
  for (const Event& event : simulation.events()) events += event_json(event) + '\n';
  write_text_file(directory_.file("summary.json"), summary_json(origin, status, simulation));
  write_text_file(directory_.file("events.jsonl"), events);
  write_text_file(
      directory_.file("final.json"),
      state_json(simulation.world(), armed, is_adaptive(origin.integration.method) ? simulation.step_memory() : StepMemory{}));
  write_text_file(directory_.file("model.json"), model_json);
  write_row(simulation.world());
  bodies_.close();
  joints_.close();
  if (energy_) energy_->close();
  if (last) last(directory_.working());
  if (status != "done") return;
  directory_.publish();
  published_ = true;
}

std::string Recorder::directory() const { return (published_ ? directory_.destination() : directory_.working()).string(); }

}  // namespace momentree::io

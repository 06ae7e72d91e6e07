#pragma once
// Slip within a step: how fast friction turns it, and the direction that friction of slow slip keeps. Without that its sideways
// motion would be unstable, or steps as short as slip is slow.
#include <vector>

#include <momentree/simulate/contact/contact_world.hpp>

namespace momentree {

class SlipInSteps {
 public:
  /// `step`: the length of steps (s); 0: the method adapts them.
  SlipInSteps(const ContactWorld& world, double step) : world_(&world), step_(step) {}

  /// To be called at the start of a step of at most h seconds, which slip that changes quickly shortens.
  void begin(double& h);
  /// The same once its length is known.
  void keep_directions(double h);
  /// True after a step in which slip would have turned if it had not kept its direction: it is taken back, and repeated with
  /// less.
  bool kept_too_much() const;
  void keep_less();

  /// By closed contact at the start of the step; all of them are zero if it does not slip. Its speed (m/s).
  const std::vector<double>& speed() const { return speed_; }
  /// By how much the frictions of its island accelerate its slip if they turn from its side (m/s²).
  double turning(std::size_t contact) const { return turning_[contact]; }
  /// The direction of its slip; zero if that is slower than `slowest_slip`.
  const std::vector<Vec3>& direction() const { return direction_; }
  void forget_directions() { direction_.clear(); }

 private:
  double find_turning(std::size_t contact) const;
  double turned(std::size_t contact, const ContactRows& rows) const;
  double kept(std::size_t contact) const;
  double most_kept(std::size_t contact) const;
  double least_kept(std::size_t contact) const;
  double change_time(std::size_t contact) const;

  const ContactWorld* world_;
  double step_;
  std::vector<double> speed_, turning_;
  std::vector<Vec3> direction_;
};

}  // namespace momentree

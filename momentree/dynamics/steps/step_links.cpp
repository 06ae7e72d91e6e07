#include <momentree/dynamics/steps/step_links.hpp>

#include <algorithm>

#include <momentree/base/check.hpp>
#include <momentree/dynamics/steps/step_library.hpp>

namespace momentree {

namespace {
constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

bool StepLinks::available() const {
  if (scalar_.interpreted[0] != nullptr) return true;
  return scalar_.width != StepWidth::none && StepLibrary::of_process().available(scalar_.width);
}

bool StepLinks::serves(Kind kind, Variant variant) const { return available() && derive::has_steps(kind, variant); }

void StepLinks::begin(std::size_t bodies, bool general, bool gravity) {
  if (general != general_ || links_.size() > 2 * bodies + 64)  // mostly those of earlier topologies
    links_.clear(), constants_.clear(), singles_.clear();
  general_ = general, gravity_ = gravity;
  ++rebuilt_, steps_.clear(), interpreted_.clear();
}

int StepLinks::find(Kind kind, Variant variant, derive::BodyPlace place, const LinkConstants& link, int same, int former) {
  derive::StepKey form = derive::key_of(kind, variant == Variant::armature, place, link);
  form.passes = scalar_.passes, form.gravity = gravity_ || !in_momenta(scalar_.passes);
  form.fewest = scalar_.interpreted[0] != nullptr;
  const auto fits = [&](int other) {
    return other >= 0 && at(other) < links_.size() && links_[at(other)].form == form &&
           derive::same_numbers(links_[at(other)].numbers, link);
  };
  int found = fits(same) ? same : fits(former) ? former : -1;
  for (std::size_t i = 0; found < 0 && i < recent_.size(); ++i)
    if (fits(recent_[i])) found = recent_[i];
  if (found < 0) {
    Link own{derive::numbers_of(link), form};
    derive::StepKey key = form, any = form;
    derive::add_pattern(own.numbers, key), derive::add_general_pattern(any);
    if (!general_) own.step = StepLibrary::of_process().get(key);
    if (own.step == nullptr) own.step = StepLibrary::of_process().get(any);
    own.constants = constants_.size();
    constants_.resize(constants_.size() + own.step->step.constants());
    own.step->step.evaluate_constants(own.numbers, constants_.data() + own.constants);
    links_.push_back(own);
    found = static_cast<int>(links_.size()) - 1;
    recent_[next_] = found, next_ = (next_ + 1) % recent_.size();
  }
  Link& one = links_[at(found)];
  if (one.used == rebuilt_) return found;
  one.used = rebuilt_;
  if (std::ranges::find(steps_, one.step) == steps_.end()) steps_.push_back(one.step);
  return found;
}

const derive::Step* StepLinks::step(int link) const { return &links_[at(link)].step->step; }

std::size_t StepLinks::record(int link) const { return at(links_[at(link)].step->step.record()); }

bool StepLinks::functions(int link, const derive::Handing& outward, const derive::Handing& inward, StepFunctions& to,
                          const void*& constants) {
  const Link& own = links_[at(link)];
  constants = constants_.data() + own.constants;
  if (scalar_.interpreted[0] != nullptr) {
    to = scalar_.interpreted;
    const auto [known, is_new] = passes_.try_emplace({own.step, inward.adds});
    const machine::Target target{.number = static_cast<int>(scalar_.size), .fused = false};
    for (std::size_t pass = 0; is_new && pass < own.step->step.passes(); ++pass) {
      machine::Function& function = known->second[pass];
      function = own.step->step.function(pass, {.adds = pass == own.step->step.inward() && inward.adds}, target);
      room_.most = std::max(room_.most, function.values.size());
      values_.resize(room_.most * scalar_.size / sizeof(double) + 1), room_.values = values_.data();
    }
    interpreted_.push_back({&known->second, constants_.data() + own.constants, &room_});
    constants = &interpreted_.back();
    return true;
  }
  for (std::size_t pass = 0; pass < own.step->step.passes(); ++pass) {
    const derive::Handing& how = pass == own.step->step.inward() ? inward : outward;
    to[pass] = StepLibrary::of_process().function(*own.step, scalar_.width, pass, how);
    if (to[pass] == nullptr) return false;
  }
  if (scalar_.width < StepWidth::float_4) return true;
  if (singles_.size() != constants_.size()) singles_.assign(constants_.begin(), constants_.end());
  constants = singles_.data() + own.constants;
  return true;
}

}  // namespace momentree

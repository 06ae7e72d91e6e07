#pragma once
// Speed with which two bodies slip on each other (m/s); without a threshold, whether they do: 1 or 0.
#include <momentree/simulate/events/of_contact.hpp>

namespace momentree::quantities {

struct Slip : OfContact {
  std::string_view key() const override { return "slip"; }
  const char* summary() const override {
    return "Largest speed of slip of two bodies, 0 if they do not touch (m/s); without a threshold: they begin to slip";
  }
  Dimension dimension() const override { return begins_ ? dimension::number : dimension::speed; }
  bool never_negative() const override { return true; }
  bool has_threshold() const override { return !begins_; }
  bool drop_threshold() override { return begins_ = true; }
  bool needs_friction() const override { return begins_; }
  bool is_impulsive() const override { return begins_; }  // the instant is that of an event, which is located anyway
  std::optional<double> value(const World& world, std::span<const Event> now) const override {
    if (!exist(world)) return std::nullopt;
    if (begins_ && begins(world, now)) return 1;
    bool slips = false;
    double most = 0;
    each_point(world,
               [&](const ContactPoint& point, double) { slips = slips || point.slips, most = std::max(most, norm(point.slip)); });
    return begins_ ? (slips ? 1.0 : 0.0) : most;
  }
  bool begins(const World& world, std::span<const Event> now) const override {
    return std::any_of(now.begin(), now.end(),
                       [&](const Event& event) { return event.name.starts_with(key()) && is_of(world, event); });
  }

 private:
  bool begins_ = false;
};

}  // namespace momentree::quantities

#pragma once
// What scheduled events consist of, for archives: their actions and conditions are keys with arguments.
#include <memory>
#include <string_view>

#include <momentree/results/checkpoint/run_fields.hpp>
#include <momentree/scenario/events/argument_kinds.hpp>

namespace momentree::io {

/// An action or a quantity; throws Error for one that only a program has. `make`: make_action or make_quantity.
template <class Base>
void keyed(ArchiveWriter& archive, const Base& what, std::shared_ptr<Base> (*make)(std::string_view)) {
  if (make(what.key()) == nullptr)
    throw_error({"'" + std::string(what.key()) + "' is part of a program, and cannot be saved", "", ""});
  archive(std::string(what.key()));
  const_cast<Base&>(what).arguments([&](const Argument& a) { kind_of(a).write(archive, a); });  // which reads them
}
template <class Base>
std::shared_ptr<Base> keyed(ArchiveReader& archive, std::shared_ptr<Base> (*make)(std::string_view)) {
  std::string key;
  archive(key);
  std::shared_ptr<Base> what = make(key);
  archive.require(what != nullptr);
  what->arguments([&](const Argument& a) { kind_of(a).read_back(archive, a); });
  return what;
}

inline void fields(ArchiveWriter& archive, const Action& action) { keyed(archive, *action, make_action); }
inline void actions(ArchiveWriter& archive, const std::vector<Action>& all) { archive(all); }
inline void actions(ArchiveReader& archive, std::vector<Action>& all) {
  std::size_t count = 0;
  for (archive(count); count > 0; --count) all.emplace_back(std::shared_ptr<const ActionBase>(keyed(archive, make_action)));
}

template <class Archive>
void settings(Archive& archive, Part<Archive, Condition>& c) {
  archive(c.threshold, c.above, c.repeats, c.exact, c.least_norm, c.hysteresis, c.duration);
}
inline void condition(ArchiveWriter& archive, const std::optional<Condition>& c) {
  archive(c.has_value());
  if (!c) return;
  archive(c->what->has_threshold());
  keyed(archive, *c->what, make_quantity);
  settings(archive, *c);
}
inline void condition(ArchiveReader& archive, std::optional<Condition>& c) {
  bool given = false, has_threshold = false;
  archive(given);
  if (!given) return;
  archive(has_threshold);
  const std::shared_ptr<momentree::Quantity> what = keyed(archive, make_quantity);
  if (!has_threshold && what->has_threshold()) archive.require(what->drop_threshold());
  settings(archive, c.emplace(what, 0, false));
}

/// Without its status, which is in QueueState.
template <class Archive>
void fields(Archive& archive, Part<Archive, EventQueue::Entry>& e) {
  archive(e.event.name, e.event.named, e.time, e.after, e.delay, e.period, e.from, e.rank);
  actions(archive, e.event.actions);
  condition(archive, e.condition);
}

}  // namespace momentree::io

// Branches of one body, or mechanisms, that are built alike: the sweeps take them two at once, in the lanes of one scalar.
#include <algorithm>
#include <array>

#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {
constexpr int few = 3;  // bodies: of shorter branches two are swept as fast one by one
}

/// Whether the `count` bodies from `place` on, a body and all outboard of it, hang together as those from `other` on do.
bool Tree::alike(int place, int other, int count) const {
  bool any_pin = false;
  for (int i = 0; i < count; ++i) {
    const Class& a = class_[at(order_[at(place + i)])];
    const Class& b = class_[at(order_[at(other + i)])];
    const bool pin = a.kind == Kind::revolute && a.variant == Variant::plain;
    any_pin = any_pin || pin;
    const unsigned what = i == 0 ? flow::tip | flow::fork : flow::tip | flow::fork | flow::first | flow::last;
    if (!(a == b) || !(pin || a.kind == Kind::weld) || ((flows_[at(place + i)] ^ flows_[at(other + i)]) & what) != 0)
      return false;
  }
  return any_pin;
}

/// Pairs a body and its next siblings: each with the nearest before it that is like it, of the last few that have no twin.
bool Tree::pair_siblings(int first) {
  std::array<int, 8> waiting{};
  std::size_t count = 0;
  bool any = false;
  for (int b = first; b >= 0; b = next_sibling_[at(b)]) {
    const int place = place_[at(b)], size = size_[at(place)];
    if (size < few || (parent_[at(b)] < 0 && in_a_plane(place))) continue;  // has a faster way
    std::size_t i = count;
    while (i > 0 && !(size_[at(waiting[i - 1])] == size && alike(waiting[i - 1], place, size))) --i;
    if (i > 0) {
      any = true;
      twin_[at(place)] = waiting[i - 1], twin_[at(waiting[i - 1])] = place;
      std::copy(waiting.begin() + static_cast<std::ptrdiff_t>(i), waiting.begin() + static_cast<std::ptrdiff_t>(count),
                waiting.begin() + static_cast<std::ptrdiff_t>(i) - 1);
      --count;
      continue;
    }
    if (count == waiting.size()) std::copy(waiting.begin() + 1, waiting.end(), waiting.begin()), --count;
    waiting[count++] = place;
  }
  return any;
}

/// From order, flows and segments.
void Tree::find_twins() {
  const int count = static_cast<int>(order_.size());
  size_.assign(at(count), 1), twin_.assign(at(count), -1);
  for (int place = count - 1; place > 0; --place)
    if (const int outer = parent_[at(order_[at(place)])]; outer >= 0) size_[at(place_[at(outer)])] += size_[at(place)];
  has_twins_ = pair_siblings(first_root_);
  for (int place = 0; place < count;) {
    const int b = order_[at(place)];
    if (twin_[at(place)] >= 0 || (parent_[at(b)] < 0 && in_a_plane(place))) {
      place += size_[at(place)];
      continue;
    }
    if ((flows_[at(place)] & flow::fork) != 0) has_twins_ = pair_siblings(first_child_[at(b)]) || has_twins_;
    ++place;
  }
  if (!has_twins_) return;
  cut_segments();
}

/// Where branches with twins begin and end; and the constants of both.
void Tree::cut_segments() {
  twin_segments_.clear(), twin_links_.clear();
  int begin = 0, end = 0, twin = 0, links = 0;  // of the branch at hand; its twin's place; the first of its constants
  for (const Segment& whole : segments_) {
    Segment piece = whole;
    for (int place = whole.begin; place < whole.end; ++place) {
      const bool branch = place >= end && twin_[at(place)] >= 0;
      if (branch) {
        begin = place, end = place + size_[at(place)], twin = twin_[at(place)];
        int& of_first = twin_[at(std::min(place, twin))];  // from here on not its twin, but where its constants are
        if (place < twin) of_first = static_cast<int>(twin_links_.size());
        links = of_first;
      }
      if (place > whole.begin && (branch || place == end)) piece.end = place, twin_segments_.push_back(piece), piece = whole;
      if (place == whole.begin || branch || place == end) {
        piece.begin = place, piece.branch = branch;
        if (place < end) piece.twin = twin + place - begin, piece.links = links + place - begin;
      }
      if (place < end && place < twin)
        twin_links_.emplace_back(links_[at(order_[at(place)])], links_[at(order_[at(twin + place - begin)])]);
    }
    twin_segments_.push_back(piece);
  }
}

}  // namespace momentree

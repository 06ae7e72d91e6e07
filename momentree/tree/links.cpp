#include <momentree/tree/links.hpp>

#include <momentree/base/check.hpp>

namespace momentree {

// Updates pointers to own links after these moved away from `from`.
void LinkTable::move(const LinkConstants* from, std::size_t count) {
  if (count == 0 || from == own_.data()) return;
  const std::less<> before;
  for (const LinkConstants*& link : at_)
    if (link != nullptr && !before(link, from) && before(link, from + count)) link = own_.data() + (link - from);
}

LinkTable& LinkTable::operator=(const LinkTable& other) {
  if (this == &other) return *this;
  at_ = other.at_;
  shared_ = other.shared_;
  own_ = other.own_;
  own_frames_ = other.own_frames_;
  move(other.own_.data(), other.own_.size());
  return *this;
}

LinkConstants& LinkTable::own(std::size_t body) {
  const LinkConstants* const link = at_[body];
  if (link != nullptr && is_own(link)) return own_[static_cast<std::size_t>(link - own_.data())];
  MT_REQUIRE(own_.size() < own_.capacity(), "there is room for a separate link of every body");
  const KernelFrame frame = link != nullptr ? this->frame(body) : KernelFrame{};
  own_.push_back(link != nullptr ? *link : LinkConstants{});
  own_frames_.push_back(frame);
  at_[body] = &own_.back();
  return own_.back();
}

void LinkTable::give_back(std::size_t body, std::size_t number) {
  MT_REQUIRE(!own_.empty() && at_[body] == &own_.back(), "the body's own link was the last to be made");
  own_.pop_back(), own_frames_.pop_back();
  share(body, number);
}

void LinkTable::resize(std::size_t bodies) {
  at_.resize(bodies, nullptr);
  if (own_.capacity() >= bodies) return;
  const LinkConstants* const from = own_.data();
  reserve(own_, bodies), reserve(own_frames_, bodies);
  move(from, own_.size());
}

void LinkTable::clear(std::shared_ptr<const SharedLinks> shared) {
  shared_ = std::move(shared);
  own_.clear(), own_frames_.clear();
}

}  // namespace momentree

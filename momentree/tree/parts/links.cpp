#include <momentree/tree/parts/links.hpp>

#include <functional>

#include <momentree/base/check.hpp>
#include <momentree/joint/link_constants.hpp>
#include <momentree/tree/kernel_frame.hpp>

namespace momentree::detail {

SharedLinks::SharedLinks() = default;
SharedLinks::~SharedLinks() = default;

LinkTable::LinkTable() = default;
LinkTable::LinkTable(const LinkTable& other) { *this = other; }
LinkTable::LinkTable(LinkTable&&) noexcept = default;
LinkTable& LinkTable::operator=(LinkTable&&) noexcept = default;
LinkTable::~LinkTable() = default;

bool LinkTable::is_own(const LinkConstants* link) const {
  const std::less<> before;
  return !before(link, own_.data()) && before(link, own_.data() + own_.size());
}

const KernelFrame& LinkTable::frame(std::size_t body) const {
  const LinkConstants* const link = at_[body];
  return is_own(link) ? own_frames_[static_cast<std::size_t>(link - own_.data())]
                      : shared_->frames[static_cast<std::size_t>(link - shared_->links.data())];
}

KernelFrame& LinkTable::own_frame(std::size_t body) {
  const LinkConstants& link = own(body);
  return own_frames_[static_cast<std::size_t>(&link - own_.data())];
}

void LinkTable::share(std::size_t body, std::size_t number) { at_[body] = shared_->links.data() + number; }

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

}  // namespace momentree::detail

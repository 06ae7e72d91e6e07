#pragma once
// The links of a tree: those of the model's own topology are shared by all its trees, what changes made is the tree's own.
#include <functional>
#include <memory>
#include <vector>

#include <momentree/joint/link_constants.hpp>
#include <momentree/tree/reserved.hpp>

namespace momentree {

/// Where the kernels' frame of a body stands in the user's frame of that body.
struct KernelFrame {
  Mat3 R = identity3<double>();
  Vec3 r{};
};

/// Links and frames, equal pairs once: a rope of a million bodies has three.
struct SharedLinks {
  std::vector<LinkConstants> links;
  std::vector<KernelFrame> frames;
};

/// Link and frame by body. No more than a pointer for each body, until a change makes a link of its own for it.
class LinkTable {
 public:
  LinkTable() = default;
  LinkTable(const LinkTable& other) { *this = other; }
  LinkTable(LinkTable&&) noexcept = default;
  LinkTable& operator=(const LinkTable& other);
  LinkTable& operator=(LinkTable&&) noexcept = default;
  ~LinkTable() = default;

  bool has(std::size_t body) const { return at_[body] != nullptr; }
  const LinkConstants& operator[](std::size_t body) const { return *at_[body]; }
  const KernelFrame& frame(std::size_t body) const {
    const LinkConstants* const link = at_[body];
    return is_own(link) ? own_frames_[static_cast<std::size_t>(link - own_.data())]
                        : shared_->frames[static_cast<std::size_t>(link - shared_->links.data())];
  }

  /// The body's own link and frame, at first those that it shared. Does not allocate.
  LinkConstants& own(std::size_t body);
  KernelFrame& own_frame(std::size_t body) {
    const LinkConstants& link = own(body);
    return own_frames_[static_cast<std::size_t>(&link - own_.data())];
  }

  /// Room for that many bodies, all with links of their own. Where the number grows, links move.
  void resize(std::size_t bodies);
  /// From here on these are shared: nobody has a link of its own, and each is to be given one by `share`.
  void clear(std::shared_ptr<const SharedLinks> shared);
  void share(std::size_t body, std::size_t number) { at_[body] = shared_->links.data() + number; }
  void leave(std::size_t body) { at_[body] = nullptr; }
  /// The same for a body whose own link was the last to be made: its place is free again.
  void give_back(std::size_t body, std::size_t number);

 private:
  bool is_own(const LinkConstants* link) const {
    const std::less<> before;
    return !before(link, own_.data()) && before(link, own_.data() + own_.size());
  }
  void move(const LinkConstants* from, std::size_t count);

  std::vector<const LinkConstants*> at_;
  std::shared_ptr<const SharedLinks> shared_;
  Reserved<LinkConstants> own_;
  Reserved<KernelFrame> own_frames_;
};

}  // namespace momentree

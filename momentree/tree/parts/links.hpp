#pragma once
// The links of a tree: those of the model's topology are shared by all its trees, those that changes made belong to the tree.
#include <memory>
#include <vector>

#include <momentree/base/reserved.hpp>

namespace momentree {
struct KernelFrame;
struct LinkConstants;
}  // namespace momentree

namespace momentree::detail {

/// Distinct pairs of link and frame: a rope of a million bodies has three.
struct SharedLinks {
  SharedLinks();
  ~SharedLinks();
  SharedLinks(const SharedLinks&) = delete;
  SharedLinks& operator=(const SharedLinks&) = delete;
  std::vector<LinkConstants> links;
  std::vector<KernelFrame> frames;
};

/// Link and frame by body: a single pointer per body, until a change gives the body its own link.
class LinkTable {
 public:
  LinkTable();
  LinkTable(const LinkTable& other);
  LinkTable(LinkTable&&) noexcept;
  LinkTable& operator=(const LinkTable& other);
  LinkTable& operator=(LinkTable&&) noexcept;
  ~LinkTable();

  bool has(std::size_t body) const { return at_[body] != nullptr; }
  const LinkConstants& operator[](std::size_t body) const { return *at_[body]; }
  const KernelFrame& frame(std::size_t body) const;

  /// The body's own link, initially a copy of the shared one. Does not allocate.
  LinkConstants& own(std::size_t body);
  KernelFrame& own_frame(std::size_t body);

  /// Reserves space for that many bodies, each with its own link. Links move if the number grows.
  void resize(std::size_t bodies);
  /// Sets the shared list. Afterwards no body has a link; assign each one with `share`.
  void clear(std::shared_ptr<const SharedLinks> shared);
  void share(std::size_t body, std::size_t number);
  void leave(std::size_t body) { at_[body] = nullptr; }
  /// Like `share`, for a body whose own link was made last; its storage is freed.
  void give_back(std::size_t body, std::size_t number);

 private:
  bool is_own(const LinkConstants* link) const;
  void move(const LinkConstants* from, std::size_t count);

  std::vector<const LinkConstants*> at_;
  std::shared_ptr<const SharedLinks> shared_;
  Reserved<LinkConstants> own_;
  Reserved<KernelFrame> own_frames_;
};

}  // namespace momentree::detail

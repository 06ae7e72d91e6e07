#pragma once
// Names of joints and mechanisms across changes of the topology.
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <momentree/model/model.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Names of all mechanisms of a world. Copies share them: most events change none.
class MechanismNames {
 public:
  using Shared = std::shared_ptr<const std::vector<std::string>>;
  MechanismNames(std::vector<std::string> all = {}) : all_(std::make_shared<const std::vector<std::string>>(std::move(all))) {}
  explicit MechanismNames(Shared all) : all_(std::move(all)) {}
  operator const std::vector<std::string>&() const { return *all_; }
  auto begin() const { return all_->begin(); }
  auto end() const { return all_->end(); }
  std::size_t size() const { return all_->size(); }
  const std::string& operator[](std::size_t i) const { return (*all_)[i]; }
  friend bool operator==(const MechanismNames& a, const MechanismNames& b) { return a.all_ == b.all_ || *a.all_ == *b.all_; }
  const Shared& shared() const { return all_; }

 private:
  Shared all_;
};

/// Names of joints by joint number, and of mechanisms by root body. The part that keeps the root keeps the mechanism's name. A
/// part that breaks off is named after its root body, and so is the free joint that carries it (with the suffix "~free" if
/// another joint has that name). A joint that a weld or an attachment makes has the name that its event gives it.
class Names {
 public:
  Names() = default;
  explicit Names(const Model& model);

  const std::string& joint(int number) const {
    return number >= first_loop ? loops_[known_loop(number)] : joints_[known(number)];
  }
  /// Number of the joint that has that name now; −1 if there is none.
  int find_joint(std::string_view name) const;
  /// The same for repeated look-ups: `number`, −1 at first, caches the result, which is used for as long as that joint has that
  /// name.
  int find_joint(std::string_view name, std::atomic<int>& number) const {
    const int last = number.load(std::memory_order_relaxed);
    if (last >= 0 && has(last) && joint(last) == name) return last;
    const int found = find_joint(name);
    number.store(found, std::memory_order_relaxed);
    return found;
  }
  const std::string& mechanism(int root) const { return mechanisms_[known(root)]; }

  /// The name that a free root joint of that body, with joint number `number`, would get.
  std::string free_joint(const std::string& body, int number) const;

  void name_joint(int number, std::string name);
  void name_mechanism(int root, std::string name) { mechanisms_[known(root)] = std::move(name); }
  /// The mechanism rooted at `from` is now rooted at `to`.
  void move_mechanism(int from, int to);
  /// A body that was added to the world, and its joint of the same number.
  void add(std::string joint, std::string mechanism);
  /// A joint that left the world: its name may be used again.
  void remove_joint(int number);
  /// The loop joint with that number, as a handle.
  void add_loop(int number, std::string name);
  /// One more than the largest number of a loop joint so far.
  int loops_end() const { return first_loop + static_cast<int>(loops_.size()); }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  std::size_t known(int number) const {
    MT_REQUIRE(at(number) < joints_.size(), "the world has or had a body and a joint of that number");
    return at(number);
  }
  std::size_t known_loop(int number) const {
    MT_REQUIRE(number < loops_end(), "the world has or had a joint of that number");
    return at(number - first_loop);
  }
  bool has(int number) const { return number >= first_loop ? number < loops_end() : at(number) < joints_.size(); }
  std::vector<std::string> joints_, loops_;
  std::vector<std::string> mechanisms_;  // by root body
  std::unordered_map<std::string, int, detail::NameHash, std::equal_to<>> numbers_;
};

}  // namespace momentree

#pragma once
// Pairs whose contacts are stepped through instead of being located: of which bodies, and how near each other these are.
#include <vector>

#include <momentree/dynamics/loops/islands.hpp>
#include <momentree/simulate/contact/contact_pairs.hpp>

namespace momentree {

class SteppedPairs {
 public:
  SteppedPairs(const ContactWorld& world, const ContactPairs& pairs) : world_(&world), pairs_(&pairs) {}

  /// The bodies that are stepped through, by number; none: all or no bodies are. Their closed contacts open.
  void set(std::vector<bool> bodies);
  bool any() const { return !bodies_.empty(); }
  bool holds(int body) const {
    return body >= 0 && static_cast<std::size_t>(body) < bodies_.size() && bodies_[static_cast<std::size_t>(body)];
  }
  /// The method steps through all contacts.
  void set_all(bool all) { all_ = all; }
  /// True if the contacts of this body are stepped through, in steps that do so for all bodies or for some.
  bool steps(int body) const { return all_ || holds(body); }
  enum class Handling : unsigned char { located, stepped, between };
  Handling handling(const ContactPair& pair) const;
  bool is_located(int pair) const { return handling((*pairs_)[pair]) == Handling::located; }

  /// Contacts that touch at present, whether they are closed or not, of pairs that are located. Those of other pairs, which steps
  /// leave small gaps, if they are nearer than `open` (m); all pairs are, if `all` says so.
  std::vector<Contact> touching(double open = 0, bool all = false) const;
  /// Joins the islands of bodies that touch at present, or whose contacts are closed.
  void join_touching(Islands& islands) const;
  /// The bodies of pairs that touch, one of which is stepped through and one of which is not.
  std::vector<int> touched() const;
  /// Appends the points at which solids overlap at present, or are nearer than `within` (m), without those of bodies that stay
  /// where they are, if `stays` says so by body.
  void add_near(double within, std::vector<Contact>& out, const std::vector<bool>& stays = {}) const;
  /// Joins the islands of bodies of which solids may be nearer than `within` (m).
  void join_near(double within, Islands& islands) const;
  /// The fastest point of any solid (m/s).
  double fastest() const;

  /// A step of at most h seconds in which no body passes through another, but not much shorter: pairs that are faster are noted.
  double limit_step(double h);
  /// Bodies of pairs that were noted which did pass through each other in the step, on a straight path: where (m), on which side
  /// the first one was before, and the length of steps (s) in which they would not have done so.
  struct Passed {
    int a, b;
    Vec3 point, side;
    double step;
  };
  std::vector<Passed> passed();

 private:
  bool is_left_out(const ContactPair& pair) const { return any() && handling(pair) != Handling::stepped; }
  Vec3 centre_in_other(const ContactPair& pair) const;

  const ContactWorld* world_;
  const ContactPairs* pairs_;
  std::vector<bool> bodies_;
  bool all_ = false;
  struct Fast {
    int pair;
    Vec3 from;  // the centre of its first solid at the start of the step, in the frame of the second one's body (m)
  };
  std::vector<Fast> fast_;
};

}  // namespace momentree

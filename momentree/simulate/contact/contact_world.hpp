#pragma once
// What contact code reads and changes of a world: where its bodies are, and which contacts are closed.
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/world/world_edit.hpp>

namespace momentree {

/// The numbers of contacts in a list, by their pair and in the order of the list.
class ContactsByPair {
 public:
  using Entry = std::pair<int, std::size_t>;  // pair, number
  ContactsByPair() = default;
  explicit ContactsByPair(std::span<const Contact> all);
  std::span<const Entry> of(int pair) const;

 private:
  std::vector<Entry> sorted_;
};

class ContactWorld {
 public:
  ContactWorld(World& world, Evaluator& evaluator) : world_(&world), evaluator_(&evaluator) {}
  static Evaluator evaluator_of(World& world) { return {world.tree(), world.edit().workspace()}; }

  World& world() const { return *world_; }
  const Model& model() const { return world_->model(); }
  const Tree& tree() const { return world_->tree(); }
  State& state() const { return world_->edit().state(); }
  Workspace<double>& workspace() const { return world_->edit().workspace(); }
  Evaluator& evaluator() const { return *evaluator_; }
  const double* q() const { return state().q().data(); }
  double time() const { return world_->time(); }
  double gravity() const { return norm(model().gravity()); }  ///< m/s²
  const Connections& connections() const { return world_->edit().connections(); }
  std::vector<int>& overlapping() const { return world_->edit().constraints().overlapping; }     ///< as of WorldConstraints
  std::vector<Contact>& former() const { return world_->edit().constraints().former_contacts; }  ///< as of WorldConstraints

  /// Evaluates the state, which counts as an evaluation of the run.
  void evaluate() const { (*evaluator_)(state()); }
  /// The rows of closed contacts, with their forces in the present state.
  const ContactRows& closed_rows() const;
  /// Places contacts where bodies are at present.
  void place(std::span<const Contact> contacts, ContactRows& rows) const;
  /// The same, with their accelerations.
  void accelerate(std::span<const Contact> contacts, ContactRows& rows) const;
  /// What impulses at contacts that are placed change.
  void find_mobility(std::span<const Contact> contacts, ContactRows& rows) const;

  contact::Place place(int body) const;
  bool is_gone(int body) const { return body >= 0 && !world_->alive({body}); }
  bool is_gone(const Contact& c) const { return is_gone(c.a) || is_gone(c.b); }
  std::string name_of(int body) const { return model().body_name({body}); }
  bool can_be_taut(int spring) const;
  /// Contacts of each island, in their order.
  std::vector<std::vector<Contact>> by_island(const std::vector<Contact>& contacts) const;

  std::span<const Contact> closed() const { return tree().contacts(); }
  std::vector<Contact> closed_copy() const { return {closed().begin(), closed().end()}; }
  void close(std::vector<Contact> contacts) const;
  void open() const { close({}); }
  std::span<const ContactsByPair::Entry> closed_of(int pair) const;
  bool is_closed(int pair, std::uint64_t id) const;

 private:
  World* world_;
  Evaluator* evaluator_;
  mutable ContactsByPair by_pair_;
  mutable std::uint64_t by_pair_of_ = 0;  // the revision of the tree whose contacts these are
};

}  // namespace momentree

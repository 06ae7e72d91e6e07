#pragma once
// Contacts before a run begins: those that it will close, and those that were closed in the run that it continues.
#include <vector>

#include <momentree/simulate/contact/contact_choice.hpp>
#include <momentree/simulate/stepping/pair_overlaps.hpp>

namespace momentree {

/// Between runs, where forces or the state may have changed, contacts that will close without an impact are pending:
/// accelerations and forces include theirs, and the run opens them first, and closes them with their events.
class ContactsBetweenRuns {
 public:
  /// `step`: the length of steps (s); 0: the method adapts them.
  ContactsBetweenRuns(const ContactGeometry& geometry, double step)
      : geometry_(&geometry), step_(step), choice_(geometry.world, geometry.pairs, step) {}

  /// Finds the pending contacts. `method_steps`: the method steps through all contacts.
  void find_pending(bool method_steps);
  bool has_pending() const;
  /// The closed contacts, without those that are pending.
  std::vector<Contact> closed() const;
  /// WorldConstraints::former_contacts; an empty list leaves them as they are.
  void set_former(std::vector<Contact> closed) const;
  bool has_former() const { return !geometry_->world.former().empty(); }
  void forget_former() const { geometry_->world.former().clear(); }
  /// Opens pending contacts, and closes the former ones again if the bodies still touch there and do not part.
  void open_pending();
  /// Closes contacts of a document; those that do not touch stay open.
  void close_from_document(const Forest& forest) const;
  /// −1 if the closed contacts fit the state and the forces. Otherwise the largest force that contacts cannot exert, relative to
  /// the largest force of its island; or the largest number, if bodies overlap or do not stay together.
  double excess_of_closed() const;

 private:
  bool choose(const std::vector<Contact>& touching, bool method_steps, std::vector<Contact>& chosen);
  bool stay_together(const std::vector<Contact>& contacts) const;
  std::vector<Contact> placed_again(const std::vector<Contact>& described) const;

  const ContactGeometry* geometry_;
  double step_;
  ContactChoice choice_;
};

}  // namespace momentree

#pragma once
// The rows of many contacts, each with the degrees of freedom of its two mechanisms only.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <momentree/contact/many_points.hpp>
#include <momentree/dynamics/contacts/body_response.hpp>
#include <momentree/dynamics/contacts/contacts.hpp>

namespace momentree {

/// Degrees of freedom numbered mechanism by mechanism, and the bodies of those that have so many that points act on bodies. With
/// closed loops all mechanisms count as one.
class ContactParts {
 public:
  /// Begins with a problem without points, for the tree's present topology.
  void begin(const Tree& tree, contact::ManyPoints& many);

  /// Adds the points of contacts that are placed: their rows J and Y = M⁻¹ Jᵀ. Requires the factors of an evaluation at q.
  void add_points(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                  const ContactRows& rows, contact::ManyPoints& many);

  /// Adds a stop of a joint as a point without tangents: its "normal" is a degree of freedom of the body's joint, times `sign`.
  void add_stop(const Tree& tree, const double* q, Workspace<double>& workspace, int body, int dof, double sign,
                contact::ManyPoints& many);

  /// Adds the moments of a contact as a point: unit impulses are moments of `length` (m), so that its velocities have that unit,
  /// too. Returns its number.
  std::size_t add_moments(const Tree& tree, const double* q, Workspace<double>& workspace, const Contact& contact,
                          const contact::Touch& touch, double length, contact::ManyPoints& many);

  /// Adds what a motion of these points is to an array packed as p.
  void add_to(const Tree& tree, const contact::ManyPoints& many, contact::LinksMotion& motion, double* packed) const;

 private:
  struct Range {
    int begin, end;                  ///< bodies in the tree's order
    int dofs = 0;                    ///< of its joints
    int first_dof = 0, end_dof = 0;  ///< in dof_; none if it has links
    int first_link = -1;             ///< −1: it has none
    bool known = false;              ///< its links are
  };
  /// Of a body: the joint forces E of a unit wrench along each of its six axes, and M⁻¹ E, as six rows of each.
  struct Response {
    std::size_t at = SIZE_MAX;  ///< in responses_; SIZE_MAX: not known
    int points = 0;             ///< at which the body is touched
  };
  /// Three wrenches on each of two bodies, in their kernel frames.
  using Wrenches = std::array<std::array<Force<double>, 3>, 2>;
  void count_points(const Tree& tree, std::span<const Contact> contacts);
  void solve(const Tree& tree, const double* q, Workspace<double>& workspace, const Range& range);
  const double* response(const Tree& tree, const double* q, Workspace<double>& workspace, int body);
  void find_links(const Tree& tree, const double* q, const Workspace<double>& workspace, int mechanism, contact::Links& links);
  void add_link_part(const Tree& tree, const double* q, const Workspace<double>& workspace, int body,
                     std::span<const Force<double>> rows, contact::ManyPoints& many, contact::ManyPoints::Part& part);
  /// Where the numbers of a mechanism without links begin in a motion.
  int part_begin(const Range& range) const { return 6 * static_cast<int>(body_of_.size()) + range.first_dof; }
  void add_part(const Tree& tree, const double* q, Workspace<double>& workspace, int mechanism, const Contact& contact,
                const Wrenches& wrenches, contact::ManyPoints& many, contact::ManyPoints::Part& part);
  void add_point(const Tree& tree, const double* q, Workspace<double>& workspace, const Contact& contact,
                 const Wrenches& wrenches, contact::ManyPoints& many);

  std::vector<Range> ranges_;
  std::vector<int> dof_;           // places in arrays packed as p
  std::vector<int> mechanism_of_;  // by body
  std::vector<int> link_of_;       // by body; −1: none
  std::vector<int> body_of_;       // by link
  std::vector<BodyResponse> link_responses_;
  std::vector<double> row_;  // packed as p; zero between calls
  std::vector<Response> of_body_;
  std::vector<double> responses_;
};

/// Displaces coordinates by small motions of all degrees of freedom, packed as p, in place. Velocities u are in the axes of
/// bodies, which turn: each body keeps its linear momentum, and its angular momentum about its centre of mass, up to impulses of
/// joints. `t`: the time (s), for prescribed motions.
class MomentumKeepingDisplacement {
 public:
  void apply(const Tree& tree, double t, const double* shift, double* q, double* u, Workspace<double>& workspace);

 private:
  std::vector<Force<double>> kept_;  // by body, world axes, about the centre of mass
};

}  // namespace momentree

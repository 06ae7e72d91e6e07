#pragma once
// The rows of many contacts, each with the degrees of freedom of its two mechanisms only.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <momentree/contact/many_points.hpp>
#include <momentree/dynamics/contacts.hpp>

namespace momentree {

/// Degrees of freedom numbered mechanism by mechanism. With closed loops all mechanisms count as one.
class ContactParts {
 public:
  /// Numbers those of the tree's present topology.
  void number(const Tree& tree);
  int dofs() const { return static_cast<int>(dof_.size()); }
  int mechanisms() const { return static_cast<int>(ranges_.size()); }

  /// Adds the points of contacts that are placed: their rows J and Y = M⁻¹ Jᵀ. Requires the factors of an evaluation at q.
  void add_points(const Tree& tree, const double* q, Workspace<double>& workspace, std::span<const Contact> contacts,
                  const ContactRows& rows, contact::ManyPoints& many);

  /// Adds a stop of a joint as a point without tangents: its "normal" is a degree of freedom of the body's joint, times `sign`.
  void add_stop(const Tree& tree, const double* q, Workspace<double>& workspace, int body, int dof, double sign,
                contact::ManyPoints& many);

  /// Numbers by degree of freedom, in the order of this class, added to an array packed as p.
  void add_to(const std::vector<double>& x, double* packed) const;

 private:
  struct Range {
    int begin, end;          ///< bodies in the tree's order
    int first_dof, end_dof;  ///< in dof_
  };
  /// Of a body: the joint forces E of a unit wrench along each of its six axes, and M⁻¹ E, as six rows of each.
  struct Response {
    std::size_t at = SIZE_MAX;  ///< in responses_; SIZE_MAX: not known
    int points = 0;             ///< at which the body is touched
  };
  void count_points(const Tree& tree, std::span<const Contact> contacts);
  void solve(const Tree& tree, const double* q, Workspace<double>& workspace, const Range& range);
  const double* response(const Tree& tree, const double* q, Workspace<double>& workspace, int body);
  void add_part(const Tree& tree, const double* q, Workspace<double>& workspace, int mechanism, const Contact& contact,
                const contact::Touch& touch, contact::ManyPoints& many, contact::ManyPoints::Part& part);

  std::vector<Range> ranges_;
  std::vector<int> dof_;           // places in arrays packed as p
  std::vector<int> mechanism_of_;  // by body
  std::vector<double> row_;        // packed as p; zero between calls
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

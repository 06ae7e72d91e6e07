#pragma once
// The flat arrays of a tree, which the recursions read.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <momentree/base/reserved.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/joint/variant.hpp>
#include <momentree/tree/parts/links.hpp>

namespace momentree {

/// A run of bodies in the order whose joints use the same kernels: order[begin] … order[end − 1], including branching bodies and
/// leaves.
struct KernelRun {
  int begin = 0, end = 0;
  Kind kind = Kind::weld;
  Variant variant = Variant::plain;
  bool planar = false;  ///< the run is one complete plane mechanism: a grounded tree of plain revolute joints with parallel axes
};

/// What the recursions need of a tree. Entries of removed bodies are unused.
struct TreeTables {
  struct Offsets {  ///< together, because a step needs all of them
    int q = -1, p = -1, angle = -1;
    std::uint32_t record = 0;  ///< of the body's record in Workspace::records, in scalars
  };
  struct alignas(4) Class {  ///< neighbours of equal class share a kernel run; read as a whole, with one load
    Kind kind = Kind::weld;
    Variant variant = Variant::plain;
    bool parallel : 1 = false;     ///< its axis is parallel to its parent's
    bool aligned : 1 = false;      ///< its link needs no rotation about the parent's z
    bool as_declared : 1 = false;  ///< while everything is linked: its frame is as declared
    friend bool operator==(Class a, Class b) { return a.kind == b.kind && a.variant == b.variant; }
  };

  // By body.
  std::vector<int> parent;
  std::vector<Offsets> offsets;
  std::vector<Class> classes;
  std::vector<double> subtree_mass;  ///< of the body and all bodies outboard of it (kg)
  detail::LinkTable links;

  // By place in the order.
  detail::Reserved<int> order;                 ///< alive bodies only
  detail::Reserved<unsigned char> node_flags;  ///< see namespace node
  detail::Reserved<KernelRun> runs;

  // By angle: index into q, and the offset θ0 added to it.
  detail::Reserved<int> angle_q;
  detail::Reserved<double> angle_offset;

  // By DoF, in the order of p.
  detail::Reserved<double> armature;         ///< kg m², kg
  detail::Reserved<double> damping, effort;  ///< N m s/rad, N s/m; the constant effort (N m, N); zero if there is none
  bool has_forces = false;                   ///< some of these are not zero

  std::size_t record_scalars = 0;
  std::size_t record_capacity = 0;  ///< the largest number that any topology of these bodies needs
};

/// Bodies whose joints need more than their kernels, in the order of joint numbers.
struct SpecialJoints {
  detail::Reserved<int> springs;      ///< bodies whose joint has a spring
  detail::Reserved<int> quaternions;  ///< whose joint's coordinates contain a quaternion
  detail::Reserved<int> forces;       ///< whose joint has friction, soft stops, or a drive other than a constant effort
  detail::Reserved<int> motions;      ///< whose joint has a prescribed motion and is not locked
  detail::Reserved<int> strengths;    ///< whose joint has a strength
  bool functions = false;             ///< a function drives a joint
};

}  // namespace momentree

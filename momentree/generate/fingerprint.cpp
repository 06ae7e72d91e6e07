#include <momentree/generate/fingerprint.hpp>

#include <type_traits>

#include <momentree/dynamics/loops/loop_kernels.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

namespace {

class Bytes {
 public:
  template <class T>
  void add(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    all_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(const Vec3& a) { add(a.x), add(a.y), add(a.z); }
  void add(const LinkConstants& k) {
    // New members must be added here, unless they follow from others as R0 and `rotation` do. Not the bytes of the whole struct:
    // its padding is undefined.
    static_assert(sizeof(LinkConstants) == 36 * sizeof(double), "a link has other members than fingerprints know");
    for (const double x : {k.cos_a,     k.sin_a,     k.cs_a,      k.ss_a,        k.d,           k.cos_b,       k.sin_b,
                           k.cos_0,     k.sin_0,     k.angle_0,   k.geometry[0], k.geometry[1], k.geometry[2], k.body.m,
                           k.body.J.xx, k.body.J.yy, k.body.J.zz, k.body.J.xy,   k.body.J.xz,   k.body.J.yz})
      add(x);
    add(k.r), add(k.body.mc);
    add(static_cast<unsigned char>(k.shape)), add(k.locked), add(k.driven);
  }
  void add(const KernelFrame& frame) { add(frame.R), add(frame.r); }
  void add(const Mat3& R) {
    for (const double x : {R.xx, R.xy, R.xz, R.yx, R.yy, R.yz, R.zx, R.zy, R.zz}) add(x);
  }
  void add(const Closure& c) {
    add(c.positions), add(c.directions), add(c.screws);
    for (const Vec3& n : c.position) add(n);
    for (const Closure::Direction& d : c.direction) add(d.a), add(d.b), add(d.c);
    add(c.screw.n), add(c.screw.e1), add(c.screw.e2), add(c.screw.h);
  }
  std::string take() { return std::move(all_); }

 private:
  std::string all_;
};

// Loops and couplings. Forces in loop joints are not part of the code, but whether it asks for them is.
void add_loops(const Tree& tree, std::span<const int> rows, Bytes& bytes) {
  for (const Loop& loop : tree.loops()) {
    const JointSpec spec = spec_of(loop.joint);
    bytes.add(loop.body), bytes.add(loop.to), bytes.add(detail::has_forces(loop));
    bytes.add(static_cast<unsigned char>(spec.kind)), bytes.add(spec.axis), bytes.add(spec.axis2), bytes.add(spec.pitch);
  }
  for (const LoopLink& link : tree.loops().links) {
    bytes.add(link.closure), bytes.add(link.child), bytes.add(link.parent);
    bytes.add(rotation_matrix(link.child_offset.rotation));
    bytes.add(link.first_row), bytes.add(link.rows), bytes.add(link.dof_row_count);
    for (int k = 0; k < link.dof_row_count; ++k) {
      const DofRow& row = link.dof_rows[static_cast<std::size_t>(k)];
      bytes.add(row.dof), bytes.add(static_cast<unsigned char>(row.use)), bytes.add(row.armature);
    }
    bytes.add(link.ends.joint), bytes.add(link.ends.follows);
    if (link.ends.coupling < 0) continue;
    const Coupling& coupling = tree.couplings()[static_cast<std::size_t>(link.ends.coupling)];
    bytes.add(coupling.multiplier);
    for (const double x : coupling.higher) bytes.add(x);
  }
  for (const int b : tree.joints_with().motions) bytes.add(b);
  for (const int row : rows) bytes.add(row);
}

}  // namespace

std::string fingerprint(const Tree& tree, Variables variables, std::span<const int> rows) {
  Bytes bytes;
  bytes.add(static_cast<unsigned char>(variables));
  bytes.add(tree.gravity());
  bytes.add(tree.nq()), bytes.add(tree.nv());
  for (std::size_t i = 0; i < tree.order().size(); ++i) {
    const int b = tree.order()[i];
    bytes.add(b), bytes.add(tree.parent(b)), bytes.add(tree.tables().node_flags[i]);
    bytes.add(static_cast<unsigned char>(tree.joint(b).kind)), bytes.add(static_cast<unsigned char>(tree.variant(b)));
    bytes.add(tree.first_q(b)), bytes.add(tree.first_p(b)), bytes.add(UncheckedTree(tree).first_angle(b));
    bytes.add(tree.link(b)), bytes.add(tree.subtree_mass(b));
  }
  for (const KernelRun& s : tree.tables().runs) bytes.add(s.begin), bytes.add(s.end), bytes.add(s.planar);
  for (const int q : tree.tables().angle_q) bytes.add(q);
  for (const double offset : tree.tables().angle_offset) bytes.add(offset);
  for (int i = 0; i < tree.nv(); ++i) bytes.add(tree.tables().armature[i]);
  if (tree.has_loops()) add_loops(tree, rows, bytes);
  return bytes.take();
}

}  // namespace momentree

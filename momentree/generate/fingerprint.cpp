#include <momentree/generate/fingerprint.hpp>

#include <type_traits>

#include <momentree/tree/kernel_run.hpp>

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
  std::string take() { return std::move(all_); }

 private:
  std::string all_;
};

}  // namespace

std::string fingerprint(const Tree& tree, Variables variables) {
  Bytes bytes;
  bytes.add(static_cast<unsigned char>(variables));
  bytes.add(tree.gravity());
  bytes.add(tree.nq()), bytes.add(tree.nv());
  for (std::size_t i = 0; i < tree.order().size(); ++i) {
    const int b = tree.order()[i];
    bytes.add(b), bytes.add(tree.parent(b)), bytes.add(tree.node_flags()[i]);
    bytes.add(static_cast<unsigned char>(tree.joint(b).kind)), bytes.add(static_cast<unsigned char>(tree.variant(b)));
    bytes.add(tree.first_q(b)), bytes.add(tree.first_p(b)), bytes.add(tree.first_angle(b));
    bytes.add(tree.link(b)), bytes.add(tree.subtree_mass(b));
  }
  for (const KernelRun& s : tree.kernel_runs()) bytes.add(s.begin), bytes.add(s.end), bytes.add(s.planar), bytes.add(s.plane);
  for (const int q : tree.angle_coordinates()) bytes.add(q);
  for (const double offset : tree.angle_offsets()) bytes.add(offset);
  for (int i = 0; i < tree.nv(); ++i) bytes.add(tree.armature()[i]);
  return bytes.take();
}

}  // namespace momentree

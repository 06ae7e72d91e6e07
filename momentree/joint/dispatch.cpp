#include <momentree/joint/dispatch.hpp>

#include <array>

namespace momentree {

namespace {

constexpr Variant variants[] = {Variant::plain, Variant::armature, Variant::locked, Variant::reversed, Variant::reversed_locked};

template <class K>
KindShape shape_of() {
  KindShape s;
  s.nq = K::info.nq, s.nv = K::info.nv;
  s.rotates_about_z = K::Kernels::rotates_about_z;
  for (int a : K::Kernels::angles) s.angle[s.angles++] = a;
  for (Variant v : variants)
    dispatch_kernels(K::kind, v, [&](auto tag) {
      s.record[static_cast<std::size_t>(v)] = sizeof(typename decltype(tag)::type::template Record<double>) / sizeof(double);
    });
  return s;
}

std::array<KindShape, 32> all_shapes() {
  std::array<KindShape, 32> all{};
#define MOMENTREE_KIND(name, Type) all[static_cast<std::size_t>(Kind::name)] = shape_of<Type>();
  MOMENTREE_KINDS(MOMENTREE_KIND)
#undef MOMENTREE_KIND
  return all;
}

}  // namespace

const KindShape& shape(Kind kind) {
  static const std::array<KindShape, 32> shapes = all_shapes();
  return shapes[static_cast<std::size_t>(kind)];
}

}  // namespace momentree

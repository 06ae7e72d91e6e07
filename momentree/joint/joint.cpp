#include <momentree/joint/joint.hpp>

#include <momentree/joint/kinds.hpp>
#include <momentree/joint/link.hpp>

namespace momentree {

const std::vector<KindInfo>& all_kinds() {
  static const std::vector<KindInfo> kinds{
#define MOMENTREE_KIND(name, Type) Type::info,
      MOMENTREE_KINDS(MOMENTREE_KIND)
#undef MOMENTREE_KIND
  };
  return kinds;
}

const KindInfo& info(Kind kind) { return all_kinds()[static_cast<std::size_t>(kind)]; }

const KindInfo* find_kind(std::string_view name) {
  for (const KindInfo& k : all_kinds())
    if (name == k.name) return &k;
  return nullptr;
}

Mat3 tilt_rotation(const Link& k) {
  const Mat3 Rb{k.cos_b, -k.sin_b, 0, k.sin_b, k.cos_b, 0, 0, 0, 1};
  const Mat3 Ra{1, 0, 0, 0, k.cos_a, -k.sin_a, 0, k.sin_a, k.cos_a};
  return Rb * Ra;
}

Mat3 placement_rotation(const Link& k) { return tilt_rotation(k) * Mat3{k.cos_0, -k.sin_0, 0, k.sin_0, k.cos_0, 0, 0, 0, 1}; }

}  // namespace momentree

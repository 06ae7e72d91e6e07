#include <momentree/contact/primitive.hpp>

#include <array>

namespace momentree::contact {

const SmoothSurface* smooth_surface(unsigned char number) noexcept {
  static constexpr auto surfaces = [] {
    std::array<SmoothSurface, std::variant_size_v<Primitive>> all{};
    std::size_t next = 0;
    each_primitive([&]<class Shape>(const Shape&) {
      if constexpr (is_smooth<Shape>) all[next] = {&Shape::farthest, &Shape::farthest_rate};
      ++next;
    });
    return all;
  }();
  return number == 0 ? nullptr : &surfaces[number - 1u];
}

}  // namespace momentree::contact

#include <momentree/models/import/massless.hpp>

#include <cstddef>
#include <string_view>
#include <unordered_set>

#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

std::vector<int> massless_links(std::span<const BodySpec* const> bodies) {
  std::vector<char> carries(bodies.size(), 0), rigid(bodies.size(), 0);  // carries a joint; has mass, including welded bodies
  std::unordered_set<std::string_view> names;
  for (std::size_t b = bodies.size(); b-- > 0;) {
    const BodySpec& spec = *bodies[b];
    names.insert(spec.name);
    if (spec.mass > 0) rigid[b] = 1;
    if (spec.parent == ground) continue;
    const auto parent = static_cast<std::size_t>(spec.parent.index);
    if (spec.joint.kind == Kind::weld) {
      rigid[parent] = rigid[parent] || rigid[b];
      carries[parent] = carries[parent] || carries[b];
    } else if (rigid[b] || carries[b]) {
      carries[parent] = 1;
    }
  }
  std::vector<int> found;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BodySpec& spec = *bodies[b];
    // `body.joint` has no mass on purpose: it carries another joint of that body.
    const std::size_t dot = spec.name.rfind('.');
    const bool carrier =
        spec.name.empty() || (dot != std::string::npos && names.contains(std::string_view(spec.name).substr(0, dot)));
    if (spec.joint.kind != Kind::weld && !rigid[b] && carries[b] && !carrier) found.push_back(static_cast<int>(b));
  }
  return found;
}

std::string massless_link(const std::string& name) {
  return in_quotes(name) + " moves and carries other bodies, but has no mass";
}

}  // namespace momentree::io

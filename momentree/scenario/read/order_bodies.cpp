// Builds the tree of a mechanism from the names of parents, without recursion, since a chain may be as long as memory allows.
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

constexpr std::size_t no_body = static_cast<std::size_t>(-1);

// A parent's name without the prefix of its own mechanism, which is optional.
std::string_view bare(std::string_view name, const std::string& mechanism) {
  if (name.size() > mechanism.size() && name.substr(0, mechanism.size()) == mechanism && name[mechanism.size()] == '/')
    return name.substr(mechanism.size() + 1);
  return name;
}

// Reports the bodies of the cycle that `start` leads to, and marks all of them.
void report_circle(const std::vector<BodyEntry>& bodies, const std::vector<std::size_t>& parent, std::size_t start,
                   std::vector<char>& reported, Diagnostics& out) {
  std::string names = in_quotes(bodies[start].bare_name);
  int shown = 1;
  for (std::size_t b = start;;) {
    reported[b] = 1;
    b = parent[b];
    if (++shown <= 6) names += " on " + in_quotes(bodies[b].bare_name);
    if (b == start) break;
  }
  if (shown > 6) names += " on …";
  if (shown == 2)
    out.error(bodies[start].parent_place, "body " + in_quotes(bodies[start].bare_name) + " is its own parent");
  else
    out.error(bodies[start].parent_place, "the joints form a cycle: " + names,
              "a mechanism is a tree: close the loop by a [[loop]] instead of one of these joints");
}

}  // namespace

std::vector<std::size_t> order_of(const std::vector<BodyEntry>& bodies, const std::string& mechanism, Place place,
                                  std::size_t roots, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  std::unordered_map<std::string_view, std::size_t> by_name;
  std::unordered_map<std::string, Place> names;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (!bodies[b].bare_name.empty()) by_name.emplace(bodies[b].bare_name, b);

  std::vector<std::size_t> parent(bodies.size(), no_body);
  std::size_t root = no_body, found_roots = 0;
  bool sound = true;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BodyEntry& body = bodies[b];
    if (body.rooted) {
      ++found_roots;
      if (root == no_body)
        root = b;
      else if (found_roots > roots)
        out.error(body.name_place,
                  "a second root: body " + in_quotes(body.bare_name) + " is joined to the ground, as " +
                      in_quotes(bodies[root].bare_name) + " on " + out.name_of(bodies[root].name_place),
                  roots > 1 ? "the mechanism has roots = " + std::to_string(roots)
                            : "give it a joint with a parent, or a separate [[mechanism]]");
      continue;
    }
    const auto found = by_name.find(bare(body.parent, mechanism));
    if (found != by_name.end()) {
      parent[b] = found->second;
      continue;
    }
    if (names.empty())
      for (const BodyEntry& each : bodies) names.emplace(each.bare_name, each.name_place);
    std::string hint = reading.suggest(body.parent, names);
    if (hint.empty() && means_ground(body.parent)) hint = "write parent = \"ground\"";
    if (body.parent.find('/') != std::string::npos) hint = "a parent is a body of the same mechanism";
    const auto* const parent_entry = body.joint != nullptr && body.joint->table() ? body.joint->find("parent") : nullptr;
    if (!body.parent.empty())
      out.error(body.parent_place, "unknown parent " + in_quotes(body.parent), std::move(hint));
    else if (parent_entry != nullptr && parent_entry->value.string())
      out.error(body.parent_place, "parent: expected the name of a body");
    sound = false;
  }

  // Children in the order of the file; a body's state is 1 once it is known to be attached to a root or to an unknown parent.
  std::vector<std::size_t> order, path;
  std::vector<char> placed(bodies.size(), 0), reported(bodies.size(), 0), walking(bodies.size(), 0);
  order.reserve(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    path.clear();
    std::size_t at = b;
    while (at != no_body && !placed[at] && !reported[at] && !walking[at]) {
      walking[at] = 1;
      path.push_back(at);
      at = parent[at];
    }
    const bool circle = at != no_body && walking[at] && !placed[at] && !reported[at];
    if (circle) report_circle(bodies, parent, at, reported, out);
    const bool connected = at == no_body || placed[at];
    for (auto i = path.rbegin(); i != path.rend(); ++i) {
      walking[*i] = 0;
      if (connected) {
        placed[*i] = 1;
        order.push_back(*i);
      } else {
        reported[*i] = 1;
      }
    }
  }
  if (root == no_body && sound && errors == out.errors())
    out.error(place, "mechanism " + in_quotes(mechanism) + " has no root",
              "join one body to the ground: its joint names no parent");
  else if (sound && root != no_body && found_roots < roots)
    out.error(place, "roots: " + std::to_string(found_roots) + " bodies of mechanism " + in_quotes(mechanism) +
                         " are joined to the ground, not " + std::to_string(roots));
  if (!sound || errors != out.errors()) return {};
  return order;
}

}  // namespace momentree::io

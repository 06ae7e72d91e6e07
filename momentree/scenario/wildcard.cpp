// Names with `*`, which matches any sequence of characters except '/': the matching names, in the order of the model.
#include <algorithm>

#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

template <class Number>
std::vector<std::string> matching(const std::string& pattern, const std::unordered_map<std::string, Place>& names,
                                  std::vector<std::string_view>& sorted, Number number) {
  if (sorted.empty()) {
    for (const auto& [name, place] : names) sorted.push_back(name);
    std::sort(sorted.begin(), sorted.end());
  }
  const std::string_view literal = std::string_view(pattern).substr(0, pattern.find('*'));
  std::vector<std::pair<int, std::string>> numbered;
  for (auto at = std::lower_bound(sorted.begin(), sorted.end(), literal);
       at != sorted.end() && at->substr(0, literal.size()) == literal; ++at)
    if (matches_wildcard(pattern, *at)) numbered.emplace_back(number(*at), std::string(*at));
  std::sort(numbered.begin(), numbered.end());
  std::vector<std::string> found;
  for (auto& [index, name] : numbered) found.push_back(std::move(name));
  return found;
}

}  // namespace

std::vector<std::string> matching_joints(const std::string& pattern, bool springs_too, Reading& reading) {
  const Model& model = reading.scenario.model;
  std::vector<std::string> found = matching(pattern, reading.joints, reading.sorted_joints, [&](std::string_view name) {
    return model.has_joint(name) ? model.joint(name).index : -1;
  });
  for (const Spring& spring : model.springs())
    if (springs_too && matches_wildcard(pattern, spring.name)) found.push_back(spring.name);
  return found;
}

std::vector<std::string> matching_bodies(const std::string& pattern, Reading& reading) {
  const Model& model = reading.scenario.model;
  return matching(pattern, reading.bodies, reading.sorted_bodies,
                  [&](std::string_view name) { return model.has_body(name) ? model.body(name).index : -1; });
}

}  // namespace momentree::io

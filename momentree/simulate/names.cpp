#include <momentree/simulate/names.hpp>

#include <utility>

namespace momentree {

Names::Names(const Model& model) : mechanisms_(static_cast<std::size_t>(model.size())) {
  for (int b = 0; b < model.size(); ++b) {
    joints_.push_back(model[{b}].joint_name);
    numbers_.emplace(joints_.back(), b);
    if (model[{b}].parent == ground) mechanisms_[at(b)] = model.mechanism_name({b});
  }
  for (const LoopSpec& loop : model.loops()) add_loop(loops_end(), loop.name);
}

int Names::find_joint(std::string_view name) const {
  const auto found = numbers_.find(name);
  return found == numbers_.end() ? -1 : found->second;
}

std::string Names::free_joint(const std::string& body, int number) const {
  const int other = find_joint(body);
  return other < 0 || other == number ? body : body + "~free";
}

void Names::name_joint(int number, std::string name) {
  std::string& own = number >= first_loop ? loops_[known_loop(number)] : joints_[known(number)];
  const auto known = numbers_.find(own);
  if (known != numbers_.end() && known->second == number) numbers_.erase(known);
  own = std::move(name);
  if (!own.empty()) numbers_[own] = number;
}

void Names::move_mechanism(int from, int to) {
  if (from == to) return;
  mechanisms_[at(to)] = std::move(mechanisms_[at(from)]);
  mechanisms_[at(from)].clear();
}

void Names::add(std::string joint, std::string mechanism) {
  numbers_[joint] = static_cast<int>(joints_.size());
  joints_.push_back(std::move(joint));
  mechanisms_.push_back(std::move(mechanism));
}

void Names::remove_joint(int number) { name_joint(number, {}); }

void Names::add_loop(int number, std::string name) {
  if (number >= loops_end()) loops_.resize(at(number - first_loop) + 1);
  name_joint(number, std::move(name));
}

}  // namespace momentree

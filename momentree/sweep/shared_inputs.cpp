#include <momentree/sweep/shared_inputs.hpp>

#include <utility>

#include <momentree/text/files/text_file.hpp>

namespace momentree::sweep {

std::shared_ptr<io::Import> SharedInputs::model(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = models_.find(name);
  return found != models_.end() ? found->second : nullptr;
}

void SharedInputs::keep(const std::string& name, std::shared_ptr<io::Import> model) {
  const std::lock_guard lock(mutex_);
  if (models_.size() < most) models_.emplace(name, std::move(model));
}

std::string SharedInputs::text(const std::string& path) {
  const std::lock_guard lock(mutex_);
  const auto found = texts_.find(path);
  if (found != texts_.end()) return found->second;
  std::string text = io::read_text_file(path);
  if (texts_.size() < most) texts_.emplace(path, text);
  return text;
}

}  // namespace momentree::sweep

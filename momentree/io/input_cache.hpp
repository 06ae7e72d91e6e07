#pragma once
// Input files that are read once for many readings of a scenario.
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace momentree::io {

class Import;

/// The parsed models and the state documents that a scenario names. Used by several threads at once: all of them get the
/// contents that the first one read, even if the files change later.
class InputCache {
 public:
  InputCache();
  ~InputCache();
  InputCache(const InputCache&) = delete;
  InputCache& operator=(const InputCache&) = delete;

  /// The model of that name, which is relative to the scenario; null: it has not been kept.
  std::shared_ptr<Import> model(const std::string& name) const;
  /// Keeps a model without errors, if no other has been kept under its name. It must not be changed any more. There is a limit to
  /// the number of models, beyond which nothing is kept.
  void keep(const std::string& name, std::shared_ptr<Import> model);
  /// The text of a file, which is read at the first call. Throws Error if it cannot be read.
  std::string text(const std::string& path);

 private:
  static constexpr std::size_t most = 1000;
  mutable std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<Import>> models_;
  std::unordered_map<std::string, std::string> texts_;
};

}  // namespace momentree::io

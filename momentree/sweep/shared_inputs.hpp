#pragma once
#include <cstddef>
#include <mutex>
#include <unordered_map>

#include <momentree/text/files/input_cache.hpp>

namespace momentree::sweep {

/// The input files of all worlds of a sweep, for several threads. There is a limit to the number of models and documents, beyond
/// which they are read again each time.
class SharedInputs final : public io::InputCache {
 public:
  std::shared_ptr<io::Import> model(const std::string& name) const override;
  void keep(const std::string& name, std::shared_ptr<io::Import> model) override;
  std::string text(const std::string& path) override;

 private:
  static constexpr std::size_t most = 1000;
  mutable std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<io::Import>> models_;
  std::unordered_map<std::string, std::string> texts_;
};

}  // namespace momentree::sweep

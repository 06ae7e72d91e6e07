#pragma once
#include <memory>
#include <string>

namespace momentree::io {

class Import;

/// Input files that are read once for many readings of a scenario: the parsed models and the state documents that it names. All
/// readings get the contents that the first one read, even if the files change later.
class InputCache {
 public:
  virtual ~InputCache() = default;

  /// The model of that name, which is relative to the scenario; null: it has not been kept.
  virtual std::shared_ptr<Import> model(const std::string& name) const = 0;
  /// Keeps a model without errors, if no other has been kept under its name. It must not be changed any more.
  virtual void keep(const std::string& name, std::shared_ptr<Import> model) = 0;
  /// The text of a file, which is read at the first call. Throws Error if it cannot be read.
  virtual std::string text(const std::string& path) = 0;
};

}  // namespace momentree::io

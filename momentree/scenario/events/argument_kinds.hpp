#pragma once
// What the kinds of arguments of actions and quantities are in files, in their schema and in the Python package.
#include <string>
#include <vector>

#include <momentree/scenario/keys/keys.hpp>
#include <momentree/simulate/events/argument.hpp>
#include <momentree/text/archive.hpp>

namespace momentree::io {

class ArgumentReader;

/// A parameter of a function of the Python package. Its type may have a default, as in "Vector | None = None"; names of joints
/// and bodies are of the types JointName and BodyName.
struct PythonParameter {
  std::string name, type, about;
  bool by_keyword = false;
};

struct ArgumentDescription {
  std::vector<Key> keys{};                ///< in the table of the action or quantity; a quantity with one argument has no table
  std::vector<PythonParameter> python{};  ///< none: the parameters of joints
  std::string in_python = python.empty() ? "" : python[0].name;  ///< the value in Python; "**…" adds entries to the table
  bool parameters = false;                                       ///< the table has those of joints, too
};

struct ArgumentKind {
  const std::type_info* type;  ///< of the value
  void (*read)(const Argument& argument, ArgumentReader& in);
  ArgumentDescription (*described)(const Argument& argument);
  void (*write)(ArchiveWriter& archive, const Argument& argument);
  void (*read_back)(ArchiveReader& archive, const Argument& argument);
};
const ArgumentKind& kind_of(const Argument& argument);

}  // namespace momentree::io

#include <momentree/text/files/table_file.hpp>

#include <unordered_set>

namespace momentree::io {

TableFile::~TableFile() = default;

namespace {

/// Whether a name can be a path: no empty components, and none that stands for the group itself.
bool is_path(const std::string& name) {
  for (std::size_t start = 0, end = 0; end != std::string::npos; start = end + 1) {
    end = name.find('/', start);
    const std::string part = name.substr(start, end == std::string::npos ? end : end - start);
    if (part.empty() || part == ".") return false;
  }
  return true;
}

std::string without_slashes(const std::string& name) {
  std::string text;
  for (const char c : name) c == '/' ? text += "%2F" : text += c;
  return text;
}

}  // namespace

std::vector<std::string> hdf5_paths(std::span<const TableColumn> columns) {
  std::unordered_set<std::string> names;
  for (const TableColumn& column : columns) names.insert(column.name);
  const auto is_column = [&names](const std::string& name) {  // a group within which the column would be
    for (std::size_t end = name.find('/'); end != std::string::npos; end = name.find('/', end + 1))
      if (names.contains(name.substr(0, end))) return true;
    return false;
  };
  std::vector<std::string> paths;
  for (const TableColumn& column : columns)
    paths.push_back(is_path(column.name) && !is_column(column.name) ? column.name : without_slashes(column.name));
  return paths;
}

}  // namespace momentree::io

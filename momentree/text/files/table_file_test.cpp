#include <momentree/text/files/table_file.hpp>

#include <doctest/doctest.h>

using namespace momentree::io;

namespace {

std::vector<std::string> paths(const std::vector<std::string>& names) {
  std::vector<TableColumn> columns;
  for (const std::string& name : names) columns.push_back({.name = name});
  return hdf5_paths(columns);
}

}  // namespace

TEST_CASE("columns of HDF5 tables have their names as paths") {
  CHECK(paths({"time", "arm/elbow.q0", "a/b/c.x"}) == std::vector<std::string>{"time", "arm/elbow.q0", "a/b/c.x"});
}

TEST_CASE("names that cannot be paths have no slashes: empty parts, the group itself, and a column in place of a group") {
  CHECK(paths({"a//b", "/a", "b/", "./c.x", "d/./e"}) ==
        std::vector<std::string>{"a%2F%2Fb", "%2Fa", "b%2F", ".%2Fc.x", "d%2F.%2Fe"});
  CHECK(paths({"time", "time/1.x", "times/1.x"}) == std::vector<std::string>{"time", "time%2F1.x", "times/1.x"});
}

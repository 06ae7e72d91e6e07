#include <momentree/results/hdf5/plugin.hpp>

#include <doctest/doctest.h>

#include <string>

#include <momentree/base/error.hpp>

using namespace momentree;
using namespace momentree::io;

TEST_CASE("a missing plugin is an error that tells its packages and what works without it") {
  CHECK(plugin_places("none").size() >= 2);
  try {
    load_plugin({"none", 1, "nothing", "libnone-dev", "everything works without it"});
    FAIL("it was loaded");
  } catch (const Error& error) {
    CHECK(error.problem.starts_with("momentree-none.so, which is needed for nothing, is missing: there is no "));
    for (const std::string& place : plugin_places("none")) CHECK(error.problem.find(place) != std::string::npos);
    CHECK(error.hint == "install libnone-dev and build momentree again (`./dev build`); everything works without it");
  }
}

// docs/sweep.schema.json is the schema of this version, and docs/sweeps.md explains every key.
#include <doctest/doctest.h>

#include <string>

#include <momentree/sweep/plan/measure.hpp>
#include <momentree/sweep/plan/sweep_keys.hpp>
#include <momentree/text/files/text_file.hpp>

using namespace momentree::sweep;

TEST_CASE("docs/sweep.schema.json is the schema of this version") {
  const bool same = momentree::io::read_text_file(MOMENTREE_SOURCE_DIR "/docs/sweep.schema.json") == sweep_schema();
  INFO("./dev schema writes it");
  CHECK(same);
}

TEST_CASE("docs/sweeps.md explains every key of sweep files") {
  const std::string text = momentree::io::read_text_file(MOMENTREE_SOURCE_DIR "/docs/sweeps.md");
  const auto explained = [&text](const std::string& word) {
    for (const char* after : {"`", " = ", "]`", " "})
      if (text.find("`" + word + after) != std::string::npos || text.find("[" + word + after) != std::string::npos) return true;
    return text.find("| `" + word) != std::string::npos || text.find("\n" + word + " = ") != std::string::npos ||
           text.find("{ " + word + " = ") != std::string::npos || text.find(", " + word + " = ") != std::string::npos;
  };
  for (const momentree::io::KeyTable* table :
       {&sweep_table, &vary_table, &correlated_table, &measure_table, &stop_table, &output_table})
    table->each([&](const momentree::io::Key& key) {
      const std::string name = key.name;
      CAPTURE(name);
      CHECK(explained(name));
    });
  for (const std::string& value : event_values()) {
    const std::string word = value.substr(0, value.find('.'));
    CAPTURE(word);
    CHECK(text.find(word) != std::string::npos);
  }
}

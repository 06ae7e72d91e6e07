// What the reader of scenarios finds where there are no files: no text is a model, and no model can be read.
#include <momentree/base/check.hpp>
#include <momentree/io/model/model_file.hpp>
#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

bool is_model(std::string_view, std::string_view) { return false; }

std::optional<Unreadable> why_unreadable(const std::string&, const char*) { return Unreadable{"files are not read here", ""}; }

Enclosure::Enclosure(const std::string&) {}
bool Enclosure::holds(const std::filesystem::path&) const { return true; }

bool read_whole_file(const std::string&, const char*, std::uintmax_t, std::string&, Unreadable& why) {
  why = {"files are not read here", ""};
  return false;
}

std::unique_ptr<Import> read_model_text(std::string, std::string, std::string) {
  MT_REQUIRE(false, "no text is a model");
  return nullptr;
}

// Of models that were read: there are none.
std::size_t Import::errors() const { return 0; }
std::vector<Diagnostic> XmlFile::take() { return {}; }
Place XmlElement::place() const { return {}; }
Place XmlElement::text_place() const { return {}; }
Place XmlElement::attribute_place(std::size_t, bool) const { return {}; }

void read_model(const Value& file, const std::string& mechanism, const ModelChoice&, JointTables&, std::size_t,
                Reading& reading) {
  reading.out.error(file.place, "model: model files are not read here",
                    "`momentree convert` writes a model as a mechanism of the scenario");
  reading.opaque.insert(mechanism);
}

}  // namespace momentree::io

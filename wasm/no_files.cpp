// Replaces the file access of the scenario reader: no text is recognised as a model, and no model can be read.
#include <momentree/base/check.hpp>
#include <momentree/models/import/model_file.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

bool is_model(std::string_view, std::string_view) { return false; }

std::optional<Unreadable> why_unreadable(const std::string&, const char*) { return Unreadable{"files can't be read here", ""}; }

Enclosure::Enclosure(const std::string&) {}
bool Enclosure::holds(const std::filesystem::path&) const { return true; }

bool read_whole_file(const std::string&, const char*, std::uintmax_t, std::string&, Unreadable& why) {
  why = {"files can't be read here", ""};
  return false;
}

std::unique_ptr<Import> read_model_text(std::string, std::string, std::string) {
  MT_REQUIRE(false, "model files can't be read here");
  return nullptr;
}

// Members of imported models, which never exist here.
std::size_t Import::errors() const { return 0; }
std::vector<Diagnostic> XmlFile::take() { return {}; }
Place XmlElement::place() const { return {}; }
Place XmlElement::text_place() const { return {}; }
Place XmlElement::attribute_place(std::size_t, bool) const { return {}; }

void read_model(const Value& file, const std::string& mechanism, const ModelChoice&, JointTables&, std::size_t,
                Reading& reading) {
  reading.out.error(file.place, "model: model files can't be read here",
                    "convert the model to a mechanism of the scenario with `momentree convert`");
  reading.opaque.insert(mechanism);
}

}  // namespace momentree::io

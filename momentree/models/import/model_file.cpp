#include <momentree/models/import/model_file.hpp>

#include <algorithm>
#include <iterator>

#include <momentree/base/error.hpp>
#include <momentree/models/all_importers.hpp>  // generated from the files in importers/, like the list of formats
#include <momentree/models/importers/list.hpp>
#include <momentree/text/files/file_name.hpp>

namespace momentree::io {

namespace {

struct Format {
  const char *name, *root;
  std::vector<std::string> endings;
  void (*read)(XmlElement root, Import& import);
};

const std::vector<Format>& formats() {
  static const std::vector<Format> all{
#define MOMENTREE_IMPORTER(file, Type) \
  {Type::name, Type::root, {std::begin(Type::endings), std::end(Type::endings)}, &Type::read},
      MOMENTREE_IMPORTERS(MOMENTREE_IMPORTER)
#undef MOMENTREE_IMPORTER
  };
  return all;
}

void read(Import& import) {
  const XmlElement root = import.file().root();
  if (!root) return;
  std::vector<std::string> roots;
  std::string known = "known are";
  for (const Format& format : formats()) {
    if (root.name() == format.root) {
      format.read(root, import);
      if (import.errors() == 0 || !import.model.bodies.empty()) check_imported(import.model);
      return;
    }
    roots.emplace_back(format.root);
    known += (roots.size() > 1 ? ", <" : " <") + std::string(format.root) + "> (" + format.name + ")";
  }
  const std::string meant = nearest(root.name(), roots);
  import.file().error({root}, "no model begins with " + in_quotes(root.tag()),
                      meant.empty() ? known : "did you mean <" + meant + ">?");
}

}  // namespace

bool is_model(std::string_view path, std::string_view text) {
  const std::string ending = small_ending(path);
  if (ending == ".toml") return false;
  if (ending == ".xml") return true;
  for (const Format& format : formats())
    if (std::find(format.endings.begin(), format.endings.end(), ending) != format.endings.end()) return true;
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first != std::string_view::npos && text[first] == '<';
}

std::vector<std::string> model_endings() {
  std::vector<std::string> all{".xml"};
  for (const Format& format : formats())
    for (const std::string& ending : format.endings)
      if (std::find(all.begin(), all.end(), ending) == all.end()) all.push_back(ending);
  return all;
}

std::unique_ptr<Import> read_model_text(std::string path, std::string text, std::string folder) {
  const bool quotes = begins_as_model(text);
  auto import = std::make_unique<Import>(std::move(path), std::move(text), std::move(folder), quotes);
  read(*import);
  return import;
}

bool begins_as_model(std::string_view text) {
  const std::string_view root = first_tag(text);
  const auto& all = formats();
  return root == "mujocoinclude" ||
         std::any_of(all.begin(), all.end(), [root](const Format& format) { return root == format.root; });
}

}  // namespace momentree::io

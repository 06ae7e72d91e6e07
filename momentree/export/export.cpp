#include <momentree/export/export.hpp>

#include <momentree/base/error.hpp>
#include <momentree/export/glb.hpp>
#include <momentree/export/mcap.hpp>
#include <momentree/export/usd.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {

namespace {

std::string small_ending(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return ending;
}

}  // namespace

void require_export_name(const std::filesystem::path& file) {
  const std::string ending = small_ending(file);
  if (ending == ".glb" || ending == ".usda" || ending == ".mcap") return;
  throw_error({ending.empty() ? "the name has no ending, which says the format" : "runs cannot be exported as '" + ending + "'",
               file.string(),
               "name a file that ends in .glb (glTF) or .usda (USD), for 3D programs, or in .mcap (for Foxglove)"});
}

void export_result(const std::filesystem::path& directory, const std::filesystem::path& file) {
  require_export_name(file);
  const Drawing drawing = read_drawing(directory);
  const std::string ending = small_ending(file);
  write_text_file(file.string(), ending == ".glb"    ? glb_of(drawing)
                                 : ending == ".usda" ? usd_of(drawing)
                                                     : mcap_of(drawing, directory));
}

}  // namespace momentree::io

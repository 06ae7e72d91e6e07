#include <cstdio>
#include <filesystem>
#include <optional>

#include <cli/commands.hpp>
#include <cli/input.hpp>
#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/text/files/file_name.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::cli {

namespace {

namespace fs = std::filesystem;

enum class Format { toml, urdf };

Format format_of(const std::string& path) {
  if (path == "-") return Format::toml;
  const std::string ending = io::small_ending(path);
  if (ending == ".toml") return Format::toml;
  if (ending == ".urdf") return Format::urdf;
  throw_error({ending.empty() ? "the format is unknown: the file name has no ending" : "'" + ending + "' files cannot be written",
               path, "use .toml (a scenario) or .urdf (one mechanism)"});
}

}  // namespace

int convert(const ConvertOptions& options) {
  const Format format = format_of(options.out);
  const std::shared_ptr<const io::Scenario> scenario = load(options.source, options.overrides, notes_of(options.verbose));
  if (!scenario) return bad_input;
  refuse_to_overwrite(options.out, *scenario);
  if (format == Format::toml && !options.mechanism.empty())
    throw_error({"--mechanism is only for .urdf, which holds one mechanism", "", "a scenario holds all of them"});
  const std::string folder = options.out == "-" ? "" : fs::path(options.out).parent_path().string();
  const io::Converted result =
      format == Format::toml ? io::to_toml(*scenario, folder) : io::to_urdf(*scenario, options.mechanism, folder);
  show(stderr, io::rendered(result.diagnostics));
  if (options.out == "-")
    std::fputs(result.text.c_str(), stdout);
  else
    io::write_text_file(options.out, result.text);
  return done;
}

}  // namespace momentree::cli

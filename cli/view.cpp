#include <cstdio>
#include <filesystem>

#include <cli/commands.hpp>
#include <momentree/base/error.hpp>
#include <momentree/io/svg.hpp>

namespace momentree::cli {

int view(const ViewOptions& options) {
  if (options.svg.empty()) fail({"the interactive viewer is not supported yet", "", "draw the run with --svg FILE"});
  io::PictureOptions picture;
  picture.every = options.every;
  if (!options.look.empty()) picture.look = io::parse_direction(options.look);
  if (!std::filesystem::is_directory(options.source))
    fail({"this is not a result directory", options.source,
          "run the scenario first (momentree run), then name the directory that it wrote"});
  io::write_svg(options.source, options.svg, picture);
  std::printf("%s\n", options.svg.c_str());
  return done;
}

}  // namespace momentree::cli

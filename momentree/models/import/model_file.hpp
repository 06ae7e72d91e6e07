#pragma once
// Model files of all formats. The root element determines the format; the file name's ending or the first tag identify a model.
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/models/import/importer.hpp>
#include <momentree/text/files/input_file.hpp>

namespace momentree::io {

/// True if a file of that name or with that text is a model, not a scenario.
bool is_model(std::string_view path, std::string_view text);

/// The endings of model file names, each with its dot.
std::vector<std::string> model_endings();

/// Reads a model from its text; errors are in the files of the result. `folder`: for the files that it names; empty: none is
/// accessed.
std::unique_ptr<Import> read_model_text(std::string path, std::string text, std::string folder);

/// True if the first element of a text is the root of a format, or of a file that it may include. Messages quote lines of such
/// texts only, since a scenario may name any file as a model.
bool begins_as_model(std::string_view text);

inline constexpr std::uintmax_t largest_model = 64u << 20;

}  // namespace momentree::io

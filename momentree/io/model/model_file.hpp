#pragma once
// Model files of whatever format: known by their root element, taken for models by the ending of their name or their first tag.
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/io/input_file.hpp>
#include <momentree/io/model/importer.hpp>

namespace momentree::io {

/// True where a file of that name or that text is a model and no scenario.
bool is_model(std::string_view path, std::string_view text);

/// Endings of the names of model files, each with its point.
std::vector<std::string> model_endings();

/// Reads a model from its text; what is wrong is in the files of the result. `folder`: for the files that it names; empty: none
/// is looked for.
std::unique_ptr<Import> read_model_text(std::string path, std::string text, std::string folder);

/// True where the first element of a text is the root of a format, or of what its files include: only of such a text may a
/// message quote lines, since a scenario may name any file as a model.
bool begins_as_model(std::string_view text);

inline constexpr std::uintmax_t largest_model = 64u << 20;

}  // namespace momentree::io

#pragma once
// File names as they are written in scenarios and models.
#include <string>
#include <string_view>

namespace momentree::io {

/// True if a name as written cannot refer to a file in the folder or below it, whatever the file system contains: an absolute
/// path, one with more `..` than folders, a path of another operating system, or one with invisible characters.
bool leaves_folder(const std::string& name);

/// How a name ends, in small letters: ".toml"; empty if there is no ending.
std::string small_ending(std::string_view name);

}  // namespace momentree::io

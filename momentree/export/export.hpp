#pragma once
// `momentree view DIR --export FILE`: a result as one file for other programs.
#include <filesystem>
#include <string>

namespace momentree::io {

/// The endings of names and what they stand for: ".glb (animated glTF), .usda (USD) or .mcap (Foxglove)".
std::string export_formats();

/// Throws Error unless the file's name ends as that of a format, in any case.
void require_export_name(const std::filesystem::path& file);

/// Writes a result directory as a file, whose ending gives the format: one of those in exporters/, such as .glb, an animated glTF
/// 2.0 file. The file is written completely or not at all. Throws Error: another ending, a result that is damaged, a file that
/// cannot be written.
void export_result(const std::filesystem::path& directory, const std::filesystem::path& file);

}  // namespace momentree::io

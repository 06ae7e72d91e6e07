#pragma once
// `momentree view DIR --export FILE`: a result as one file for other programs.
#include <filesystem>

namespace momentree::io {

/// Throws Error unless the file's name ends in .glb, .usda or .mcap, in any case.
void require_export_name(const std::filesystem::path& file);

/// Writes a result directory as a file, whose ending gives the format: .glb, an animated glTF 2.0 file (glb_of), .usda, an
/// animated USD file (usd_of), or .mcap, for Foxglove and other readers of MCAP (mcap_of). The file is written completely or not
/// at all. Throws Error: another ending, a result that is damaged, a file that cannot be written.
void export_result(const std::filesystem::path& directory, const std::filesystem::path& file);

}  // namespace momentree::io

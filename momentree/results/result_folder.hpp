#pragma once
// The contents of a result folder: files that momentree wrote and files that it did not.
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/results/result_marker.hpp>

namespace momentree::io {

/// Hidden files that momentree works with in a result folder; they are never part of a result.
namespace helper {
constexpr const char* fresh = ".momentree.new";        ///< a file that is being written
constexpr const char* reserve = ".momentree.reserve";  ///< disk space for the last file
constexpr const char* former = ".momentree.former";    ///< the earlier result, briefly, if folders cannot be exchanged atomically
}  // namespace helper

/// Throws Error if the folder cannot be read.
bool is_empty_folder(const std::filesystem::path& folder);

/// The names in the folder other than momentree's files, its marker and its helpers. Throws Error.
std::vector<std::string> others_in(const std::filesystem::path& folder, const ResultMarker& marker);

/// Removes momentree's files, the summary first, so that the folder no longer looks like a complete result. Throws Error.
void remove_own(const std::filesystem::path& folder, const ResultMarker& marker);

/// Removes the marker and the folder, if nothing else is in it. A folder with other files stays, and keeps its marker. Throws
/// Error.
void remove_if_empty(const std::filesystem::path& folder);

/// Moves files that momentree did not write from an earlier result to `destination` and removes the rest. Never throws; returns
/// warnings for the files that stay, with the reasons.
std::vector<std::string> retire(const std::filesystem::path& folder, const ResultMarker& marker,
                                const std::filesystem::path& destination);

}  // namespace momentree::io

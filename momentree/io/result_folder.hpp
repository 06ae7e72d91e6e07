#pragma once
// What is in a folder of results: files that momentree made and those that it did not.
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/io/result_marker.hpp>

namespace momentree::io {

/// Names of files that momentree works with in a result folder; they are hidden, and never a result's own.
namespace helper {
constexpr const char* fresh = ".momentree.new";        ///< a file that is being written
constexpr const char* reserve = ".momentree.reserve";  ///< room on the disk for the last file
constexpr const char* former = ".momentree.former";    ///< the earlier result, for an instant, where folders can't be exchanged
}  // namespace helper

/// Throws Error where it can't be read.
bool is_empty_folder(const std::filesystem::path& folder);

/// Names in the folder that are neither of momentree's files nor of its marker and helpers. Throws Error.
std::vector<std::string> others_in(const std::filesystem::path& folder, const ResultMarker& marker);

/// Removes momentree's files, the summary first: from then on nothing there claims to be whole. Throws Error.
void remove_own(const std::filesystem::path& folder, const ResultMarker& marker);

/// Removes the marker and the folder, if nothing else is in it. Throws Error; a folder with other files stays, and keeps its
/// marker.
void remove_if_empty(const std::filesystem::path& folder);

/// Moves what is not momentree's from an earlier result to `destination` and removes the rest. Throws nothing; returns warnings:
/// what stays, and why.
std::vector<std::string> retire(const std::filesystem::path& folder, const ResultMarker& marker,
                                const std::filesystem::path& destination);

}  // namespace momentree::io

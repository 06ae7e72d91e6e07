#pragma once
// Compares two result folders: the first row, and the first body or joint, in which two runs differ.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace momentree::io {

/// Where two results differ.
struct Difference {
  enum class Kind { model, value, rows, longer, document };
  Kind kind = Kind::value;
  std::string file{};                ///< "bodies.csv"
  std::string what{};                ///< a sentence without file, row and time
  std::optional<std::size_t> row{};  ///< of a table, from 1, without the header; or the number of an event
  std::optional<double> time{};      ///< s
  std::string name{}, column{};      ///< the body, joint or event, and its column or the path within it
  std::string one{}, other{};        ///< both values, as in the files; empty: absent
};

struct Comparison {
  std::vector<Difference> differences;  ///< at most two for each file; those of the model first, then by time
  std::size_t rows = 0, events = 0;     ///< compared
  bool equal() const { return differences.empty(); }
};

/// Compares bodies.csv, joints.csv, springs.csv, events.jsonl (without wall-clock times), final.json and model.json (without its
/// title). Numbers are equal if they differ by at most `tolerance`, times the larger of their sizes if that exceeds 1. Result
/// folders of runs that ended early, DIR.partial, are compared as far as they go. Throws Error for a folder that is no result.
Comparison compare_results(const std::string& one, const std::string& other, double tolerance = 0);

}  // namespace momentree::io

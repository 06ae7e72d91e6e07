#pragma once
// The results of a chunk of worlds as bytes: the same on every machine (little-endian), so that they can be sent and stored.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace momentree::sweep {

/// What one world gave. Flags are 0 or 1; NaN: absent.
struct WorldResult {
  std::vector<double> measures;  ///< as many as the sweep has; all NaN for a world that failed
  std::string failure;           ///< why the world failed; empty: it is done

  bool done() const { return failure.empty(); }
  friend bool operator==(const WorldResult&, const WorldResult&) = default;
};

void append_integer(std::string& bytes, std::uint64_t value, int size);
/// The integer in the first `size` bytes.
std::uint64_t integer_at(std::string_view bytes, int size);

/// Appends one world.
void encode(const WorldResult& result, std::string& bytes);

/// Reads the worlds of a chunk one by one.
class ResultReader {
 public:
  ResultReader(std::string_view bytes, std::size_t measures) : bytes_(bytes), measures_(measures) {}
  /// Reads the next world; false at the end, or if the bytes are not such results.
  bool next(WorldResult& result);
  /// Whether everything has been read.
  bool at_end() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
  std::size_t measures_;
};

/// Whether the bytes are the results of `count` worlds.
bool is_encoded(std::string_view bytes, std::size_t measures, std::uint64_t count);

}  // namespace momentree::sweep

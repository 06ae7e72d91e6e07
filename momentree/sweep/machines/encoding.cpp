#include <momentree/sweep/machines/encoding.hpp>

#include <bit>
#include <limits>

namespace momentree::sweep {

namespace {
constexpr char done_mark = 0, failed_mark = 1;
}

void append_integer(std::string& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

std::uint64_t integer_at(std::string_view bytes, int size) {
  std::uint64_t value = 0;
  for (int i = 0; i < size; ++i)
    value |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[static_cast<std::size_t>(i)])) << (8 * i);
  return value;
}

void encode(const WorldResult& result, std::string& bytes) {
  bytes += result.done() ? done_mark : failed_mark;
  if (result.done()) {
    for (const double x : result.measures) append_integer(bytes, std::bit_cast<std::uint64_t>(x), 8);
  } else {
    append_integer(bytes, result.failure.size(), 4);
    bytes += result.failure;
  }
}

bool ResultReader::next(WorldResult& result) {
  if (bytes_.empty()) return false;
  const char mark = bytes_.front();
  bytes_.remove_prefix(1);
  result.failure.clear();
  result.measures.assign(measures_, std::numeric_limits<double>::quiet_NaN());
  if (mark == done_mark) {
    if (bytes_.size() < 8 * measures_) return false;
    for (std::size_t m = 0; m < measures_; ++m) result.measures[m] = std::bit_cast<double>(integer_at(bytes_.substr(8 * m), 8));
    bytes_.remove_prefix(8 * measures_);
    return true;
  }
  if (mark != failed_mark || bytes_.size() < 4) return false;
  const std::uint64_t length = integer_at(bytes_, 4);
  bytes_.remove_prefix(4);
  if (length == 0 || bytes_.size() < length) return false;
  result.failure = bytes_.substr(0, length);
  bytes_.remove_prefix(length);
  return true;
}

bool is_encoded(std::string_view bytes, std::size_t measures, std::uint64_t count) {
  ResultReader reader(bytes, measures);
  WorldResult result;
  for (std::uint64_t i = 0; i < count; ++i)
    if (!reader.next(result)) return false;
  return reader.at_end();
}

}  // namespace momentree::sweep

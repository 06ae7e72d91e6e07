#pragma once
// An MCAP file: messages with times, in channels, https://mcap.dev/spec. Chunks are not compressed; they, the data section and
// the summary have checksums, and the summary has indices, so that readers can go to any time.
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace momentree::io {

class McapFile {
 public:
  using Metadata = std::vector<std::pair<std::string, std::string>>;

  /// `library`: the program that writes.
  explicit McapFile(const std::string& library);

  /// Adds a channel whose messages are JSON, with the JSON Schema that describes them. Returns its number, from 0.
  std::size_t add_channel(const std::string& topic, const std::string& schema_name, std::string_view schema);
  /// `time`: nanoseconds. Messages may have any order; readers are faster if it is nearly that of time.
  void add_message(std::size_t channel, std::uint64_t time, std::string_view json);
  /// Ends the file and returns its bytes; nothing may be added after that.
  std::string finish(const std::string& metadata_name, const Metadata& metadata);

 private:
  struct Entry {
    std::uint64_t time, offset;
  };
  struct Channel {
    std::string schema_record, channel_record;
    std::uint64_t messages = 0;
    std::vector<Entry> index{};  ///< of the present chunk
    bool in_file = false;        ///< its records are in a chunk already
  };
  struct Span {
    std::uint64_t first, last;
    void add(std::uint64_t time);
  };
  static constexpr Span nothing{~std::uint64_t{0}, 0};

  void end_chunk();
  void begin_data();

  std::string file_, chunk_;
  std::vector<Channel> channels_;
  std::vector<std::string> chunk_indices_;
  Span chunk_span_ = nothing, file_span_ = nothing;
};

/// CRC-32 of zip files (ISO-HDLC), continued from that of the bytes before.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace momentree::io

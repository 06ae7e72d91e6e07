#include <momentree/export/mcap_file.hpp>

#include <algorithm>
#include <array>

#include <momentree/export/bytes.hpp>

namespace momentree::io {

namespace {

constexpr std::string_view mcap_magic{"\x89MCAP0\r\n", 8};
constexpr std::size_t large_chunk = 1u << 20;

enum class Op : unsigned char {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  statistics = 11,
  metadata = 12,
  metadata_index = 13,
  summary_offset = 14,
  data_end = 15
};

void put_text(std::string& bytes, std::string_view text) {
  append_little_endian(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

void put_record(std::string& bytes, Op op, std::string_view content) {
  bytes += static_cast<char>(op);
  append_little_endian(bytes, static_cast<std::uint64_t>(content.size()));
  bytes += content;
}

std::string record_of(Op op, std::string_view content) {
  std::string bytes;
  put_record(bytes, op, content);
  return bytes;
}

constexpr std::array<std::uint32_t, 256> crc_table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
    table[i] = crc;
  }
  return table;
}();

}  // namespace

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) {
  std::uint32_t crc = ~before;
  for (const char c : bytes) crc = (crc >> 8) ^ crc_table[(crc ^ static_cast<unsigned char>(c)) & 0xffu];
  return ~crc;
}

void McapFile::Span::add(std::uint64_t time) { first = std::min(first, time), last = std::max(last, time); }

McapFile::McapFile(const std::string& library) {
  file_ = mcap_magic;
  std::string header;
  put_text(header, "");  // no profile
  put_text(header, library);
  put_record(file_, Op::header, header);
}

std::size_t McapFile::add_channel(const std::string& topic, const std::string& schema_name, std::string_view schema) {
  const auto number = static_cast<std::uint16_t>(channels_.size());
  std::string content;
  append_little_endian(content, static_cast<std::uint16_t>(number + 1));  // 0: no schema
  put_text(content, schema_name);
  put_text(content, "jsonschema");
  put_text(content, schema);
  Channel channel{record_of(Op::schema, content), {}};
  content.clear();
  append_little_endian(content, number);
  append_little_endian(content, static_cast<std::uint16_t>(number + 1));
  put_text(content, topic);
  put_text(content, "json");
  append_little_endian(content, std::uint32_t{0});  // no metadata
  channel.channel_record = record_of(Op::channel, content);
  channels_.push_back(std::move(channel));
  return number;
}

void McapFile::add_message(std::size_t number, std::uint64_t time, std::string_view json) {
  Channel& channel = channels_[number];
  if (!channel.in_file) chunk_ += channel.schema_record + channel.channel_record;
  channel.in_file = true;
  channel.index.push_back({time, chunk_.size()});
  std::string content;
  content.reserve(json.size() + 22);
  append_little_endian(content, static_cast<std::uint16_t>(number));
  append_little_endian(content, static_cast<std::uint32_t>(channel.messages++));
  append_little_endian(content, time);  // logged and published
  append_little_endian(content, time);
  content += json;
  put_record(chunk_, Op::message, content);
  chunk_span_.add(time);
  if (chunk_.size() >= large_chunk) end_chunk();
}

void McapFile::end_chunk() {
  if (chunk_.empty()) return;
  const std::uint64_t start = file_.size();
  std::string content;
  append_little_endian(content, chunk_span_.first);
  append_little_endian(content, chunk_span_.last);
  append_little_endian(content, static_cast<std::uint64_t>(chunk_.size()));
  append_little_endian(content, crc32(chunk_));
  put_text(content, "");  // not compressed
  append_little_endian(content, static_cast<std::uint64_t>(chunk_.size()));
  content += chunk_;
  put_record(file_, Op::chunk, content);
  const std::uint64_t length = file_.size() - start;

  std::string offsets;
  const std::uint64_t indices = file_.size();
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    std::vector<Entry>& index = channels_[c].index;
    if (index.empty()) continue;
    std::stable_sort(index.begin(), index.end(), [](const Entry& a, const Entry& b) { return a.time < b.time; });
    append_little_endian(offsets, static_cast<std::uint16_t>(c));
    append_little_endian(offsets, static_cast<std::uint64_t>(file_.size()));
    std::string entries;
    append_little_endian(entries, static_cast<std::uint16_t>(c));
    append_little_endian(entries, static_cast<std::uint32_t>(16 * index.size()));
    for (const Entry& entry : index) append_little_endian(entries, entry.time), append_little_endian(entries, entry.offset);
    put_record(file_, Op::message_index, entries);
    index.clear();
  }

  content.clear();
  append_little_endian(content, chunk_span_.first);
  append_little_endian(content, chunk_span_.last);
  append_little_endian(content, start);
  append_little_endian(content, length);
  append_little_endian(content, static_cast<std::uint32_t>(offsets.size()));
  content += offsets;
  append_little_endian(content, static_cast<std::uint64_t>(file_.size() - indices));
  put_text(content, "");
  append_little_endian(content, static_cast<std::uint64_t>(chunk_.size()));
  append_little_endian(content, static_cast<std::uint64_t>(chunk_.size()));
  chunk_indices_.push_back(record_of(Op::chunk_index, content));
  file_span_.add(chunk_span_.first), file_span_.add(chunk_span_.last);
  chunk_.clear();
  chunk_span_ = nothing;
}

std::string McapFile::finish(const std::string& metadata_name, const Metadata& metadata) {
  end_chunk();
  std::string content, entries;
  for (const auto& [key, value] : metadata) put_text(entries, key), put_text(entries, value);
  put_text(content, metadata_name);
  put_text(content, entries);  // a map is its length in bytes and its entries
  const std::uint64_t metadata_at = file_.size();
  put_record(file_, Op::metadata, content);
  const std::uint64_t metadata_length = file_.size() - metadata_at;
  content.clear();
  append_little_endian(content, crc32(file_));
  put_record(file_, Op::data_end, content);

  // The summary: groups of records, then where each group is.
  const std::uint64_t summary = file_.size();
  std::string offsets;
  const auto put_group = [&](Op op, const std::string& records) {
    if (records.empty()) return;
    std::string group{static_cast<char>(op)};
    append_little_endian(group, static_cast<std::uint64_t>(file_.size()));
    append_little_endian(group, static_cast<std::uint64_t>(records.size()));
    offsets += record_of(Op::summary_offset, group);
    file_ += records;
  };
  std::string schemas, channels, counts, chunks;
  std::uint64_t messages = 0;
  std::uint16_t used = 0;
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const Channel& channel = channels_[c];
    if (!channel.in_file) continue;
    schemas += channel.schema_record, channels += channel.channel_record;
    append_little_endian(counts, static_cast<std::uint16_t>(c));
    append_little_endian(counts, channel.messages);
    messages += channel.messages, ++used;
  }
  for (const std::string& index : chunk_indices_) chunks += index;
  put_group(Op::schema, schemas);
  put_group(Op::channel, channels);
  content.clear();
  append_little_endian(content, messages);
  append_little_endian(content, used);
  append_little_endian(content, static_cast<std::uint32_t>(used));
  append_little_endian(content, std::uint32_t{0});  // attachments
  append_little_endian(content, std::uint32_t{1});  // metadata
  append_little_endian(content, static_cast<std::uint32_t>(chunk_indices_.size()));
  append_little_endian(content, messages > 0 ? file_span_.first : 0);
  append_little_endian(content, file_span_.last);
  append_little_endian(content, static_cast<std::uint32_t>(counts.size()));
  content += counts;
  put_group(Op::statistics, record_of(Op::statistics, content));
  put_group(Op::chunk_index, chunks);
  content.clear();
  append_little_endian(content, metadata_at);
  append_little_endian(content, metadata_length);
  put_text(content, metadata_name);
  put_group(Op::metadata_index, record_of(Op::metadata_index, content));

  const std::uint64_t offsets_at = file_.size();
  file_ += offsets;
  file_ += static_cast<char>(Op::footer);  // its checksum is that of the summary, the beginning of this record included
  append_little_endian(file_, std::uint64_t{20});
  append_little_endian(file_, summary);
  append_little_endian(file_, offsets_at);
  append_little_endian(file_, crc32(std::string_view(file_).substr(summary)));
  file_ += mcap_magic;
  return std::move(file_);
}

}  // namespace momentree::io

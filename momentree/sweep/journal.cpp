#include <momentree/sweep/journal.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/sweep/checksum.hpp>
#include <momentree/sweep/machines/encoding.hpp>

namespace momentree::sweep {

namespace {

// magic, format, length and CRC of the identity, then the identity
constexpr std::string_view magic = "momentree sweep\n";
constexpr std::uint32_t journal_format = 2;
constexpr std::size_t head_size = 16 + 4 + 4 + 4;
// mark, first, count, size, CRC of these, CRC of the bytes; then the bytes
constexpr std::string_view record_mark = "WRLD";
// A record without worlds: version and hash of accepted changes.
constexpr std::string_view accepted_mark = "ACPT";
constexpr std::size_t record_size = 4 + 8 + 8 + 4 + 4 + 4;
constexpr std::uint64_t largest_record = 1u << 30;

std::int64_t milliseconds_now() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void append_text(std::string& bytes, const std::string& text) {
  append_integer(bytes, text.size(), 4);
  bytes += text;
}

// Takes a text from the beginning; nothing if it is not there.
std::optional<std::string> take_text(std::string_view& bytes) {
  if (bytes.size() < 4) return std::nullopt;
  const std::uint64_t size = integer_at(bytes, 4);
  if (size > bytes.size() - 4) return std::nullopt;
  std::string text(bytes.substr(4, size));
  bytes.remove_prefix(4 + size);
  return text;
}

std::string identity_bytes(const JournalIdentity& identity) {
  std::string bytes;
  append_integer(bytes, identity.worlds, 8);
  append_integer(bytes, identity.measures, 8);
  append_text(bytes, identity.plan);
  append_text(bytes, identity.version);
  append_text(bytes, identity.hash);
  return bytes;
}

// Up to `size` bytes at an offset; fewer at the end of the file.
std::string bytes_at(const io::Descriptor& file, std::uint64_t offset, std::size_t size, const std::string& path) {
  std::string bytes(size, '\0');
  std::size_t got = 0;
  while (got < size) {
    const ssize_t read = ::pread(file.number(), bytes.data() + got, size - got, static_cast<off_t>(offset + got));
    if (read < 0 && errno == EINTR) continue;
    if (read < 0) io::fail_with_reason("cannot read this file", path, io::last_error());
    if (read == 0) break;
    got += static_cast<std::size_t>(read);
  }
  bytes.resize(got);
  return bytes;
}

[[noreturn]] void not_a_journal(const std::string& path) {
  throw_error({"this is not the journal of a sweep, or its beginning is damaged", path, "start again with --restart"});
}

}  // namespace

Journal Journal::create(const std::string& path, const JournalIdentity& identity) {
  io::Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (!file) io::fail_with_reason("cannot make this file", path, io::last_error());
  Journal journal(path, std::move(file));
  journal.identity_ = identity;
  const std::string own = identity_bytes(identity);
  std::string head(magic);
  append_integer(head, journal_format, 4);
  append_integer(head, own.size(), 4);
  append_integer(head, crc32c(own), 4);
  head += own;
  std::size_t written = 0;
  if (const std::error_code error = io::write_all(journal.file_, head, written))
    io::fail_with_reason("cannot write this file", path, error);
  journal.size_ = head.size();
  journal.unflushed_ = true;
  journal.flush();
  return journal;
}

Journal Journal::open(const std::string& path) {
  io::open_regular(path, io::Links::refuse);  // throws for anything else
  io::Descriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!file) io::fail_with_reason("cannot open this file", path, io::last_error());
  Journal journal(path, std::move(file));
  journal.scan();
  return journal;
}

void Journal::scan() {
  const std::string head = bytes_at(file_, 0, head_size, path_);
  if (head.size() < head_size || !head.starts_with(magic)) not_a_journal(path_);
  if (const std::uint64_t format = integer_at(std::string_view(head).substr(16), 4); format != journal_format)
    throw_error({"this journal has format " + std::to_string(format) + ", which this version does not read", path_,
                 "start again with --restart"});
  const std::uint64_t length = integer_at(std::string_view(head).substr(20), 4);
  if (length < 20 || length > 4096) not_a_journal(path_);
  const std::string own = bytes_at(file_, head_size, length, path_);
  if (own.size() < length || crc32c(own) != integer_at(std::string_view(head).substr(24), 4)) not_a_journal(path_);
  identity_.worlds = integer_at(own, 8);
  identity_.measures = integer_at(std::string_view(own).substr(8), 8);
  std::string_view texts = std::string_view(own).substr(16);
  for (std::string* const each : {&identity_.plan, &identity_.version, &identity_.hash}) {
    std::optional<std::string> text = take_text(texts);
    if (!text) not_a_journal(path_);
    *each = std::move(*text);
  }
  size_ = head_size + length;
  scan_records();
  has_rest_ = cut_;
  if (::lseek(file_.number(), static_cast<off_t>(size_), SEEK_SET) < 0)
    io::fail_with_reason("cannot read this file", path_, io::last_error());
  std::vector<Chunk> sorted;
  for (const Entry& entry : entries_) sorted.push_back(entry.chunk);
  std::sort(sorted.begin(), sorted.end(), [](const Chunk& a, const Chunk& b) { return a.first < b.first; });
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i - 1].first + sorted[i - 1].count > sorted[i].first) not_a_journal(path_);
}

struct Journal::Header {
  bool accepted;  ///< a record without worlds
  Entry entry;
  std::uint64_t end() const { return entry.offset + entry.size; }
};

std::optional<Journal::Header> Journal::header_at(std::uint64_t offset) const {
  const std::string record = bytes_at(file_, offset, record_size, path_);
  const std::string_view view = record;
  const bool accepted = view.starts_with(accepted_mark);
  if (record.size() < record_size || (!accepted && !view.starts_with(record_mark))) return std::nullopt;
  const Entry entry{{integer_at(view.substr(4), 8), integer_at(view.substr(12), 8)},
                    offset + record_size,
                    static_cast<std::uint32_t>(integer_at(view.substr(20), 4)),
                    static_cast<std::uint32_t>(integer_at(view.substr(28), 4))};
  if (crc32c(view.substr(0, 24)) != integer_at(view.substr(24), 4) || entry.size > largest_record) return std::nullopt;
  const Chunk& chunk = entry.chunk;
  if (!accepted && (chunk.first >= identity_.worlds || chunk.count == 0 || chunk.count > identity_.worlds - chunk.first))
    return std::nullopt;
  return Header{accepted, entry};
}

// The offset of the first header at `from` or after it.
std::optional<std::uint64_t> Journal::next_header(std::uint64_t from) const {
  constexpr std::size_t block = 1u << 20, overlap = 3;  // of a mark
  for (;; from += block) {
    const std::string bytes = bytes_at(file_, from, block + overlap, path_);
    for (std::size_t i = 0; i + overlap < bytes.size(); ++i) {
      const std::string_view here = std::string_view(bytes).substr(i, record_mark.size());
      if ((here == record_mark || here == accepted_mark) && header_at(from + i)) return from + i;
    }
    if (bytes.size() < block + overlap) return std::nullopt;
  }
}

// Adds a record; false if its bytes are damaged.
bool Journal::take(const Header& header, std::uint64_t offset, const std::string& bytes) {
  const Entry& entry = header.entry;
  if (bytes.size() < entry.size || crc32c(bytes) != entry.crc) return false;
  if (header.accepted) {
    std::string_view rest = bytes;
    const std::optional<std::string> version = take_text(rest), hash = take_text(rest);
    if (!version || !hash) return false;
    former_.push_back({std::exchange(identity_.version, *version), std::exchange(identity_.hash, *hash)});
  } else {
    if (!is_encoded(bytes, identity_.measures, entry.chunk.count)) return false;
    entries_.push_back(entry);
  }
  size_ = offset + record_size + entry.size;
  return true;
}

void Journal::scan_records() {
  std::vector<Header> damaged;
  for (;;) {
    const std::optional<Header> header = header_at(size_);
    std::string bytes;
    if (header) bytes = bytes_at(file_, header->entry.offset, header->entry.size, path_);
    if (header && take(*header, size_, bytes)) continue;
    if (bytes_at(file_, size_, 1, path_).empty()) break;
    // Goes on with the next record. If there is none, the last one was cut off, or is complete and damaged.
    const std::optional<std::uint64_t> next = next_header(size_ + 1);
    const bool complete = header && bytes.size() == header->entry.size;
    if (!next && !complete) {
      cut_ = true;
      break;
    }
    if (header)
      damaged.push_back(*header);
    else
      ++damage_.records;
    size_ = next ? *next : header->end();
  }
  note_damage(damaged);
}

// Worlds that were computed again since then are not lost.
void Journal::note_damage(const std::vector<Header>& damaged) {
  for (const Header& header : damaged) {
    const Chunk& lost = header.entry.chunk;
    const auto overlaps = [&](const Entry& entry) {
      return entry.chunk.first < lost.first + lost.count && lost.first < entry.chunk.first + entry.chunk.count;
    };
    if (std::any_of(entries_.begin(), entries_.end(), overlaps)) continue;
    ++damage_.records;
    damage_.worlds += lost.count;
  }
}

void Journal::append(Chunk chunk, std::string_view bytes) {
  const std::uint64_t offset = size_ + record_size;
  write(record_mark, chunk, bytes);
  entries_.push_back({chunk, offset, static_cast<std::uint32_t>(bytes.size()), crc32c(bytes)});
  if (milliseconds_now() - flushed_at_ >= 1000) flush();
}

void Journal::accept(const JournalIdentity& identity) {
  std::string bytes;
  append_text(bytes, identity.version);
  append_text(bytes, identity.hash);
  write(accepted_mark, {}, bytes);
  flush();
  former_.push_back({identity_.version, identity_.hash});
  identity_ = identity;
}

void Journal::write(std::string_view mark, Chunk chunk, std::string_view bytes) {
  if (bytes.size() > largest_record) throw_error({"the results of one chunk are larger than a journal can hold", path_, ""});
  std::string record(mark);
  append_integer(record, chunk.first, 8);
  append_integer(record, chunk.count, 8);
  append_integer(record, bytes.size(), 4);
  append_integer(record, crc32c(record), 4);
  append_integer(record, crc32c(bytes), 4);
  record += bytes;
  if (has_rest_ && !io::cut(file_, size_)) io::fail_with_reason("cannot truncate this file", path_, io::last_error());
  has_rest_ = false;
  std::size_t written = 0;
  if (const std::error_code error = io::write_all(file_, record, written)) {
    io::cut(file_, size_);  // if this fails, the incomplete record is recognised by its checksum
    io::fail_with_reason("cannot write this file", path_, error);
  }
  size_ += record.size();
  unflushed_ = true;
}

void Journal::flush() {
  if (!unflushed_) return;
  if (const std::error_code error = io::sync(file_)) io::fail_with_reason("cannot write this file", path_, error);
  flushed_at_ = milliseconds_now();
  unflushed_ = false;
}

std::string Journal::read(const Entry& entry) const {
  std::string bytes = bytes_at(file_, entry.offset, entry.size, path_);
  if (bytes.size() != entry.size || crc32c(bytes) != entry.crc)
    throw_error(
        {"this file was changed or damaged during the sweep", path_, "the same command computes the damaged worlds again"});
  return bytes;
}

}  // namespace momentree::sweep

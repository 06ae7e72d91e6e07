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
#include <momentree/sweep/encoding.hpp>

namespace momentree::sweep {

namespace {

// magic, format, length and CRC of the identity, then the identity
constexpr std::string_view magic = "momentree sweep\n";
constexpr std::uint32_t journal_format = 1;
constexpr std::size_t head_size = 16 + 4 + 4 + 4;
// mark, first, count, size, CRC of these, CRC of the bytes; then the bytes
constexpr std::string_view record_mark = "WRLD";
constexpr std::size_t record_size = 4 + 8 + 8 + 4 + 4 + 4;
constexpr std::uint64_t largest_record = 1u << 30;

std::int64_t milliseconds_now() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string identity_bytes(const JournalIdentity& identity) {
  std::string bytes;
  append_integer(bytes, identity.worlds, 8);
  append_integer(bytes, identity.measures, 8);
  append_integer(bytes, identity.version.size(), 4);
  bytes += identity.version + identity.hash;
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
  const std::uint64_t version = integer_at(std::string_view(own).substr(16), 4);
  if (version > own.size() - 20) not_a_journal(path_);
  identity_.version = own.substr(20, version);
  identity_.hash = own.substr(20 + version);
  size_ = head_size + length;
  for (;;) {
    const std::string record = bytes_at(file_, size_, record_size, path_);
    if (record.empty()) break;
    cut_ = true;
    if (record.size() < record_size || !record.starts_with(record_mark)) break;
    const std::string_view view = record;
    const Entry entry{{integer_at(view.substr(4), 8), integer_at(view.substr(12), 8)},
                      size_ + record_size,
                      static_cast<std::uint32_t>(integer_at(view.substr(20), 4)),
                      static_cast<std::uint32_t>(integer_at(view.substr(28), 4))};
    if (crc32c(view.substr(0, 24)) != integer_at(view.substr(24), 4) || entry.size > largest_record) break;
    const Chunk& chunk = entry.chunk;
    if (chunk.first >= identity_.worlds || chunk.count == 0 || chunk.count > identity_.worlds - chunk.first) break;
    const std::string bytes = bytes_at(file_, entry.offset, entry.size, path_);
    if (bytes.size() < entry.size || crc32c(bytes) != entry.crc || !is_encoded(bytes, identity_.measures, chunk.count)) break;
    cut_ = false;
    size_ = entry.offset + entry.size;
    entries_.push_back(entry);
  }
  if (cut_ && !io::cut(file_, size_)) io::fail_with_reason("cannot truncate this file", path_, io::last_error());
  if (::lseek(file_.number(), static_cast<off_t>(size_), SEEK_SET) < 0)
    io::fail_with_reason("cannot read this file", path_, io::last_error());
  std::vector<Chunk> sorted;
  for (const Entry& entry : entries_) sorted.push_back(entry.chunk);
  std::sort(sorted.begin(), sorted.end(), [](const Chunk& a, const Chunk& b) { return a.first < b.first; });
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i - 1].first + sorted[i - 1].count > sorted[i].first) not_a_journal(path_);
}

void Journal::append(Chunk chunk, std::string_view bytes) {
  if (bytes.size() > largest_record) throw_error({"the results of one chunk are larger than a journal can hold", path_, ""});
  std::string record(record_mark);
  append_integer(record, chunk.first, 8);
  append_integer(record, chunk.count, 8);
  append_integer(record, bytes.size(), 4);
  append_integer(record, crc32c(record), 4);
  const std::uint32_t crc = crc32c(bytes);
  append_integer(record, crc, 4);
  record += bytes;
  std::size_t written = 0;
  if (const std::error_code error = io::write_all(file_, record, written)) {
    io::cut(file_, size_);  // if this fails, the incomplete record is recognised by its checksum
    io::fail_with_reason("cannot write this file", path_, error);
  }
  entries_.push_back({chunk, size_ + record_size, static_cast<std::uint32_t>(bytes.size()), crc});
  size_ += record.size();
  unflushed_ = true;
  if (milliseconds_now() - flushed_at_ >= 1000) flush();
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
    throw_error({"this file was changed during the sweep", path_, "start again with --restart"});
  return bytes;
}

}  // namespace momentree::sweep

#pragma once
// The journal of a sweep: an append-only file of finished chunks. What has been appended survives the end of the process at any
// moment; a record that was cut off or damaged is recognised by its checksum and dropped, others are kept.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/sweep/machines/work_source.hpp>
#include <momentree/text/files/system_file.hpp>

namespace momentree::sweep {

/// What a journal belongs to. It is continued only by a sweep with the same identity.
struct JournalIdentity {
  std::string version;         ///< of the program
  std::string hash;            ///< of the sweep, the scenario and the files that they name
  std::string plan;            ///< hash of what determines the varied values of the worlds
  std::uint64_t worlds = 0;    ///< in all
  std::uint64_t measures = 0;  ///< per world
  friend bool operator==(const JournalIdentity&, const JournalIdentity&) = default;
};

/// What a journal belonged to before changes were accepted.
struct FormerIdentity {
  std::string version, hash;
  friend bool operator==(const FormerIdentity&, const FormerIdentity&) = default;
};

class Journal {
 public:
  /// Records that are skipped because they are damaged.
  struct Damage {
    std::uint64_t records = 0;
    std::uint64_t worlds = 0;  ///< that they had, as far as that can be read
  };
  /// A finished chunk in the file.
  struct Entry {
    Chunk chunk;
    std::uint64_t offset = 0;  ///< of its bytes
    std::uint32_t size = 0, crc = 0;
  };

  /// Makes a new journal. Throws Error.
  static Journal create(const std::string& path, const JournalIdentity& identity);
  /// Opens a journal for continuing it, and skips damaged and incomplete records. The file changes at the next write only. Throws
  /// Error if it cannot be read, or if it is not a journal.
  static Journal open(const std::string& path);

  const JournalIdentity& identity() const { return identity_; }
  /// The oldest first.
  const std::vector<FormerIdentity>& former() const { return former_; }
  /// The chunks, in the order of the file. None overlap.
  const std::vector<Entry>& entries() const { return entries_; }
  /// Whether the file ended with an incomplete record, which was dropped.
  bool was_cut() const { return cut_; }
  const Damage& damage() const { return damage_; }

  /// Appends a chunk with one call of the system. Throws Error, for example on a full disk: the file then ends with the last
  /// complete record. Data are flushed to the disk by flush(), and by append() at least every second.
  void append(Chunk chunk, std::string_view bytes);
  void flush();
  /// From now on the journal belongs to that version and hash; the rest of `identity` must be the same. Throws Error.
  void accept(const JournalIdentity& identity);
  /// The bytes of a chunk, checked. Throws Error.
  std::string read(const Entry& entry) const;
  std::uint64_t size() const { return size_; }

 private:
  Journal(std::string path, io::Descriptor file) : path_(std::move(path)), file_(std::move(file)) {}
  struct Header;
  std::optional<Header> header_at(std::uint64_t offset) const;
  std::optional<std::uint64_t> next_header(std::uint64_t from) const;
  bool take(const Header& header, std::uint64_t offset, const std::string& bytes);
  void scan();
  void scan_records();
  void note_damage(const std::vector<Header>& damaged);
  void write(std::string_view mark, Chunk chunk, std::string_view bytes);

  std::string path_;
  io::Descriptor file_;
  JournalIdentity identity_;
  std::vector<FormerIdentity> former_;
  std::vector<Entry> entries_;
  Damage damage_;
  std::uint64_t size_ = 0;  ///< of the complete records
  std::int64_t flushed_at_ = 0;
  bool cut_ = false, unflushed_ = false;
  bool has_rest_ = false;  ///< the file ends with an incomplete record, which the next write removes
};

}  // namespace momentree::sweep

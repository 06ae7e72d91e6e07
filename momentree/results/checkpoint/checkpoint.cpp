#include <momentree/results/checkpoint/checkpoint.hpp>

#include <utility>

#include <momentree/results/checkpoint/event_fields.hpp>

namespace momentree::io {

namespace {

// Like that of PNG: files that were changed by a transfer as text are recognised.
constexpr std::string_view checkpoint_magic = "\x89MTCKPT\r\n\x1a\n";
constexpr std::uint64_t checkpoint_format = 16;

std::string little_endian(std::uint64_t n) {
  std::string bytes;
  for (int i = 0; i < 8; ++i) bytes += static_cast<char>(n >> (8 * i) & 255);
  return bytes;
}

std::uint64_t number_in(std::string_view bytes, std::size_t at) {
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < 8; ++i) n |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return n;
}

}  // namespace

template <class Archive>
void fields(Archive& archive, Part<Archive, RunInput>& i) {
  archive(i.version, i.scenario, i.documents, i.reactions);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, TextFile::Mark>& m) {
  archive(m.size, m.checksum);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, RecorderState::Table>& t) {
  archive(t.file, t.mark, t.last);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, RecorderState>& r) {
  archive(r.tables, r.next, r.row_time, r.events_taken, r.body_quaternions, r.joint_quaternions);
}
template <class Archive>
void fields(Archive& archive, Part<Archive, Checkpoint>& c) {
  archive(c.input, c.every, c.run, c.record, c.scheduled, c.efforts);
}

std::string sealed(const std::string& data) {
  std::string bytes(checkpoint_magic);
  bytes += little_endian(checkpoint_format) + little_endian(data.size()) + data;
  Checksum checksum;
  checksum.add(bytes);
  return bytes + little_endian(checksum.value());
}

std::string_view unsealed(std::string_view bytes, const std::string& path, const CheckpointWords& words) {
  const std::size_t head = checkpoint_magic.size() + 16, tail = 8;
  const std::string name = words.name;
  const auto refuse = [&](const std::string& problem) { throw_error({problem, path, words.again}); };
  if (!bytes.starts_with(checkpoint_magic)) refuse("this is not a checkpoint of momentree");
  if (bytes.size() < head + tail || number_in(bytes, checkpoint_magic.size() + 8) != bytes.size() - head - tail)
    refuse(name + " is incomplete");
  Checksum checksum;
  checksum.add(bytes.substr(0, bytes.size() - tail));
  if (checksum.value() != number_in(bytes, bytes.size() - tail)) refuse(name + " is damaged");
  if (const std::uint64_t found = number_in(bytes, checkpoint_magic.size()); found != checkpoint_format)
    throw_error(
        {name + " has format " + std::to_string(found) + ", and this version reads format " + std::to_string(checkpoint_format),
         path, words.other_version});
  return bytes.substr(head, bytes.size() - head - tail);
}

std::string checkpoint_bytes(const Checkpoint& checkpoint) {
  ArchiveWriter archive;
  archive(checkpoint);
  return sealed(archive.bytes);
}

Checkpoint read_checkpoint(std::string_view bytes, const std::string& path, const CheckpointWords& words) {
  const std::string_view data = unsealed(bytes, path, words);
  Checkpoint checkpoint;
  try {
    ArchiveReader archive(data, "damaged");
    archive(checkpoint);
    archive.require(archive.at_end());
  } catch (const Error&) {
    throw_error({std::string(words.name) + " is damaged", path, words.again});
  }
  return checkpoint;
}

}  // namespace momentree::io

#include <momentree/sweep/machines/messages.hpp>

#include <cstring>
#include <new>
#include <stdexcept>

#include <momentree/base/error.hpp>

namespace momentree::sweep {

namespace {

constexpr std::string_view signature = "MT1";
constexpr double user_error = 0, out_of_memory = 1, other_failure = 2;

template <class Number>
void put(std::string& bytes, Number number) {
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  bytes.append(raw, sizeof number);
}

class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
  std::string_view take(std::uint64_t size) {
    if (size > rest_.size()) fail();
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  template <class Number>
  Number number() {
    Number number;
    std::memcpy(&number, take(sizeof number).data(), sizeof number);
    return number;
  }
  bool at_end() const { return rest_.empty(); }
  [[noreturn]] static void fail() {
    throw_error({"a message from another rank cannot be understood", "",
                 "the same version of momentree must be installed on all machines, and all must have the same byte order"});
  }

 private:
  std::string_view rest_;
};

}  // namespace

std::string encode(const Note& note) {
  std::size_t size = 64;
  for (const std::string& text : note.texts) size += 8 + text.size();
  std::string bytes;
  bytes.reserve(size);
  bytes += signature;
  put(bytes, note.kind);
  put(bytes, note.chunk.first);
  put(bytes, note.chunk.count);
  put(bytes, note.number);
  for (const std::string& text : note.texts) {
    put(bytes, std::uint64_t{text.size()});
    bytes += text;
  }
  return bytes;
}

Note decode(std::string_view bytes) {
  ByteReader reader(bytes);
  if (reader.take(signature.size()) != signature) ByteReader::fail();
  Note note;
  note.kind = reader.number<MessageKind>();
  if (note.kind > MessageKind::leave) ByteReader::fail();
  note.chunk.first = reader.number<std::uint64_t>();
  note.chunk.count = reader.number<std::uint64_t>();
  note.number = reader.number<double>();
  while (!reader.at_end()) note.texts.emplace_back(reader.take(reader.number<std::uint64_t>()));
  const std::size_t texts = note.kind == MessageKind::hello || note.kind == MessageKind::failure ? 3
                            : note.kind == MessageKind::result                                   ? 1
                                                                                                 : 0;
  if (note.texts.size() != texts) ByteReader::fail();
  return note;
}

Note failure_note(const std::exception_ptr& exception) {
  Note note{MessageKind::failure};
  try {
    std::rethrow_exception(exception);
  } catch (const Error& error) {
    note.number = user_error;
    note.texts = {error.problem, error.where, error.hint};
  } catch (const std::bad_alloc&) {
    note.number = out_of_memory;
    note.texts = {"out of memory", "", ""};
  } catch (const std::exception& error) {
    note.number = other_failure;
    note.texts = {error.what(), "", ""};
  } catch (...) {
    note.number = other_failure;
    note.texts = {"unknown failure", "", ""};
  }
  return note;
}

std::exception_ptr failure_of(const Note& note, int rank) {
  const std::string problem = note.texts[0] + " (on rank " + std::to_string(rank) + ")";
  if (note.number == user_error) return std::make_exception_ptr(Error(problem, note.texts[1], note.texts[2]));
  if (note.number == out_of_memory)
    return std::make_exception_ptr(Error(problem, "", "use fewer ranks or threads on each machine"));
  return std::make_exception_ptr(std::runtime_error(problem));
}

}  // namespace momentree::sweep

#include <momentree/sweep/machines/messages.hpp>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>

using namespace momentree;
using namespace momentree::sweep;

TEST_CASE("messages are decoded as they were encoded") {
  const std::string binary("\0\xff\n", 3);
  for (const Note& note :
       {Note{MessageKind::hello, {}, 3, {"1.0", "", binary}}, Note{MessageKind::result, {~0ull, 7}, 0.1, {binary}},
        Note{MessageKind::work, {1, 2}}, Note{MessageKind::failure, {}, 2, {"a", "b", "c"}}}) {
    const Note read = decode(encode(note));
    CHECK(read.kind == note.kind);
    CHECK(read.chunk == note.chunk);
    CHECK(read.number == note.number);
    CHECK(read.texts == note.texts);
  }
}

TEST_CASE("bytes that are no message are refused: each beginning of one, and each with a byte more") {
  const std::string whole = encode({MessageKind::hello, {}, 3, {"1.0", "w", "h"}});
  for (std::size_t size = 0; size < whole.size(); ++size) CHECK_THROWS_AS(decode(whole.substr(0, size)), Error);
  CHECK_THROWS_AS(decode(whole + 'x'), Error);
  CHECK_THROWS_AS(decode("MT2" + whole.substr(3)), Error);
  CHECK_THROWS_AS(decode(std::string(100, '\xff')), Error);
}

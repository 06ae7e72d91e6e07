#pragma once
// Values as bytes: numbers are little-endian and exact, lists begin with their length. What a type consists of is said once, in
// a function `fields(archive, value)`, for writing and for reading, or in `describe` (base/describe.hpp).
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeindex>
#include <utility>
#include <vector>

#include <momentree/base/describe.hpp>
#include <momentree/base/error.hpp>

namespace momentree::io {

/// The value that an archive writes, or reads into.
template <class Archive, class T>
using Part = std::conditional_t<Archive::writes, const T, T>;

class ArchiveWriter {
 public:
  static constexpr bool writes = true;
  std::string bytes;

  template <class... T>
  void operator()(const T&... parts) {
    (put(parts), ...);
  }
  template <class T>
  void operator()(const char*, const T& member, const Field&) {
    put(member);
  }

 private:
  void put_number(std::uint64_t number, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(number >> (8 * i) & 255);
  }
  void put(double x) { put_number(std::bit_cast<std::uint64_t>(x), 8); }
  template <std::integral I>
  void put(I x) {
    put_number(static_cast<std::uint64_t>(x), std::same_as<I, bool> ? 1 : 8);
  }
  void put(const std::string& text) {
    put(text.size());
    bytes += text;
  }
  template <class T>
  void put(const std::vector<T>& list) {
    put(list.size());
    for (const T& each : list) put(each);
  }
  template <class T, std::size_t n>
  void put(const std::array<T, n>& list) {
    for (const T& each : list) put(each);
  }
  template <class A, class B>
  void put(const std::pair<A, B>& pair) {
    put(pair.first), put(pair.second);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  // What is shared is written once, and then by its number.
  template <class T>
  void put(const std::shared_ptr<const T>& value) {
    if (value == nullptr) return put(std::size_t{0});
    const auto [known, first] = shared_.try_emplace(value.get(), shared_.size() + 1);
    put(known->second);
    if (first) put(*value);
  }
  template <class T>
  requires std::is_class_v<T>
  void put(const T& value) {
    if constexpr (requires { describe(*this, value); })
      describe(*this, value);
    else
      fields(*this, value);
  }

  std::map<const void*, std::size_t> shared_;
};

/// Throws Error for bytes that no writer has written. Allocates in proportion to the bytes.
class ArchiveReader {
 public:
  static constexpr bool writes = false;
  /// `what`: the problem of the Error.
  ArchiveReader(std::string_view bytes, const char* what) : left_(bytes), what_(what) {}

  template <class... T>
  void operator()(T&... parts) {
    (get(parts), ...);
  }
  template <class T>
  void operator()(const char*, T& member, const Field&) {
    get(member);
  }
  bool at_end() const { return left_.empty(); }
  [[noreturn]] void fail() const { throw_error({what_, "", ""}); }
  void require(bool holds) const {
    if (!holds) fail();
  }

 private:
  std::uint64_t get_number(std::size_t size) {
    require(left_.size() >= size);
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < size; ++i) number |= std::uint64_t{static_cast<unsigned char>(left_[i])} << (8 * i);
    left_.remove_prefix(size);
    return number;
  }
  std::size_t get_length() {
    const std::uint64_t length = get_number(8);
    require(length <= left_.size());  // every entry has at least one byte
    return static_cast<std::size_t>(length);
  }
  void get(double& x) { x = std::bit_cast<double>(get_number(8)); }
  void get(bool& x) {
    const std::uint64_t number = get_number(1);
    require(number <= 1);
    x = number == 1;
  }
  template <std::integral I>
  void get(I& x) {
    const std::uint64_t number = get_number(8);
    x = static_cast<I>(number);
    require(static_cast<std::uint64_t>(x) == number);
  }
  void get(std::string& text) {
    const std::size_t length = get_length();
    text = left_.substr(0, length);
    left_.remove_prefix(length);
  }
  template <class T>
  void get(std::vector<T>& list) {
    list.clear();
    for (std::size_t left = get_length(); left > 0; --left) get(list.emplace_back());
  }
  template <class T, std::size_t n>
  void get(std::array<T, n>& list) {
    for (T& each : list) get(each);
  }
  template <class A, class B>
  void get(std::pair<A, B>& pair) {
    get(pair.first), get(pair.second);
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool given = false;
    get(given);
    value.reset();
    if (given) get(value.emplace());
  }
  template <class T>
  void get(std::shared_ptr<const T>& value) {
    std::size_t number = 0;
    get(number);
    value.reset();
    if (number == 0) return;
    require(number <= shared_.size() + 1);
    if (number <= shared_.size()) {
      require(shared_[number - 1].first == typeid(T));
      value = std::static_pointer_cast<const T>(shared_[number - 1].second);
      return;
    }
    auto read = std::make_shared<T>();
    shared_.emplace_back(typeid(T), read);
    get(*read);
    value = std::move(read);
  }
  template <class T>
  requires std::is_class_v<T>
  void get(T& value) {
    if constexpr (requires { describe(*this, value); })
      describe(*this, value);
    else
      fields(*this, value);
  }

  std::string_view left_;
  const char* what_;
  std::vector<std::pair<std::type_index, std::shared_ptr<const void>>> shared_;
};

}  // namespace momentree::io

// Small values as bytes of a section: one list of a type's fields (list_fields) writes and reads them, so
// that both agree. Numbers are little-endian at their own width, a text is its length and its characters, an
// optional value a byte and perhaps the value. What is read is only as large as the bytes that are there;
// whether its values make sense is for the caller to find out. Thread-bound.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace hdrcam {

static_assert(std::endian::native == std::endian::little, "sections hold numbers as they are in memory");

// T is Of, or a const Of: list_fields() takes both.
template <class T, class Of>
concept Either = std::same_as<std::remove_const_t<T>, Of>;

class FieldsOut {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (one(values), ...);
  }
  template <class T>
  void word(const T& choice, T) {
    one(static_cast<std::int32_t>(choice));
  }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  template <class T>
  requires std::is_arithmetic_v<T>
  void one(T value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void one(const std::string& text) {
    one(static_cast<std::uint32_t>(text.size()));
    for (const char c : text) one(c);
  }
  template <class T, std::size_t kCount>
  void one(const std::array<T, kCount>& values) {
    for (const T& value : values) one(value);
  }
  template <class T>
  void one(const std::vector<T>& values) {
    one(static_cast<std::uint32_t>(values.size()));
    for (const T& value : values) one(value);
  }
  template <class T>
  void one(const std::optional<T>& value) {
    one(value.has_value());
    if (value) one(*value);
  }
  template <class T>
  requires std::is_class_v<T>
  void one(const T& value) { list_fields(*this, value); }

  std::vector<std::byte> bytes_;
};

class FieldsIn {
 public:
  explicit FieldsIn(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }
  // An enumeration, up to its last word.
  template <class T>
  void word(T& choice, T last) {
    std::int32_t number = 0;
    one(number);
    if (number < 0 || number > static_cast<std::int32_t>(last))
      sound_ = false;
    else
      choice = static_cast<T>(number);
  }
  // Whether all was there, and nothing besides; values are arbitrary where it was not.
  bool complete() const { return sound_ && bytes_.empty(); }

 private:
  template <class T>
  requires(std::is_arithmetic_v<T> && !std::same_as<T, bool>) void one(T& value) {
    if (bytes_.size() < sizeof value) {
      sound_ = false, bytes_ = {};
      return;
    }
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
  }
  void one(bool& value) {
    std::uint8_t byte = 0;
    one(byte);
    sound_ = sound_ && byte <= 1;
    value = byte == 1;
  }
  std::size_t count() {
    std::uint32_t size = 0;
    one(size);
    if (size <= bytes_.size()) return size;  // an element takes a byte or more
    sound_ = false;
    return 0;
  }
  void one(std::string& text) {
    text.resize(count());
    for (char& c : text) one(c);
  }
  template <class T, std::size_t kCount>
  void one(std::array<T, kCount>& values) {
    for (T& value : values) one(value);
  }
  template <class T>
  void one(std::vector<T>& values) {
    values.clear();
    for (std::size_t left = count(); left > 0 && sound_; --left) one(values.emplace_back());
  }
  template <class T>
  void one(std::optional<T>& value) {
    bool there = false;
    one(there);
    value.reset();
    if (there) one(value.emplace());
  }
  template <class T>
  requires std::is_class_v<T>
  void one(T& value) { list_fields(*this, value); }

  std::span<const std::byte> bytes_;
  bool sound_ = true;
};

}  // namespace hdrcam

// JSON as text, whatever the strings in it: names of files and cameras come from outside and need not be
// UTF-8; bytes that are not become U+FFFD. The same of text alone. And JSON of others, read within the stack
// that a thread has. Reentrant.
#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdrcam {

// Levels of arrays and objects in each other. Our own files have five; the library copies and prints a value
// by recursion, which a file of a hundred thousand brackets ends by a crash.
constexpr int kDeepestJson = 64;

// Whether a text, JSON or not, is deeper than that.
inline bool nests_too_deep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_string = !in_string;
    if (c == '\\' && in_string) ++i;
    if (in_string) continue;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kDeepestJson) return true;
  }
  return false;
}

// JSON that others wrote; is_discarded() where the text is none, or nests too deep. Json: as below.
template <class Json>
Json parsed_json(std::string_view text) {
  if (nests_too_deep(text)) return Json(Json::value_t::discarded);
  return Json::parse(text, nullptr, false);
}

// The first key, if any, that one object of a JSON text has twice: the library keeps the last value and says
// nothing. Json: as below.
template <class Json>
std::optional<std::string> repeated_key(std::string_view text) {
  using Event = typename Json::parse_event_t;
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::optional<std::string> repeated;
  const auto look = [&](int, Event event, Json& value) {
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(value.template get<std::string>()).second && !repeated)
      repeated = value.template get<std::string>();
    return true;
  };
  if (Json::parse(text, look, false).is_discarded()) return std::nullopt;
  return repeated;
}

// A whole number that T holds; nullopt for any other value. The library would cut 1.5 and convert 1e99. Json:
// as below.
template <class T, class Json>
std::optional<T> whole_number(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.template get<std::uint64_t>();
    return std::in_range<T>(number) ? std::optional(static_cast<T>(number)) : std::nullopt;
  }
  if (!value.is_number_integer()) return std::nullopt;
  const auto number = value.template get<std::int64_t>();
  return std::in_range<T>(number) ? std::optional(static_cast<T>(number)) : std::nullopt;
}

// What is wrong, of an exception of the library: its message without its own number and position.
inline std::string json_reason(const std::exception& e) {
  const std::string_view what = e.what();
  const auto column = what.find("column ");
  const auto begin = column == std::string_view::npos ? what.find("] ") : what.find(": ", column);
  return std::string(begin == std::string_view::npos ? what : what.substr(begin + 2));
}

// indent: blanks per level; -1: all on one line. Json: nlohmann::json, or ordered_json.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

// The text as json_text() shows it to whoever reads the JSON: UTF-8 in any case. Json: as above.
template <class Json>
std::string as_utf8(std::string_view text) {
  return Json::parse(json_text(Json(std::string(text)))).template get<std::string>();
}

}  // namespace hdrcam

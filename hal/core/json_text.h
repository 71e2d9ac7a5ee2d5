// JSON as text, whatever the strings in it: names of files and cameras come from outside and need not be
// UTF-8; bytes that are not become U+FFFD. Reentrant.
#pragma once

#include <string>

namespace hdrcam {

// indent: blanks per level; -1: all on one line. Json: nlohmann::json, or ordered_json.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace hdrcam

// The page of the live view and its parts, built into the program from web/page/. It loads nothing from
// elsewhere. Reentrant.
#pragma once

#include <span>
#include <string_view>

namespace hdrcam {

struct PagePart {
  const char* path;  // "/live.js"
  const char* type;  // of its content
  std::string_view text;
};

std::span<const PagePart> live_page_parts();

}  // namespace hdrcam

#include "firmware_host/web/live_page.h"

#include <live_page_text.h>  // made of web/page/ by CMake

namespace hdrcam {

std::span<const PagePart> live_page_parts() {
  static constexpr PagePart kParts[] = {
      {"/", "text/html; charset=utf-8", kLiveHtml},
      {"/live.css", "text/css; charset=utf-8", kLiveCss},
      {"/live.js", "text/javascript; charset=utf-8", kLiveJs},
  };
  return kParts;
}

}  // namespace hdrcam

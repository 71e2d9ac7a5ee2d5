#include "hal/footage/exif_segments.h"

#include <string>
#include <string_view>

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace std::string_literals;

namespace {

constexpr std::string_view kSoi = "\xff\xd8", kScan = "\xff\xda";

std::string segment(char kind, const std::string& content) {
  const std::size_t length = content.size() + 2;
  return "\xff"s + kind + static_cast<char>(length >> 8) + static_cast<char>(length & 255) + content;
}

std::string exif(const std::string& fields) { return segment('\xe1', "Exif\0\0"s + fields); }

std::string hidden(std::string jpeg) {
  hide_later_exif({reinterpret_cast<std::uint8_t*>(jpeg.data()), jpeg.size()});
  return jpeg;
}

}  // namespace

TEST_CASE("of several EXIF segments only the first stays one") {
  const std::string jfif = segment('\xe0', "JFIF\0"s),
                    xmp = segment('\xe1', "http://ns.adobe.com/xap/1.0/\0"s);
  const std::string head = std::string(kSoi) + jfif + exif("first") + xmp,
                    rest = segment('\xdb', std::string(65, '\1')) + std::string(kScan) + "\0\10"s;
  std::string later = exif("second");
  const std::string both = hidden(head + later + "\xff" + later + rest);
  later[4] = '\0';
  CHECK(both == head + later + "\xff" + later + rest);
}

TEST_CASE("pictures with one EXIF segment, or damaged, stay as they are") {
  const std::string whole = std::string(kSoi) + exif("first") + std::string(kScan) + exif("behind the scan");
  for (const std::string& jpeg : {whole, std::string(kSoi) + exif("first") + "\xff\xe1\xff", "Exif"s, ""s})
    CHECK(hidden(jpeg) == jpeg);
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    CHECK(hidden(whole.substr(0, bytes)) == whole.substr(0, bytes));
}

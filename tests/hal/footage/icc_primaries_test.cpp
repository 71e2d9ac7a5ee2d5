#include "hal/footage/icc_primaries.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "hal/footage/footage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/files.h"
#include "tests/support/footage_files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

using Colorant = std::array<double, 3>;
constexpr Colorant kSrgbRed{0.43607, 0.22249, 0.01392}, kSrgbGreen{0.38515, 0.71687, 0.09708};
constexpr Colorant kP3Red{0.51512, 0.2412, -0.00105}, kP3Green{0.29198, 0.69225, 0.04189};
constexpr Colorant kAdobeRed{0.60974, 0.31111, 0.01947}, kAdobeGreen{0.20528, 0.62567, 0.06087};

void put_long(std::vector<std::uint8_t>& to, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) to.push_back(static_cast<std::uint8_t>(value >> shift));
}

// With the tags gXYZ and rXYZ.
std::vector<std::uint8_t> profile_of(const Colorant& red, const Colorant& green) {
  constexpr std::uint32_t kXyz = 0x58595a20, kTagBytes = 20, kFirst = 128 + 4 + 2 * 12;
  std::vector<std::uint8_t> profile(128, 0);
  put_long(profile, 2);
  for (const std::uint32_t entry :
       {0x6758595au, kFirst, kTagBytes, 0x7258595au, kFirst + kTagBytes, kTagBytes})
    put_long(profile, entry);
  for (const Colorant& colorant : {green, red}) {
    put_long(profile, kXyz), put_long(profile, 0);
    for (const double value : colorant)
      put_long(profile, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value * 65536))));
  }
  return profile;
}

}  // namespace

TEST_CASE("a colour profile of wider primaries is told from one of sRGB, and damage from both") {
  CHECK_FALSE(states_other_primaries(profile_of(kSrgbRed, kSrgbGreen)));
  CHECK(states_other_primaries(profile_of(kP3Red, kP3Green)));
  const std::vector<std::uint8_t> adobe = profile_of(kAdobeRed, kAdobeGreen);
  CHECK(states_other_primaries(adobe));
  for (std::size_t bytes = 0; bytes < adobe.size(); ++bytes)
    CHECK_FALSE(states_other_primaries(std::span(adobe).first(bytes)));
}

TEST_CASE("footage tells the first primaries that a picture states, where they are not those of BT.709") {
  const std::string folder = sample::scratch_folder("footage_profile");
  Image<std::uint16_t> rgb(3, 32, 48);
  for (auto& code : rgb.samples()) code = 100;
  test::write_jpeg(folder + "/plain.jpg", rgb, std::nullopt);
  const std::string plain = test::text_of(folder + "/plain.jpg");
  const auto with_profile = [&](const std::string& name, const std::vector<std::uint8_t>& profile) {
    const std::string head("ICC_PROFILE\0\1\1", 14);
    std::vector<std::uint8_t> segment{0xff, 0xe2, 0,
                                      static_cast<std::uint8_t>(2 + head.size() + profile.size())};
    segment.insert(segment.end(), head.begin(), head.end());
    segment.insert(segment.end(), profile.begin(), profile.end());
    std::ofstream(folder + name, std::ios::binary)
        << plain.substr(0, 2) << std::string(segment.begin(), segment.end()) << plain.substr(2);
    return folder + name;
  };
  const auto primaries = [](const std::string& path, const std::string& later = "") {
    std::vector<std::string> files{path};
    if (!later.empty()) files.push_back(later);
    const auto footage = open_footage(posix_storage(), files, 0);
    REQUIRE(footage.ok());
    RawFrame frame;
    while (footage.value()->next(frame).value()) {
    }
    return footage.value()->primaries();
  };
  CHECK(primaries(folder + "/plain.jpg") == "");
  CHECK(primaries(with_profile("/srgb.jpg", profile_of(kSrgbRed, kSrgbGreen))) == "");
  const std::string p3 = with_profile("/p3.jpg", profile_of(kP3Red, kP3Green));
  CHECK(primaries(p3) == "a colour profile");
  CHECK(primaries(folder + "/plain.jpg", p3) == "a colour profile");
}

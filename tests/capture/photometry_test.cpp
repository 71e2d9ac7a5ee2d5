#include "capture/photometry.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <memory>

#include "capture/pixel_unpack.h"
#include "tests/capture/misbehaving_camera.h"

namespace hdrcam {
namespace {

using test::MisbehavingCamera;
using test::SensorKind;
using test::SensorSettings;

struct Seen {
  PhotometricSignature picture;
  double truth = 0;  // ln E
};

// The frames of a scene under these exposures, in turn.
std::vector<Seen> look(const SensorSettings& settings, const Photometer& photometer,
                       std::span<const double> times_ms, int frames) {
  MisbehavingCamera sensor(settings, {});
  REQUIRE(sensor.configure({}, 2).ok());
  REQUIRE(sensor.start().ok());
  std::vector<Seen> seen(static_cast<std::size_t>(frames));
  Image<std::uint16_t> codes;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    REQUIRE(
        sensor.queue({i, Duration(static_cast<Duration::rep>(times_ms[i % times_ms.size()] * 1e6)), 1}).ok());
    const auto buffer = sensor.wait({});
    REQUIRE(buffer.ok());
    REQUIRE(unpack_pixels(buffer.value(), {}, codes).ok());
    const PixelCodes kind = codes_of(buffer.value().mode.format);
    photometer.observe(codes, kind.layout, kind.bits, seen[i].picture);
    seen[i].truth = sensor.truth();
  }
  return seen;
}

constexpr double kTimes_ms[] = {1, 4, 16};

TEST_CASE("the ratio of raw exposures is measured to a few per cent", "[capture]") {
  Photometer photometer(PhotometricResponse::linear(BlackLevel(16)));
  const auto seen = look({.pan_px = 0, .light_walk = 0}, photometer, kTimes_ms, 60);
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const auto ratio = photometer.ratio(seen[i - 1].picture, seen[i].picture);
    REQUIRE(ratio);
    const double truth = seen[i].truth - seen[i - 1].truth;
    CHECK(ratio->log_ratio == Approx(truth).margin(0.05));
    CHECK(ratio->allows(truth));
    CHECK(ratio->high - ratio->low < 0.6);
  }
}

TEST_CASE("the truth lies within what the measurement leaves open, in motion and with any response",
          "[capture]") {
  int outside = 0, measured = 0;
  for (const SensorKind kind : {SensorKind::RawBayer10, SensorKind::Gamma8, SensorKind::Film8}) {
    Photometer photometer(kind == SensorKind::RawBayer10 ? PhotometricResponse::linear(BlackLevel(16))
                                                         : PhotometricResponse::unknown());
    for (const double pan_px : {0.0, 1.0, 3.0}) {
      const auto seen =
          look({.kind = kind, .pan_px = pan_px, .light_walk = 0.005}, photometer, kTimes_ms, 150);
      for (std::size_t i = 3; i < seen.size(); ++i) {
        for (std::size_t lag = 1; lag <= 3; ++lag) {
          const auto ratio = photometer.ratio(seen[i - lag].picture, seen[i].picture);
          measured += ratio.has_value();
          outside += ratio && !ratio->allows(seen[i].truth - seen[i - lag].truth);
        }
      }
    }
  }
  CAPTURE(measured, outside);
  CHECK(measured > 3500);
  CHECK(outside <= measured / 1000);
}

TEST_CASE("with an unknown response equal stays equal and brighter stays brighter", "[capture]") {
  Photometer photometer(PhotometricResponse::unknown());
  for (const SensorKind kind : {SensorKind::Gamma8, SensorKind::Film8}) {
    const auto seen = look({.kind = kind, .pan_px = 1, .light_walk = 0}, photometer, kTimes_ms, 60);
    for (std::size_t i = 3; i < seen.size(); ++i) {
      const auto step = photometer.ratio(seen[i - 1].picture, seen[i].picture);
      const auto same = photometer.ratio(seen[i - 3].picture, seen[i].picture);
      REQUIRE(step);
      REQUIRE(same);
      CHECK(std::signbit(step->low) == std::signbit(seen[i].truth - seen[i - 1].truth));
      CHECK(std::signbit(step->high) == std::signbit(seen[i].truth - seen[i - 1].truth));
      CHECK(same->allows(0));
      CHECK(same->high - same->low < 2);
    }
  }
}

TEST_CASE("raw codes with a black level that nobody knows are measured more widely, and truly", "[capture]") {
  Photometer photometer(PhotometricResponse::linear_unknown_black());
  constexpr double kTwo_ms[] = {4, 16};
  const auto seen = look({.pan_px = 1, .light_walk = 0}, photometer, kTwo_ms, 60);
  int measured = 0;
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const auto ratio = photometer.ratio(seen[i - 1].picture, seen[i].picture);
    if (!ratio) continue;
    ++measured;
    CHECK(ratio->allows(seen[i].truth - seen[i - 1].truth));
    CHECK_FALSE(ratio->allows(0));
  }
  CHECK(measured > 30);
}

TEST_CASE("darkness, white-out and another scene have no ratio", "[capture]") {
  Photometer photometer(PhotometricResponse::linear(BlackLevel(16)));
  const auto dark = look({.key = 1e-5}, photometer, kTimes_ms, 4);
  CHECK_FALSE(photometer.ratio(dark[0].picture, dark[1].picture));
  CHECK(dark[0].picture.dark_share == 1);
  const auto white = look({.key = 1e5}, photometer, kTimes_ms, 4);
  CHECK_FALSE(photometer.ratio(white[0].picture, white[1].picture));
  CHECK(white[0].picture.clipped_share > 0.9f);
  int confused = 0;
  for (unsigned seed = 1; seed < 20; ++seed) {
    const auto here = look({.light_walk = 0, .seed = seed}, photometer, kTimes_ms, 1);
    const auto there = look({.light_walk = 0, .seed = seed + 100}, photometer, kTimes_ms, 1);
    const auto ratio = photometer.ratio(here[0].picture, there[0].picture);
    confused += ratio && ratio->high - ratio->low < 1;
  }
  CHECK(confused == 0);
}

TEST_CASE("small pictures are compared by the sites that they have", "[capture]") {
  Photometer photometer(PhotometricResponse::linear(BlackLevel(16)));
  const auto seen = look({.width = 64, .height = 48, .pan_px = 0, .object = false, .light_walk = 0},
                         photometer, kTimes_ms, 4);
  CHECK(seen[0].picture.sites == 16 * 12);
  const auto ratio = photometer.ratio(seen[0].picture, seen[1].picture);
  REQUIRE(ratio);
  CHECK(ratio->allows(seen[1].truth - seen[0].truth));

  PhotometricSignature tiny;
  photometer.observe(Image<std::uint16_t>(1, 2, 2), PixelLayout::BayerRggb, 10, tiny);
  CHECK(tiny.sites == 0);
  CHECK_FALSE(photometer.ratio(tiny, tiny));
}

TEST_CASE("of a picture of any size only so many pixels are read: those of 1200 boxes of eight by eight",
          "[capture]") {
  constexpr int kRows = 360, kCols = 480, kBox = 8;
  const Photometer photometer(PhotometricResponse::linear(BlackLevel(16)));
  Image<std::uint16_t> codes(1, kRows, kCols);
  for (std::size_t i = 0; i < codes.size(); ++i)
    codes.samples()[i] = static_cast<std::uint16_t>(200 + i * 7919 % 600);
  PhotometricSignature before, after;
  photometer.observe(codes, PixelLayout::Mono, 10, before);
  // Whether the signature shows that these pixels become darker.
  const auto is_read = [&](int y0, int y1, int x0, int x1) {
    const auto darken = [&](int by) {
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) codes.at(0, y, x) = static_cast<std::uint16_t>(codes.at(0, y, x) - by);
    };
    darken(100);
    photometer.observe(codes, PixelLayout::Mono, 10, after);
    darken(-100);
    return after.at_site != before.at_site;
  };
  int rows = 0, cols = 0;
  for (int y = 0; y < kRows; ++y) rows += is_read(y, y + 1, 0, kCols) ? 1 : 0;
  for (int x = 0; x < kCols; ++x) cols += is_read(0, kRows, x, x + 1) ? 1 : 0;
  CHECK(rows == PhotometricSignature::kSiteRows * kBox);
  CHECK(cols == PhotometricSignature::kSiteCols * kBox);
}

// Every captured frame is measured. Sorting is most of the work: it is the yardstick, which is as slow as the
// rest on a slow or a busy machine.
TEST_CASE("a frame and its seven ratios cost less than to sort its sites 150 times", "[capture]") {
  using Clock = std::chrono::steady_clock;
  constexpr int kSorts = 150;
  Photometer photometer(PhotometricResponse::linear(BlackLevel(16)));
  const auto seen = look({.width = 320, .height = 240}, photometer, kTimes_ms, 8);
  Image<std::uint16_t> codes(1, 240, 320);
  for (std::size_t i = 0; i < codes.size(); ++i)
    codes.samples()[i] = static_cast<std::uint16_t>(64 + i * 7919 % 900);
  auto picture = std::make_unique<PhotometricSignature>();
  Clock::duration measuring = Clock::duration::max(), sorting = Clock::duration::max();  // the shortest
  for (int i = 0; i < 20; ++i) {
    const auto begin = Clock::now();
    photometer.observe(codes, PixelLayout::BayerRggb, 10, *picture);
    for (std::size_t k = 0; k < 7; ++k) (void)photometer.ratio(seen[k].picture, seen[7].picture);
    const auto measured = Clock::now();
    for (int k = 0; k < kSorts; ++k) {
      picture->by_rank = picture->at_site;
      std::sort(picture->by_rank.begin(), picture->by_rank.end());
    }
    measuring = std::min(measuring, measured - begin), sorting = std::min(sorting, Clock::now() - measured);
  }
  CAPTURE(measuring.count(), sorting.count());
  CHECK(measuring < sorting);
}

}  // namespace
}  // namespace hdrcam

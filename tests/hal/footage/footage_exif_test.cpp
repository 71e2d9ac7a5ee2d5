// The exposure and the camera that the stills of other cameras state.
#include "hal/footage/footage.h"

#include <fstream>

#include "tests/hal/footage/read_footage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/footage_files.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::difference;
using test::patches;
using test::pictures;
using test::read_footage;
using test::ReadFootage;
using test::refusal;

TEST_CASE("JPEG pictures say their exposure in EXIF: time, sensitivity, aperture") {
  const std::string folder = sample::scratch_folder("footage_jpeg");
  test::write_jpeg(folder + "/a.jpg", patches(0), test::Exif{1, 1000, 100, 28});
  test::write_jpeg(folder + "/b.jpg", patches(1), test::Exif{10, 60, 400, 56});
  test::write_jpeg(folder + "/c.jpg", patches(2), std::nullopt);
  const ReadFootage bracket = read_footage({folder + "/a.jpg", folder + "/b.jpg", folder + "/c.jpg"});
  REQUIRE_FALSE(bracket.error);
  REQUIRE(bracket.frames.size() == 3);
  CHECK(bracket.frames[0].facts.exposure_source == ExposureSource::Embedded);
  CHECK(bracket.frames[0].facts.exposure_s == Approx(0.001));
  CHECK(bracket.frames[0].facts.analogue_gain == Approx(1));
  CHECK(bracket.frames[1].facts.exposure_s == Approx(1.0 / 6));
  CHECK(bracket.frames[1].facts.analogue_gain == Approx(4));
  CHECK(bracket.frames[0].facts.digital_gain / bracket.frames[1].facts.digital_gain ==
        Approx(4));  // two stops
  CHECK(bracket.frames[2].facts.exposure_source == ExposureSource::Unknown);
  CHECK(difference(bracket.frames[0], bracket.camera.bits, patches(0)) < 2.5);
  CHECK(bracket.camera.framerate_hz == Approx(30));  // stills do not say it
}

TEST_CASE("an exposure time of numbers from 2^31 on is no negative one") {
  const std::string path = sample::scratch_folder("footage_large_rational") + "/a.jpg";
  const std::pair<test::Exif, double> times[] = {{{4'000'000'000, 1'000'000'000}, 4},
                                                 {{10'000'000, 2'500'000'000}, 0.004},
                                                 {{2'147'483'648, 4'294'967'295}, 0.5}};
  for (const auto& [exif, time_s] : times) {
    CAPTURE(exif.time_numerator, exif.time_denominator);
    test::write_jpeg(path, patches(0), exif);
    const ReadFootage still = read_footage({path});
    REQUIRE_FALSE(still.error);
    REQUIRE(still.frames.size() == 1);
    CHECK(still.frames[0].facts.exposure_source == ExposureSource::Embedded);
    CHECK(still.frames[0].facts.exposure_s == Approx(time_s));
  }
}

TEST_CASE("of a JPEG with two EXIF segments the first one counts, as in other readers") {
  const std::string path = sample::scratch_folder("footage_two_exif") + "/a.jpg";
  test::write_jpeg(path, patches(0), test::Exif{1, 250, 400, 56});
  const std::vector<std::uint8_t> first = test::exif_segment({1, 1000, 100, 28});
  const std::size_t length = first.size() + 2;
  const std::string mark{'\xff', '\xe1', static_cast<char>(length >> 8), static_cast<char>(length & 255)};
  std::string bytes = test::text_of(path);
  bytes.insert(2, mark + std::string(first.begin(), first.end()));  // behind the start of the image
  std::ofstream(path, std::ios::binary) << bytes;
  const ReadFootage still = read_footage({path});
  REQUIRE_FALSE(still.error);
  REQUIRE(still.frames.size() == 1);
  CHECK(still.frames[0].facts.exposure_s == Approx(0.001));
  CHECK(still.frames[0].facts.analogue_gain == Approx(1));
  CHECK(difference(still.frames[0], still.camera.bits, patches(0)) < 2.5);
}

TEST_CASE("stills of two models of cameras are no clip, and both are named") {
  const std::string folder = sample::scratch_folder("footage_models");
  const std::vector<std::string> models{"", "EOS R5 ", "EOS R5", "X-T4"};
  std::vector<std::string> files;
  for (std::size_t i = 0; i < models.size(); ++i) {
    files.push_back(fmt::format("{}/{}.jpg", folder, i));
    test::Exif exif;
    exif.model = models[i];
    test::write_jpeg(files.back(), patches(static_cast<int>(i)), exif);
  }
  const ReadFootage mixed = read_footage(files);
  CHECK(mixed.frames.size() == 3);
  CHECK_THAT(refusal(mixed, ErrorCode::Invalid),
             Contains("3.jpg' was taken by the camera 'X-T4'") && Contains("1.jpg' by 'EOS R5',"));
  files.pop_back();
  CHECK_FALSE(read_footage(files).error);
}

TEST_CASE("a sensitivity beyond 65535 is the one that EXIF states beside it") {
  const std::string folder = sample::scratch_folder("footage_iso");
  test::Exif exif{1, 1000, 65535, 28};
  exif.exposure_index = 204800;
  test::write_jpeg(folder + "/a.jpg", patches(0), exif);
  exif.iso = 51200;  // what stands beside it does not count
  test::write_jpeg(folder + "/b.jpg", patches(1), exif);
  const ReadFootage bracket = read_footage({folder + "/a.jpg", folder + "/b.jpg"});
  REQUIRE_FALSE(bracket.error);
  REQUIRE(bracket.frames.size() == 2);
  CHECK(bracket.frames[0].facts.analogue_gain == Approx(2048));
  CHECK(bracket.frames[1].facts.analogue_gain == Approx(512));
}

TEST_CASE("an exposure that EXIF states in APEX alone is a time and an f-number") {
  const std::string folder = sample::scratch_folder("footage_apex");
  const std::pair<int, double> times[] = {{80, 1. / 256}, {-10, 2}};  // tenths of APEX, seconds
  for (const auto& [apex, time_s] : times) {
    test::Exif exif;
    exif.time_apex = apex, exif.aperture_apex = 40;  // f/4
    test::write_jpeg(folder + "/a.jpg", patches(0), exif);
    const ReadFootage still = read_footage({folder + "/a.jpg"});
    REQUIRE_FALSE(still.error);
    REQUIRE(still.frames.size() == 1);
    CHECK(still.frames[0].facts.exposure_source == ExposureSource::Embedded);
    CHECK(still.frames[0].facts.exposure_s == Approx(time_s));
    CHECK(still.frames[0].facts.digital_gain == Approx(1. / 16));
  }
}

TEST_CASE("a focal length for 35 mm film is the lens of the clip, by the diagonal of its pictures") {
  const std::string path = sample::scratch_folder("footage_lens") + "/a.jpg";
  test::Exif exif;
  const auto lens = [&] {
    test::write_jpeg(path, patches(0, 72, 96), exif);  // a diagonal of 120 pixels, of 43.27 mm on film
    const auto footage = open_footage(posix_storage(), {path}, 0);
    REQUIRE(footage.ok());
    return footage.value()->camera().intrinsics;
  };
  CHECK_FALSE(lens());
  exif.focal_35mm_mm = 28;
  REQUIRE(lens());
  CHECK(lens()->fx_px == Approx(77.66).margin(0.01));
  CHECK(lens()->fy_px == lens()->fx_px);
  CHECK(lens()->cx_px == 48);
  CHECK(lens()->cy_px == 36);
}

TEST_CASE("a sensitivity that EXIF states as recommended exposure index alone counts") {
  const std::string folder = sample::scratch_folder("footage_index");
  test::Exif exif{1, 1000, 0, 28};
  exif.exposure_index = 400;
  test::write_jpeg(folder + "/a.jpg", patches(0), exif);
  const auto footage = open_footage(posix_storage(), {folder + "/a.jpg"}, 0);
  REQUIRE(footage.ok());
  RawFrame frame;
  REQUIRE(footage.value()->next(frame).value());
  CHECK(frame.facts.analogue_gain == Approx(4));
  CHECK(footage.value()->factors().iso);
}

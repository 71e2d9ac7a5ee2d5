#include "render/scores/scores.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "render/exr.h"
#include "render/scores/scores_json.h"
#include "tests/render/scores/synthetic_clip.h"

#include "tests/support/as_nobody.h"

namespace hdrcam {
namespace {

using synthetic_clip::Geometry;
using synthetic_clip::kFrames;
using synthetic_clip::TemporaryFolder;

void write_clip_and_estimates(const std::string& folder, Geometry geometry,
                              const char* name_pattern = "{:06d}.exr") {
  synthetic_clip::write_clip(folder);
  REQUIRE(posix_storage().make_directories(folder + "/out").ok());
  for (int i = 0; i < kFrames; ++i)
    synthetic_clip::write_estimate(folder + "/out/" + fmt::format(fmt::runtime(name_pattern), i), i,
                                   geometry);
}

ClipScores scores_of(const TemporaryFolder& clip, const ScoreOptions& options = {}) {
  auto scores = score_clip(posix_storage(), clip.path(), clip / "out", options);
  REQUIRE(scores.ok());
  return std::move(scores).value();
}

Error error_of(const std::string& clip, const std::string& out, const ScoreOptions& options = {}) {
  const auto scores = score_clip(posix_storage(), clip, out, options);
  REQUIRE_FALSE(scores.ok());
  return scores.error();
}

// An uncompressed float picture ends with its samples: the last of R in the last row becomes a NaN.
void write_with_a_nan(const std::string& path, const Image<float>& rgb) {
  ExrPicture picture{rgb.rows(), rgb.cols(), {}, {}, ExrCompression::None};
  for (int c = 0; c < 3; ++c)
    picture.channels.push_back(
        {std::string(exr_channel::kRadiance[c]), {rgb.plane(c), rgb.plane_size()}, ExrSample::Float});
  std::vector<std::byte> bytes = encode_exr(picture).value();
  for (std::size_t i = bytes.size() - 4; i < bytes.size(); ++i) bytes[i] = std::byte{0x7f};
  bytes[bytes.size() - 2] = std::byte{0xff};
  const float last = decode_exr(bytes, "nan.exr").value().samples.plane(2)[rgb.plane_size() - 1];
  REQUIRE(std::isnan(last));
  REQUIRE(write_whole(posix_storage(), path, bytes).ok());
}

// Makes an estimate a film's frame, which shows this moment of the recording.
void write_as_filmed(const std::string& path, double recorded_s) {
  const ExrImage image = read_exr(posix_storage(), path).value();
  ExrPicture picture{image.samples.rows(), image.samples.cols(), {}, {}, ExrCompression::Zip};
  for (std::size_t c = 0; c < image.names.size(); ++c)
    picture.channels.push_back({image.names[c],
                                {image.samples.plane(static_cast<int>(c)), image.samples.plane_size()},
                                ExrSample::Float});
  picture.attributes.texts[kExrRecordedSeconds] = fmt::format("{:.9f}", recorded_s);
  REQUIRE(write_whole(posix_storage(), path, encode_exr(picture).value()).ok());
}

bool mentions(const Error& error, const std::string& word) {
  return error.message.find(word) != std::string::npos;
}

}  // namespace

TEST_CASE("writes the synthetic clip for another program to score", "[.][keep-clip]") {
  const char* folder = std::getenv("HDRCAM_KEEP_CLIP");
  REQUIRE(folder != nullptr);
  write_clip_and_estimates(folder, Geometry::Without, "{:04d}.exr");
}

// The expected numbers are those of reference_scores.py (numpy 1.24, OpenCV 4.6) on this clip.
TEST_CASE("the scores of a clip are those of the reference script") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  const ClipScores scores = scores_of(clip);
  REQUIRE(scores.frames.size() == 6);
  REQUIRE(scores.missing.empty());
  REQUIRE(scores.mean.psnr_mu_db == Approx(40.8400).margin(0.001));
  REQUIRE(scores.mean.psnr_l_db == Approx(36.7452).margin(0.001));
  REQUIRE(scores.mean.psnr_pu_db == Approx(39.6888).margin(0.001));
  REQUIRE(*scores.mean.psnr_mu_moving_db == Approx(42.4695).margin(0.001));
  REQUIRE(scores.worst.picture.psnr_mu_db == Approx(40.4837).margin(0.001));
  REQUIRE(scores.mean.ssim_mu == Approx(0.996204).margin(1e-5));
  REQUIRE(scores.mean.log_rmse_stops == Approx(0.098362).margin(1e-5));
  REQUIRE(*scores.flicker_stops == Approx(0.090289).margin(1e-5));
  REQUIRE(*scores.flicker_background_stops == Approx(0.089938).margin(1e-5));
  REQUIRE(scores.phase_stops == Approx(0.041127).margin(1e-5));
  REQUIRE(scores.shared.white == 6.0);
  REQUIRE(scores.shared.gain[0] == Approx(2.000972).margin(1e-5));
  REQUIRE(scores.shared.gain[1] == Approx(1.254239).margin(1e-5));
  REQUIRE(scores.shared.gain[2] == Approx(0.796314).margin(1e-5));
}

TEST_CASE("white is the 99.9th percentile of a clip whose shortest exposure saturates above it") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  std::ofstream(clip / "gt/gt.json") << R"({"r_sat_shortest": 1000.0, "moving_ids": [1]})";
  const ClipScores scores = scores_of(clip, {.skip = 2});
  REQUIRE(scores.frames.size() == 4);
  REQUIRE(scores.shared.white == Approx(38.91507).margin(1e-4));
  REQUIRE(scores.mean.psnr_mu_db == Approx(40.9304).margin(0.001));
  REQUIRE(*scores.flicker_stops == Approx(0.090483).margin(1e-5));
}

TEST_CASE("the truth itself scores without error, whatever gain each channel has") {
  TemporaryFolder clip;
  synthetic_clip::write_clip(clip.path());
  REQUIRE(posix_storage().make_directories(clip / "out").ok());
  for (int i = 0; i < kFrames; ++i) {
    Image<float> rgb = synthetic_clip::radiance(i);
    for (float& v : std::span(rgb.plane(1), rgb.plane_size())) v *= 16;
    ExrPicture picture{rgb.rows(), rgb.cols(), {}, {}, ExrCompression::Piz};
    for (int c = 0; c < 3; ++c)
      picture.channels.push_back(
          {std::string(exr_channel::kRadiance[c]), {rgb.plane(c), rgb.plane_size()}, ExrSample::Float});
    REQUIRE(
        write_whole(posix_storage(), clip / fmt::format("out/{}.exr", i), encode_exr(picture).value()).ok());
  }
  const ClipScores scores = scores_of(clip, {.skip = 0});
  REQUIRE(scores.frames.size() == kFrames);
  REQUIRE(scores.mean.psnr_mu_db > 100);
  REQUIRE(scores.mean.ssim_mu == Approx(1).margin(1e-6));
  REQUIRE(*scores.flicker_stops < 1e-5);
  REQUIRE(scores.phase_stops < 1e-5);
  // but a cast does not hide from one gain for all channels
  REQUIRE(scores.psnr_mu_single_gain_db < 25);
  REQUIRE(scores.cast_stops[0] == Approx(4 / 3.).margin(1e-3));
  REQUIRE(scores.cast_stops[1] == Approx(-8 / 3.).margin(1e-3));
}

TEST_CASE("an exposure that alternates by gain pumps as one that alternates by time") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  const double phase_stops = scores_of(clip).phase_stops;
  REQUIRE(phase_stops > 0.01);
  auto json = nlohmann::json::parse(std::ifstream(clip / "clip.json"));
  for (auto& frame : json["frames"]) {
    const double exposure = frame["exposure_s"];
    frame["exposure_s"] = 0.0005, frame["gain"] = exposure / 0.001, frame["digital_gain"] = 2;
  }
  std::ofstream(clip / "clip.json") << json;
  REQUIRE(scores_of(clip).phase_stops == Approx(phase_stops));

  std::string text = json.dump();
  text.insert(text.find("\"gain\""), "\"gain\":1,");
  std::ofstream(clip / "clip.json") << text;
  REQUIRE(mentions(error_of(clip.path(), clip / "out"), "'gain' twice"));

  json["frames"][2]["gain"] = -4;
  std::ofstream(clip / "clip.json") << json;
  const Error wrong = error_of(clip.path(), clip / "out");
  REQUIRE(wrong.code == ErrorCode::BadExposure);
  REQUIRE((mentions(wrong, "frame 2") && mentions(wrong, "gain -4")));
}

TEST_CASE("a frame without an estimate is reported and left out, and flicker never spans the gap") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without, "{:04d}.exr");
  std::filesystem::remove(clip / "out/0003.exr");
  std::filesystem::remove(clip / "out/0000.exr");  // skipped anyway
  const ClipScores scores = scores_of(clip);
  REQUIRE(scores.missing == std::vector<std::uint64_t>{3});
  REQUIRE(scores.frames.size() == 5);
  for (const FrameScores& scored : scores.frames)
    REQUIRE(scored.flicker_stops.has_value() == (scored.frame != 1 && scored.frame != 4));
}

TEST_CASE("frames whose numbers need more than 32 bits are scored, and a number below 0 is refused") {
  TemporaryFolder clip;
  synthetic_clip::write_clip(clip.path());
  REQUIRE(posix_storage().make_directories(clip / "out").ok());
  auto json = nlohmann::json::parse(read_whole(posix_storage(), clip / "clip.json").value());
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    const std::uint64_t number = 3'000'000'000 + i;
    json["frames"][i]["sequence"] = number;
    synthetic_clip::write_estimate(clip / fmt::format("out/{}.exr", number), static_cast<int>(i),
                                   Geometry::Without);
  }
  std::ofstream(clip / "clip.json") << json;
  const ClipScores scores = scores_of(clip);
  REQUIRE(scores.frames.size() == 6);
  CHECK(scores.missing.empty());
  CHECK(scores.frames[0].frame == 3'000'000'001);

  json["frames"][2]["sequence"] = -1;
  std::ofstream(clip / "clip.json") << json;
  const Error below = error_of(clip.path(), clip / "out");
  CHECK(below.code == ErrorCode::Corrupt);
  CHECK(mentions(below, "frame 2 of"));
}

TEST_CASE(
    "views from other cameras are scored where truth and estimate have them, with the gains of the clip") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  CHECK_FALSE(scores_of(clip).novel_psnr_mu_db);
  for (const char* folder : {"gt/novel", "out/novel"})
    REQUIRE(posix_storage().make_directories(clip / folder).ok());
  // The views are those of frame 2, so the score is that of frame 2; of frame 4 there is no truth.
  std::filesystem::copy_file(clip / "gt/hdr/0002.exr", clip / "gt/novel/0002.exr");
  for (const char* estimate : {"000002.exr", "000004.exr"})
    std::filesystem::copy_file(clip / "out/000002.exr", clip / (std::string("out/novel/") + estimate));
  const ClipScores scores = scores_of(clip);
  REQUIRE(scores.novel_psnr_mu_db);
  CHECK(*scores.novel_psnr_mu_db == Approx(scores.frames[1].picture.psnr_mu_db));

  std::filesystem::copy_file(clip / "out/000002.exr", clip / "out/novel/2.exr");
  const Error twice = error_of(clip.path(), clip / "out");
  CHECK(twice.code == ErrorCode::Invalid);
  CHECK(mentions(twice, "are both frame 2"));
}

TEST_CASE("a film is scored where its frames show the moments of the clip's, and refused where they do not") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  const double recorded_db = scores_of(clip).mean.psnr_mu_db;
  const auto film = [&](double speed, double off_s) {
    for (int i = 0; i < kFrames; ++i)
      write_as_filmed(clip / fmt::format("out/{:06d}.exr", i), i / 30.0 * speed + off_s);
  };
  for (const double off_s : {0.0, 0.4 / 30, -0.4 / 30}) {
    film(1, off_s);
    CHECK(scores_of(clip).mean.psnr_mu_db == recorded_db);
  }
  film(0.25, 0);
  const Error slow = error_of(clip.path(), clip / "out");
  CHECK(slow.code == ErrorCode::Invalid);
  CHECK(mentions(slow,
                 "000001.exr' is a film's frame that shows the recording at 0.008 s, and frame 1 of the "
                 "clip is at 0.033 s"));
  film(1, 0.2);
  CHECK(mentions(error_of(clip.path(), clip / "out"), "000001.exr' is a film's frame"));
}

TEST_CASE("the flow of the field is scored everywhere, and on what moves in the world") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::With);
  const ClipScores scores = scores_of(clip);
  CHECK(*scores.field_flow_epe_px == Approx(*scores.flow_backward_epe_px));
  // On the square the reversed truth is (1, -2), the field's (-1.5, -0.5).
  CHECK(*scores.field_flow_moving_epe_px == Approx(std::hypot(2.5, 1.5)).epsilon(0.02));
}

TEST_CASE("estimates that carry depth and flow are scored on them") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::With);
  const ClipScores scores = scores_of(clip);
  // Depth is right but for its scale, and 3 % off on the square: 120 of 48 x 36 pixels.
  REQUIRE(*scores.depth_abs_rel == Approx(0.03 * 120 / (48 * 36)).epsilon(1e-3));
  // Each vector is off by (0.3, -0.4).
  REQUIRE(*scores.flow_forward_epe_px == Approx(0.5).epsilon(1e-4));
  // On the square the reversed truth is (1, -2), the estimate (-1.5, -0.5).
  int seen = 0, square = 0;
  for (int i = 1; i < kFrames - 2; ++i) {
    const Image<float> flow = synthetic_clip::flow(i);
    for (int y = 0; y < flow.rows(); ++y)
      for (int x = 0; x < flow.cols(); ++x) {
        const bool on_square = flow.at(0, y, x) < 0;
        const float to_x = static_cast<float>(x) + flow.at(0, y, x),
                    to_y = static_cast<float>(y) + flow.at(1, y, x);
        const bool comparable = flow.at(2, y, x) == 0 && to_x <= 47 && to_y <= 35;
        seen += comparable, square += comparable && on_square;
      }
  }
  REQUIRE(square == 5 * 120);
  REQUIRE(*scores.flow_backward_epe_px == Approx(std::hypot(2.5, 1.5) * square / seen).epsilon(1e-4));
}

TEST_CASE("motion to the next frame is scored where that frame has an estimate") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::With);
  // the last frame of a run knows of no next one
  const std::string last = clip / "out/000004.exr";
  ExrImage image = read_exr(posix_storage(), last).value();
  for (const std::string_view name : exr_channel::kFlowForward)
    std::ranges::fill(std::span(image.samples.plane(*image.find(name)), image.samples.plane_size()), 0.f);
  ExrPicture picture{image.samples.rows(), image.samples.cols(), {}, {}, ExrCompression::Piz};
  for (std::size_t c = 0; c < image.names.size(); ++c)
    picture.channels.push_back({image.names[c],
                                {image.samples.plane(static_cast<int>(c)), image.samples.plane_size()},
                                ExrSample::Float});
  REQUIRE(write_whole(posix_storage(), last, encode_exr(picture).value()).ok());
  for (const int later : {5, 6, 7}) std::filesystem::remove(clip / fmt::format("out/{:06d}.exr", later));
  CHECK(*scores_of(clip).flow_forward_epe_px == Approx(0.5).epsilon(1e-4));
}

TEST_CASE("a broken estimate is scored, not refused: NaN counts as black") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  const double sound = scores_of(clip).mean.psnr_mu_db;
  REQUIRE(scores_of(clip).not_finite.empty());
  write_with_a_nan(clip / "out/000004.exr", synthetic_clip::estimate(4));
  const ClipScores scores = scores_of(clip);
  REQUIRE(std::isfinite(scores.mean.psnr_mu_db));
  REQUIRE(scores.mean.psnr_mu_db < sound);
  REQUIRE(scores.not_finite.size() == 1);
  CHECK(scores.not_finite.front().path == clip / "out/000004.exr");
  CHECK(scores.not_finite.front().samples == 1);
  const auto json = nlohmann::json::parse(to_json(scores, "a clip", "a label"));
  REQUIRE(json.at("not_finite").size() == 1);
  CHECK(json.at("not_finite").at(0).at("file") == clip / "out/000004.exr");
  CHECK(json.at("not_finite").at(0).at("samples") == 1);
}

TEST_CASE("a truth that is not finite is refused, with its file and how many samples") {
  for (const char* kind : {"hdr", "flow"}) {
    TemporaryFolder clip;
    write_clip_and_estimates(clip.path(), Geometry::Without);
    const std::string file = clip / fmt::format("gt/{}/0004.exr", kind);
    write_with_a_nan(file, synthetic_clip::radiance(4));
    const Error wrong = error_of(clip.path(), clip / "out");
    CAPTURE(wrong.message);
    CHECK(wrong.code == ErrorCode::Corrupt);
    CHECK(mentions(wrong, "'" + file + "' has NaN or infinity in 1 of its 5184 samples"));
  }
}

TEST_CASE("a comparison that cannot be is refused with a sentence that names the thing") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  const std::string out = clip / "out";

  REQUIRE(error_of(clip / "nowhere", out).code == ErrorCode::NotFound);
  REQUIRE(error_of(clip.path(), clip / "nowhere").code == ErrorCode::NotFound);
  REQUIRE(mentions(error_of(clip.path(), clip / "nowhere"), "there is no folder '"));
  REQUIRE(mentions(error_of(clip.path(), clip / "gt"), "no HDR frames"));
  REQUIRE(mentions(error_of(clip.path(), out, {.skip = 4}), "4 skipped at either end leave none"));
  REQUIRE(error_of(clip.path(), out, {.skip = -1}).code == ErrorCode::Invalid);

  const std::atomic<bool> stop{true};
  REQUIRE(error_of(clip.path(), out, {.skip = 1, .stop = &stop}).code == ErrorCode::Interrupted);

  SECTION("a folder that may not be listed") {
    REQUIRE(posix_storage().make_directories(clip / "closed").ok());
    std::filesystem::permissions(clip / "closed", std::filesystem::perms::none);
    {
      const test::AsNobody nobody;
      const Error unread = error_of(clip.path(), clip / "closed");
      CHECK(unread.code == ErrorCode::Permission);
      CHECK(mentions(unread, "cannot read the folder '" + clip / "closed'"));
    }
    std::filesystem::permissions(clip / "closed", std::filesystem::perms::owner_all);
  }
  SECTION("a clip without ground truth") {
    std::filesystem::remove_all(clip / "gt");
    REQUIRE(error_of(clip.path(), out).code == ErrorCode::NotFound);
    REQUIRE(mentions(error_of(clip.path(), out), "no ground truth"));
  }
  SECTION("an estimate of another size") {
    const std::vector<float> grey(20 * 10, 0.5f);
    ExrPicture picture{10, 20, {{"R", grey}, {"G", grey}, {"B", grey}}, {}, ExrCompression::Zip};
    REQUIRE(write_whole(posix_storage(), clip / "out/000002.exr", encode_exr(picture).value()).ok());
    REQUIRE(error_of(clip.path(), out).code == ErrorCode::SizeChanged);
    REQUIRE(mentions(error_of(clip.path(), out), "20x10"));
  }
  SECTION("a mask whose damaged header states gigabytes") {
    // a grey PNG of 60000x60000 up to its samples, which are not there
    constexpr std::string_view kDamaged(
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xea\x60\0\0\xea\x60\b\0\0\0\0\xa5\xb9\x2a\x9e\0\0\0\0IDAT", 41);
    std::ofstream(clip / "gt/id/0002.png") << kDamaged;
    const Error wrong = error_of(clip.path(), out);
    CHECK(wrong.code == ErrorCode::SizeChanged);
    CHECK(mentions(wrong, "0002.png' is 60000x60000"));
  }
  SECTION("two estimates of one frame") {
    synthetic_clip::write_estimate(clip / "out/2.exr", 2, Geometry::Without);
    REQUIRE(mentions(error_of(clip.path(), out), "frame 2"));
  }
  SECTION("a cut estimate") {
    std::filesystem::resize_file(clip / "out/000005.exr", 3000);
    REQUIRE(error_of(clip.path(), out).code == ErrorCode::Truncated);
    REQUIRE(mentions(error_of(clip.path(), out), "000005.exr"));
  }
  SECTION("a clip description that is none") {
    std::ofstream(clip / "clip.json") << R"({"width": 48})";
    const Error wrong = error_of(clip.path(), out);
    REQUIRE(wrong.code == ErrorCode::Corrupt);
    REQUIRE(mentions(wrong, "key 'height' not found"));
    REQUIRE_FALSE(mentions(wrong, "json.exception"));
    for (const char* width : {"4294967344", "48.5", "1e99", "\"48\""}) {  // the first is 48 in 32 bits
      std::ofstream(clip / "clip.json") << R"({"width": )" << width << R"(, "height": 36, "frames": []})";
      const Error cut = error_of(clip.path(), out);
      CAPTURE(cut.message);
      REQUIRE(cut.code == ErrorCode::Corrupt);
      REQUIRE(mentions(cut, fmt::format("states {}x36 pixels", nlohmann::json::parse(width).dump())));
    }
    for (const char* sequence : {"-1", "2.5", "1e99"}) {
      std::ofstream(clip / "clip.json")
          << R"({"width": 48, "height": 36, "frames": [{"exposure_s": 0.01, "sequence": )" << sequence
          << "}]}";
      REQUIRE(error_of(clip.path(), out).code == ErrorCode::Corrupt);
      REQUIRE(mentions(error_of(clip.path(), out), "frame 0 of '" + clip / "clip.json' states sequence "));
    }
    std::ofstream(clip / "clip.json") << "frames";
    REQUIRE(error_of(clip.path(), out).code == ErrorCode::Corrupt);
  }
}

TEST_CASE("the scores as JSON hold every figure, null where nothing was measured") {
  TemporaryFolder clip;
  write_clip_and_estimates(clip.path(), Geometry::Without);
  const ClipScores scores = scores_of(clip);
  const auto json = nlohmann::json::parse(to_json(scores, "a clip", "a \"label\""));
  REQUIRE(json.at("clip") == "a clip");
  REQUIRE(json.at("label") == "a \"label\"");
  REQUIRE(json.at("psnr_mu").get<double>() == scores.mean.psnr_mu_db);
  REQUIRE(json.at("flicker").get<double>() == *scores.flicker_stops);
  REQUIRE(json.at("worst_frame").get<std::uint64_t>() == scores.worst.frame);
  REQUIRE(json.at("depth_abs_rel").is_null());
  REQUIRE(json.at("per_frame").size() == 6);
  REQUIRE(json.at("per_frame").at(0).at("flicker").is_null());
}

}  // namespace hdrcam

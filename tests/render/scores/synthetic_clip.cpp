#include "tests/render/scores/synthetic_clip.h"

#include <png.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "render/exr.h"
#include "tests/support/scratch_folder.h"

#include <catch2/catch.hpp>

namespace hdrcam::synthetic_clip {
namespace {

constexpr float kBackgroundDepth = 6, kSquareDepth = 2;
constexpr double kExposures[3] = {0.001, 0.004, 0.016};

struct Square {
  int x, y;
  bool covers(int px, int py) const { return px >= x && px < x + 12 && py >= y && py < y + 10; }
};
Square square(int frame) { return {26 - frame, 5 + 2 * frame}; }

// 0..1, a fixed scramble of three numbers
float noise(int a, int b, int c) {
  std::uint32_t h = static_cast<std::uint32_t>(a) * 73856093u ^ static_cast<std::uint32_t>(b) * 19349663u ^
                    static_cast<std::uint32_t>(c) * 83492791u;
  h ^= h >> 13, h *= 2654435761u, h ^= h >> 15;
  return static_cast<float>(h & 0xffffu) / 65535.0f;
}

float background(int channel, float x, float y) {
  const float texture = std::sin(0.55f * x + 0.9f * static_cast<float>(channel)) * std::cos(0.4f * y);
  const float lamp = std::exp(-((x - 9) * (x - 9) + (y - 24) * (y - 24)) / 12);
  return 0.35f * std::exp(2.2f * texture) + 40 * lamp;
}

void write_exr(const std::string& path, const Image<float>& image, const std::vector<std::string>& names) {
  ExrPicture picture{image.rows(), image.cols(), {}, {}, ExrCompression::Zip};
  for (int c = 0; c < image.channels(); ++c)
    picture.channels.push_back(
        {names[static_cast<std::size_t>(c)], {image.plane(c), image.plane_size()}, ExrSample::Float});
  const auto bytes = encode_exr(picture);
  REQUIRE(bytes.ok());
  REQUIRE(write_whole(posix_storage(), path, bytes.value()).ok());
}

void write_ids(const std::string& path, int frame) {
  Image<std::uint8_t> ids(1, kRows, kCols);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) ids.at(0, y, x) = square(frame).covers(x, y);
  png_image png{};
  png.version = PNG_IMAGE_VERSION, png.width = kCols, png.height = kRows, png.format = PNG_FORMAT_GRAY;
  REQUIRE(png_image_write_to_file(&png, path.c_str(), 0, ids.plane(0), kCols, nullptr) != 0);
}

void write_text(const std::string& path, const std::string& text) {
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(text))).ok());
}

}  // namespace

Image<float> radiance(int frame) {
  Image<float> image(3, kRows, kCols);
  const float t = static_cast<float>(frame);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const Square s = square(frame);
        image.at(c, y, x) =
            s.covers(x, y)
                ? 0.6f + 0.1f * static_cast<float>(c) + 0.4f * noise(c, x - s.x, y - s.y)
                : background(c, static_cast<float>(x) - 1.5f * t, static_cast<float>(y) - 0.5f * t);
      }
  return image;
}

Image<float> depth(int frame) {
  Image<float> image(1, kRows, kCols);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x)
      image.at(0, y, x) = square(frame).covers(x, y) ? kSquareDepth : kBackgroundDepth;
  return image;
}

Image<float> flow(int frame) {
  Image<float> image(3, kRows, kCols);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const bool on_square = square(frame).covers(x, y);
      image.at(0, y, x) = on_square ? -1.0f : 1.5f;
      image.at(1, y, x) = on_square ? 2.0f : 0.5f;
      image.at(2, y, x) = !on_square && square(frame + 1).covers(x + 1, y) ? 1.0f : 0.0f;
    }
  return image;
}

Image<float> estimate(int frame) {
  constexpr float kGain[3] = {0.5f, 0.8f, 1.25f}, kPumping[3] = {1.0f, 1.03f, 0.96f};
  Image<float> image = radiance(frame);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const bool ghost = frame > 0 && square(frame - 1).covers(x, y) && !square(frame).covers(x, y);
        const float fault =
            (0.9f + 0.2f * noise(7 * frame + c, x, y)) * kPumping[frame % 3] * (ghost ? 1.4f : 1.0f);
        image.at(c, y, x) *= kGain[c] * fault;
      }
  return image;
}

void write_clip(const std::string& folder) {
  for (const char* kind : {"hdr", "flow", "depth", "id"})
    REQUIRE(posix_storage().make_directories(folder + "/gt/" + kind).ok());
  nlohmann::json clip{{"name", "synthetic"}, {"width", kCols}, {"height", kRows}, {"fps", 30}, {"bits", 8}};
  for (int i = 0; i < kFrames; ++i) {
    clip["frames"].push_back({{"file", fmt::format("ldr/{:04d}.png", i)},
                              {"time_s", i / 30.0},
                              {"exposure_s", kExposures[i % 3]}});
    const auto path = [&](const char* kind, const char* extension) {
      return fmt::format("{}/gt/{}/{:04d}.{}", folder, kind, i, extension);
    };
    write_exr(path("hdr", "exr"), radiance(i), {"R", "G", "B"});
    write_exr(path("depth", "exr"), depth(i), {"Y"});
    write_exr(path("flow", "exr"), flow(i), {"R", "G", "B"});
    write_ids(path("id", "png"), i);
  }
  write_text(folder + "/clip.json", clip.dump());
  write_text(folder + "/gt/gt.json", R"({"r_sat_shortest": 6.0, "moving_ids": [1]})");
}

void write_estimate(const std::string& path, int frame, Geometry geometry) {
  Image<float> channels(10, kRows, kCols);
  const Image<float> rgb = estimate(frame), z = depth(frame), forward = flow(frame);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const bool on_square = square(frame).covers(x, y);
      for (int c = 0; c < 3; ++c) channels.at(c, y, x) = rgb.at(c, y, x);
      channels.at(3, y, x) = z.at(0, y, x) / kDepthScale * (on_square ? 1.03f : 1.0f);
      channels.at(4, y, x) = forward.at(0, y, x) + 0.3f;  // 0.5 px off everywhere
      channels.at(5, y, x) = forward.at(1, y, x) - 0.4f;
      channels.at(6, y, x) = -1.5f;  // the background's motion everywhere: wrong on the square
      channels.at(7, y, x) = -0.5f;
      channels.at(8, y, x) = -1.5f;  // the field's: the same
      channels.at(9, y, x) = -0.5f;
    }
  std::vector<std::string> names{"R",         "G",          "B",          "Z",       "forward.u",
                                 "forward.v", "backward.u", "backward.v", "field.u", "field.v"};
  if (geometry == Geometry::Without) names.resize(3);
  Image<float> chosen(static_cast<int>(names.size()), kRows, kCols);
  std::copy_n(channels.plane(0), chosen.size(), chosen.plane(0));
  write_exr(path, chosen, names);
}

TemporaryFolder::TemporaryFolder()
    : path_(test::scratch_folder([] {
        static int folders = 0;
        return "scores_" + std::to_string(folders++);
      }())) {}

}  // namespace hdrcam::synthetic_clip

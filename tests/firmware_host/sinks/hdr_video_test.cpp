// Videos of HDR frames, decoded again: what a player is told, and what it shows.
#include "firmware_host/sinks/hdr_video.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <span>

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

#include "firmware_host/sinks/video_target.h"
#include "hal/fault/faulty_storage.h"
#include "render/display_light.h"
#include "render/tone_curve.h"
#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/decoded_video.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::DecodedVideo;
namespace fs = std::filesystem;

namespace {

constexpr int kPatches = 8, kPatch_px = 32;
constexpr std::array<float, kPatches> kGreys{0.0005f, 0.005f, 0.05f, 0.2f, 0.5f, 1, 2, 3.9f};  // radiance
constexpr double kFramerate_hz = 25;

// A wedge of greys; the frames of the tests come at uneven times, one in five is missing.
HdrFrame wedge(int i) {
  HdrFrame frame;
  frame.facts.sequence = static_cast<std::uint64_t>(i + i / 4);
  frame.facts.timestamp = Instant::from_seconds(
      100 + static_cast<double>(frame.facts.sequence) / kFramerate_hz + 0.0031 * (i % 3));
  frame.white = 4;
  frame.radiance = Image<float>(3, 64, kPatches * kPatch_px);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < frame.radiance.rows(); ++y)
      for (int x = 0; x < frame.radiance.cols(); ++x)
        frame.radiance.at(c, y, x) = kGreys[static_cast<std::size_t>(x / kPatch_px)];
  return frame;
}

double time_of(int i) { return to_seconds(wedge(i).facts.timestamp - wedge(0).facts.timestamp); }

int at_patch(const Image<std::uint16_t>& luma, int patch) {
  return luma.at(0, luma.rows() / 2, patch * kPatch_px + kPatch_px / 2);
}

Result<void> make_video(const std::string& path, int frames, const VideoOptions& options,
                        Storage& storage = posix_storage()) {
  auto sink = TRY(create_hdr_video(storage, path, kFramerate_hz, options));
  for (int i = 0; i < frames; ++i) TRY(test::emit(*sink, wedge(i)));
  return sink->finish();
}

DecodedVideo made(const std::string& path, int frames, const VideoOptions& options = {}) {
  const Result<void> video = make_video(path, frames, options);
  INFO((video.ok() ? "" : video.error().message));
  REQUIRE(video.ok());
  return test::decoded_video(path);
}

// Of the elements of a Matroska file's segment: how many there are, and whose CRC-32 (RFC 8794, 11.3.1) is
// not that of their bytes.
struct SegmentChecksums {
  int elements = 0, checksums = 0, wrong = 0;
};

SegmentChecksums checksums_of(const std::string& path) {
  constexpr std::uint64_t kSegment = 0x18538067;
  const std::string text = read_whole(posix_storage(), path).value();
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(text.data());
  const auto number = [&](std::size_t& at, bool with_length) {
    const int length = std::countl_zero(bytes[at]) + 1;
    std::uint64_t value = with_length ? bytes[at] : bytes[at] & (0xffu >> length);
    for (int i = 1; i < length; ++i) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
    at += static_cast<std::size_t>(length);
    return value;
  };
  SegmentChecksums found;
  for (std::size_t at = 0; at < text.size();) {
    const std::uint64_t id = number(at, true), size = number(at, false);
    if (id == kSegment) continue;
    REQUIRE(size <= text.size() - at);
    ++found.elements;
    const std::uint8_t* const body = bytes + at;
    if (size >= 6 && body[0] == 0xbf && body[1] == 0x84) {
      ++found.checksums;
      const std::uint32_t stated = AV_RL32(body + 2);
      const std::uint32_t all = std::numeric_limits<std::uint32_t>::max();
      found.wrong += (av_crc(av_crc_get_table(AV_CRC_32_IEEE_LE), all, body + 6, size - 6) ^ all) != stated;
    }
    at += size;
  }
  return found;
}

int pq_code(double nits) { return static_cast<int>(std::lround(64 + 876 * pq_signal(nits))); }

}  // namespace

TEST_CASE("an HDR10 file says what it is, in the container and in the stream, and how bright it becomes") {
  const std::string folder = sample::scratch_folder("hdr10");
  for (const char* name : {"x.mp4", "x.mov", "x.mkv"}) {
    INFO(name);
    const DecodedVideo video = made(folder + "/" + name, 12);
    CHECK(video.codec == "hevc");
    CHECK(video.pixel_format == "yuv420p10le");
    CHECK(video.primaries == "bt2020");
    CHECK(video.transfer == "smpte2084");
    CHECK(video.matrix == "bt2020nc");
    CHECK(video.range == "tv");
    CHECK(video.siting == "topleft");
    REQUIRE(video.frames.size() == 12);
    const auto& in_stream = video.frames.front();
    REQUIRE(in_stream.mastering);
    CHECK(av_q2d(in_stream.mastering->max_luminance) == Approx(1000));
    CHECK(av_q2d(in_stream.mastering->display_primaries[0][0]) == Approx(0.64).margin(1e-4));
    const double mean_nits = [] {
      double sum = 0;
      for (const float grey : kGreys) sum += static_cast<double>(grey) * 203;
      return sum / kPatches;
    }();
    REQUIRE(video.mastering);
    REQUIRE(video.light);
    CHECK(av_q2d(video.mastering->max_luminance) == Approx(1000));
    CHECK(av_q2d(video.mastering->min_luminance) == Approx(0.005));
    CHECK(video.light->MaxCLL == 792);  // 3.9 x 203, rounded up
    CHECK(video.light->MaxFALL == static_cast<unsigned>(std::ceil(mean_nits)));
  }
}

TEST_CASE("no checksum of a Matroska video contradicts what it covers, measured light level included") {
  const std::string folder = sample::scratch_folder("video_checksums");
  for (const CodecChoice codec : {CodecChoice::Hevc, CodecChoice::Av1}) {
    REQUIRE(made(folder + "/x.mkv", 3, {.codec = codec}).light->MaxCLL == 792);
    const SegmentChecksums found = checksums_of(folder + "/x.mkv");
    CHECK(found.elements > 4);
    CHECK(found.wrong == 0);
  }
  made(folder + "/sdr.mkv", 3, {.transfer = VideoTransfer::Sdr});
  const SegmentChecksums found = checksums_of(folder + "/sdr.mkv");
  CHECK(found.checksums > 4);
  CHECK(found.wrong == 0);
}

TEST_CASE("a grey wedge decodes to its luminance within one code") {
  const std::string folder = sample::scratch_folder("wedge");
  const DecodedVideo video = made(folder + "/x.mp4", 5);
  REQUIRE(video.frames.size() == 5);
  for (const auto& frame : video.frames)
    for (int patch = 0; patch < kPatches; ++patch) {
      const double nits = 203 * static_cast<double>(kGreys[static_cast<std::size_t>(patch)]);
      INFO(nits);
      CHECK(std::abs(at_patch(frame.luma, patch) - pq_code(nits)) <= 1);
      CHECK(std::abs(frame.cb.at(0, 16, patch * kPatch_px / 2 + 8) - 512) <= 1);
      CHECK(std::abs(frame.cr.at(0, 16, patch * kPatch_px / 2 + 8) - 512) <= 1);
    }
}

TEST_CASE("white and peak are where the user puts them") {
  const std::string folder = sample::scratch_folder("white");
  const DecodedVideo video = made(folder + "/x.mp4", 2, {.white_nits = 100, .peak_nits = 300});
  const HighlightShoulder shoulder(400, 300);
  for (int patch = 0; patch < kPatches; ++patch) {
    const double nits = 100 * static_cast<double>(kGreys[static_cast<std::size_t>(patch)]);
    CHECK(std::abs(at_patch(video.frames[0].luma, patch) - pq_code(shoulder.shown(nits))) <= 1);
  }
  CHECK(av_q2d(video.mastering->max_luminance) == Approx(300));
}

TEST_CASE("frames keep the times of the sensor: to the microsecond in MP4, the millisecond in Matroska") {
  const std::string folder = sample::scratch_folder("times");
  for (const auto& [name, margin] : {std::pair{"x.mp4", 1e-6}, {"x.mov", 1e-6}, {"x.mkv", 1e-3}}) {
    const DecodedVideo video = made(folder + "/" + name, 40);
    REQUIRE(video.frames.size() == 40);
    for (int i = 0; i < 40; ++i)
      CHECK(video.frames[static_cast<std::size_t>(i)].time_s == Approx(time_of(i)).margin(margin));
  }
}

TEST_CASE("a file that was cut plays up to the cut") {
  const std::string folder = sample::scratch_folder("cut");
  for (const char* name : {"x.mp4", "x.mov", "x.mkv"}) {
    const std::string path = folder + "/" + name;
    constexpr int kFrames = 100;
    REQUIRE(make_video(path, kFrames, {}).ok());
    fs::resize_file(path, fs::file_size(path) * 9 / 10);
    const DecodedVideo video = test::decoded_video(path);
    INFO(name << " " << video.frames.size());
    CHECK(video.frames.size() >= kFrames * 3 / 4);  // a second of 25 frames is the most that a cut costs
    CHECK(video.primaries == "bt2020");
    for (std::size_t i = 0; i < video.frames.size(); ++i)
      CHECK(video.frames[i].time_s == Approx(time_of(static_cast<int>(i))).margin(1e-3));
  }
}

TEST_CASE("HLG puts white at three quarters of the signal") {
  const std::string folder = sample::scratch_folder("hlg");
  const DecodedVideo video = made(folder + "/x.mp4", 2, {.transfer = VideoTransfer::Hlg});
  CHECK(video.transfer == "arib-std-b67");
  CHECK(video.primaries == "bt2020");
  CHECK(video.siting == "topleft");
  CHECK_FALSE(video.light);
  CHECK(std::abs(at_patch(video.frames[0].luma, 5) - (64 + 876 * 3 / 4)) <= 1);
}

TEST_CASE("SDR is H.264 of eight bits, with the tone curve of the previews") {
  const std::string folder = sample::scratch_folder("sdr");
  const DecodedVideo video = made(folder + "/x.mp4", 3, {.transfer = VideoTransfer::Sdr});
  CHECK(video.codec == "h264");
  CHECK(video.pixel_format == "yuv420p");
  CHECK(video.primaries == "bt709");
  CHECK(video.transfer == "bt709");
  CHECK(video.matrix == "bt709");
  CHECK(video.siting == "left");
  ToneAdaptation tone;
  const HdrFrame frame = wedge(0);
  const ToneCurve& curve = tone.follow(frame.radiance);
  for (int patch = 0; patch < kPatches; ++patch) {
    const double level = static_cast<double>(curve.level(kGreys[static_cast<std::size_t>(patch)])) / 255;
    const double light = level <= 0.04045 ? level / 12.92 : std::pow((level + 0.055) / 1.055, 2.4);
    const double code = 16 + 219 * std::pow(light, 1 / 2.4);  // shown by a display of BT.1886
    CHECK(std::abs(at_patch(video.frames[0].luma, patch) - code) <= 1.5);
  }
}

TEST_CASE("AV1 says the same of itself as HEVC") {
  const std::string folder = sample::scratch_folder("av1");
  const DecodedVideo video = made(folder + "/x.mp4", 4, {.codec = CodecChoice::Av1, .crf = 8});
  CHECK(video.codec == "av1");
  CHECK(video.transfer == "smpte2084");
  CHECK(video.range == "tv");
  CHECK(video.siting == "topleft");
  REQUIRE(video.frames.size() == 4);
  REQUIRE(video.light);
  CHECK(video.light->MaxCLL == 792);
  for (int i = 0; i < 4; ++i)
    CHECK(video.frames[static_cast<std::size_t>(i)].time_s == Approx(time_of(i)).margin(1e-6));
  for (int patch = 0; patch < kPatches; ++patch)
    CHECK(std::abs(at_patch(video.frames[0].luma, patch) -
                   pq_code(203 * static_cast<double>(kGreys[static_cast<std::size_t>(patch)]))) <= 2);
}

TEST_CASE("a picture of odd sides gets one more column and row, which repeat the last") {
  const std::string folder = sample::scratch_folder("odd");
  auto sink = create_hdr_video(posix_storage(), folder + "/x.mp4", 25, {});
  REQUIRE(sink.ok());
  REQUIRE(test::emit(**sink, test::example_frame(0, test::With::RadianceOnly, 65, 97)).ok());
  REQUIRE(sink.value()->finish().ok());
  const DecodedVideo video = test::decoded_video(folder + "/x.mp4");
  CHECK(video.width == 98);
  CHECK(video.height == 66);
}

TEST_CASE("a pipe gets the codes themselves, ten bits, with or without times") {
  const std::string folder = sample::scratch_folder("pipe");
  for (const auto format : {PipeFormat::Nut, PipeFormat::Y4m}) {
    const std::string path = folder + (format == PipeFormat::Nut ? "/x.nut" : "/x.y4m");
    auto sink = create_video_pipe(posix_storage().create(path).value(), kFramerate_hz, {.pipe = format});
    REQUIRE(sink.ok());
    for (int i = 0; i < 6; ++i) REQUIRE(test::emit(**sink, wedge(i)).ok());
    REQUIRE(sink.value()->finish().ok());
    const DecodedVideo video = test::decoded_video(path);
    CHECK(video.pixel_format == "yuv420p10le");
    REQUIRE(video.frames.size() == 6);
    for (int i = 0; i < 6; ++i) {
      const auto& frame = video.frames[static_cast<std::size_t>(i)];
      CHECK(frame.time_s == Approx(format == PipeFormat::Nut ? time_of(i) : i / kFramerate_hz).margin(1e-6));
      for (int patch = 0; patch < kPatches; ++patch)
        CHECK(at_patch(frame.luma, patch) ==
              pq_code(203 * static_cast<double>(kGreys[static_cast<std::size_t>(patch)])));
    }
  }
}

TEST_CASE("chroma of HDR is at the top left of four pixels, of SDR in the middle of the left two") {
  const std::string folder = sample::scratch_folder("chroma_site");
  constexpr int kRow = 16, kCol = 32;  // of a red cross; a chroma sample has the top left of 2x2 pixels
  HdrFrame cross = wedge(0);
  cross.radiance.fill(0.05f);
  for (int x = 0; x < cross.radiance.cols(); ++x) cross.radiance.at(0, kRow, x) = 1;
  for (int y = 0; y < cross.radiance.rows(); ++y) cross.radiance.at(0, y, kCol) = 1;
  for (const VideoTransfer transfer : {VideoTransfer::Pq, VideoTransfer::Hlg, VideoTransfer::Sdr}) {
    const std::string path = folder + "/" + std::to_string(static_cast<int>(transfer)) + ".nut";
    CAPTURE(path);
    auto sink =
        create_video_pipe(posix_storage().create(path).value(), kFramerate_hz, {.transfer = transfer});
    REQUIRE(sink.ok());
    REQUIRE(test::emit(**sink, cross).ok());
    REQUIRE(sink.value()->finish().ok());
    const DecodedVideo video = test::decoded_video(path);
    REQUIRE(video.frames.size() == 1);
    const auto across_row = [&](int rows) { return int{video.frames[0].cr.at(0, kRow / 2 + rows, 4)}; };
    const auto across_col = [&](int cols) { return int{video.frames[0].cr.at(0, 4, kCol / 2 + cols)}; };
    CHECK(across_col(0) > across_col(1) + 4);
    CHECK(std::abs(across_col(-1) - across_col(1)) <= 1);
    CHECK(across_row(0) > across_row(-1) + 4);
    if (transfer == VideoTransfer::Sdr)  // the row is nearer to the sample above than to the one below
      CHECK(across_row(-1) > across_row(1) + 2);
    else
      CHECK(std::abs(across_row(-1) - across_row(1)) <= 1);
  }
}

TEST_CASE("a pipe of 29.97 frames per second states 30000 / 1001, as OpenEXR files do") {
  const std::string path = sample::scratch_folder("pipe_rate") + "/x.y4m";
  auto sink = create_video_pipe(posix_storage().create(path).value(), 29.97, {.pipe = PipeFormat::Y4m});
  REQUIRE(sink.ok());
  REQUIRE(test::emit(**sink, wedge(0)).ok());
  REQUIRE(sink.value()->finish().ok());
  const std::string file = read_whole(posix_storage(), path).value();
  CHECK_THAT(file.substr(0, file.find('\n')), Catch::Contains(" F30000:1001 "));
}

TEST_CASE("what cannot be is refused before a frame comes") {
  const std::string folder = sample::scratch_folder("refused");
  const auto code = [&](const char* name, const VideoOptions& options) {
    return sample::error_of(create_hdr_video(posix_storage(), folder + "/" + name, 25, options)).code;
  };
  CHECK(code("x.avi", {}) == ErrorCode::Invalid);
  CHECK(video_container_of("x.MP4") == VideoContainer::Mp4);
  CHECK(code("x.mp4", {.codec = CodecChoice::H264}) == ErrorCode::Invalid);
  CHECK(code("x.mov", {.codec = CodecChoice::Av1}) == ErrorCode::Invalid);
  CHECK(code("x.mp4", {.transfer = VideoTransfer::Hlg, .peak_nits = 2000}) == ErrorCode::Invalid);
  CHECK(code("x.mp4", {.white_nits = 500, .peak_nits = 300}) == ErrorCode::Invalid);
  const VideoOptions sdr{.transfer = VideoTransfer::Sdr, .white_nits = 500, .peak_nits = 300};  // unused
  CHECK(create_hdr_video(posix_storage(), folder + "/x.mp4", 25, sdr).ok());
}

TEST_CASE("a rate factor is refused where the codec of the video does not take it, and AV1 takes up to 63") {
  const std::string folder = sample::scratch_folder("rate_factor");
  const auto refusal = [&](const VideoOptions& options) {
    return sample::error_of(create_hdr_video(posix_storage(), folder + "/none.mp4", 25, options));
  };
  const Error hevc = refusal({.crf = 52});
  CHECK(hevc.code == ErrorCode::Invalid);
  CHECK(hevc.message ==
        "--crf 52 is beyond what hevc takes, 0 to 51; give less, or --codec av1, which takes up to 63");
  CHECK_THAT(refusal({.transfer = VideoTransfer::Sdr, .crf = 63}).message,
             Catch::Contains("what h264 takes"));
  CHECK(made(folder + "/hevc.mp4", 1, {.crf = 51}).frames.size() == 1);
  CHECK(made(folder + "/av1.mp4", 1, {.codec = CodecChoice::Av1, .crf = 63}).frames.size() == 1);
  auto pipe = create_video_pipe(posix_storage().create(folder + "/x.y4m").value(), 25, {.crf = 63});
  CHECK(pipe.ok());  // which is not compressed
}

TEST_CASE("what the codec or the disk refuses leaves an earlier video as it is, and makes none") {
  const std::string folder = sample::scratch_folder("video_refused"), path = folder + "/x.mp4",
                    earlier = "an earlier video";
  const auto opened = [](Storage& storage, const std::string& file, int width_px) {
    return VideoTarget::at(storage, file)
        .value()
        .open({.width_px = width_px, .height_px = 64, .bits = 8, .codec = VideoCodec::H264});
  };
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(earlier))).ok());
  FaultyStorage full(posix_storage(), {.space_bytes = 0});
  CHECK_FALSE(opened(posix_storage(), path, 1 << 20).ok());
  const auto no_space = opened(full, path, 64);
  REQUIRE_FALSE(no_space.ok());
  CHECK(no_space.error().code == ErrorCode::NoSpace);
  CHECK(no_space.error().message.find(path) != std::string::npos);
  CHECK(read_whole(posix_storage(), path).value() == earlier);
  CHECK_FALSE(opened(posix_storage(), folder + "/none.mp4", 1 << 20).ok());
  CHECK(std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()) ==
        1);
}

TEST_CASE("a video that another program makes is not replaced, neither a new one nor one that is not whole") {
  const std::string folder = sample::scratch_folder("video_of_another"), path = folder + "/x.mp4";
  const HdrFrame frame = wedge(0);
  const ExposedFrame input;
  const FrameRecord record;
  const EmittedFrame first{frame, input, record};
  const auto ours = create_hdr_video(posix_storage(), path, kFramerate_hz, {}).value();
  const auto another = create_hdr_video(posix_storage(), path, kFramerate_hz, {}).value();
  REQUIRE(another->emit(first).ok());
  CHECK(sample::error_of(ours->emit(first)).code == ErrorCode::Exists);
  CHECK(sample::unfinished_files_in(folder) == 0);  // ours has no frame
  const auto later = create_hdr_video(posix_storage(), path, kFramerate_hz, {}).value();
  CHECK(sample::error_of(later->emit(first)).code == ErrorCode::Busy);
  REQUIRE(another->finish().ok());
  CHECK(test::decoded_video(path).frames.size() == 1);
}

TEST_CASE("a video that is finished is on the disk, and so is its name") {
  const std::string folder =
      posix_storage().look_at(sample::scratch_folder("durable_video")).value().real_path;
  FaultyStorage disk(posix_storage(), {.failing_sync = 1});  // the one behind that of the bytes
  CHECK(sample::error_of(make_video(folder + "/x.mp4", 3, {}, disk)).message ==
        "cannot sync '" + folder + "': the disk refused");
}

TEST_CASE("a full disk is an error, and what was written before it plays") {
  const std::string folder = sample::scratch_folder("full_video");
  const std::string path = folder + "/x.mp4";
  REQUIRE(make_video(path, 100, {}).ok());
  const auto size = fs::file_size(path);
  FaultyStorage disk(posix_storage(), test::disk_of(size * 3 / 4));
  CHECK(sample::error_of(make_video(path, 100, {}, disk)).code == ErrorCode::NoSpace);
  CHECK(test::decoded_video(path).frames.size() >= 25);
}

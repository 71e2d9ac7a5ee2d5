#include "hal/recording/image_sequence.h"

#include <sys/stat.h>

#include <filesystem>
#include <set>

#include "hal/fault/faulty_storage.h"
#include "hal/recording/png_image.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/support/files.h"

using namespace hdrcam;
using test::write_file;

namespace {

constexpr const char* kHead =
    R"("name":"t","width":6,"height":4,"fps":30,"bits":8,"fx":5.5,"fy":5.5,"cx":3,"cy":2)";

void write_picture(const std::string& path, int channels, int rows, int cols, int bits_per_sample,
                   unsigned seed = 1) {
  std::mt19937 random(seed);
  PngImage image{bits_per_sample, Image<std::uint16_t>(channels, rows, cols)};
  for (auto& sample : image.samples.samples())
    sample = static_cast<std::uint16_t>(random() & ((1u << bits_per_sample) - 1));
  REQUIRE(write_png(posix_storage(), path, image).ok());
}

// A folder with four good 6x4 images; a test then writes the clip.json it wants to see refused.
struct ClipFolder {
  std::string path = sample::scratch_folder("clip");

  ClipFolder() {
    for (int i = 0; i < 4; ++i)
      write_picture(path + fmt::format("/{}.png", i), 3, 4, 6, 8, static_cast<unsigned>(i));
  }
  void write(const std::string& head, const std::vector<std::string>& frames) const {
    std::string text = "{" + head + ",\n\"frames\":[";
    for (std::size_t i = 0; i < frames.size(); ++i) text += (i ? ",\n{" : "\n{") + frames[i] + "}";
    write_file(path + "/clip.json", text + "]}");
  }
  // The error of opening the clip and reading every frame.
  Error error() const {
    const auto clip = ImageSequence::open(posix_storage(), path);
    if (!clip) return clip.error();
    for (int i = 0; i < clip.value().frame_count(); ++i)
      if (const auto frame = clip.value().read(i); !frame) return frame.error();
    FAIL("the clip was accepted");
    return {};
  }
  Error error_of_frame_1(const std::string& frame) const {
    write(kHead, {R"("file":"0.png","time_s":0,"exposure_s":0.001)", frame});
    return error();
  }
};

bool says(const Error& error, std::initializer_list<const char*> words) {
  INFO(error.message);
  for (const char* word : words) CHECK(error.message.find(word) != std::string::npos);
  return std::all_of(words.begin(), words.end(),
                     [&](const char* word) { return error.message.find(word) != std::string::npos; });
}

}  // namespace

TEST_CASE("a clip gives its facts: gain, centre of exposure, pose, slots of the schedule") {
  const ClipFolder folder;
  folder.write(
      kHead,
      {R"("file":"0.png","time_s":0,"exposure_s":0.001)",
       R"("file":"1.png","time_s":0.0333333333,"exposure_s":0.008,"gain":2,"c2w":[1,0,0,0.5,0,1,0,0,0,0,1,-2])",
       R"("file":"2.png","time_s":0.0666666667,"exposure_s":0.001)",
       R"("file":"3.png","time_s":0.1,"exposure_s":0.016,"later":"ignored")"});
  for (const std::string& path : {folder.path, folder.path + "/clip.json", folder.path + "/"}) {
    const auto clip = ImageSequence::open(posix_storage(), path);
    INFO(sample::error_of(clip).message);
    REQUIRE(clip.ok());
    CHECK(clip.value().camera().layout == PixelLayout::Rgb);
    CHECK(clip.value().camera().intrinsics->fx_px == 5.5);
    const auto frame = clip.value().read(1);
    REQUIRE(frame.ok());
    CHECK(frame.value().facts.exposure() == 0.016);
    CHECK(frame.value().facts.analogue_gain == 2);
    CHECK(frame.value().facts.timestamp.since_boot.count() == 33333333);
    CHECK(frame.value().facts.sequence == 1);
    CHECK((*frame.value().facts.T_world_camera)[3] == 0.5);
    CHECK((*frame.value().facts.T_world_camera)[11] == -2);
    for (int i = 0; i < 4; ++i) CHECK(clip.value().facts(i).slot == i % 2);
  }
}

TEST_CASE("an exposure that is missing or cannot be is refused by its frame, file and value") {
  const ClipFolder folder;
  const auto refused = [&](const char* exposure, const char* shown) {
    const Error error = folder.error_of_frame_1(std::string(R"("file":"1.png","time_s":0.1)") + exposure);
    CHECK(error.code == ErrorCode::BadExposure);
    CHECK(says(error, {"clip.json", "frame 1", "'1.png'", shown}));
  };
  refused("", "'exposure_s' is missing");
  refused(R"(,"exposure_s":0)", "'exposure_s' is 0");
  refused(R"(,"exposure_s":-0.004)", "'exposure_s' is -0.004");
  refused(R"(,"exposure_s":NaN)", "'exposure_s' is NaN");
  refused(R"(,"exposure_s":Infinity)", "'exposure_s' is Infinity");
  refused(R"(,"exposure_s":-Infinity)", "'exposure_s' is -Infinity");
  refused(R"(,"exposure_s":null)", "'exposure_s' is null");
  refused(R"(,"exposure_s":"long")", "'exposure_s' is \"long\"");
  refused(R"(,"exposure_s":0.01,"gain":0)", "'gain' is 0");
  refused(R"(,"exposure_s":0.01,"gain":-1.5)", "'gain' is -1.5");
}

TEST_CASE("an exposure that a frame says is unknown need not be one") {
  const ClipFolder folder;
  folder.write(kHead, {R"("file":"0.png","time_s":0,"exposure_s":0,"exposure_source":"unknown")",
                       R"("file":"1.png","time_s":0.1,"exposure_s":0.001)"});
  const auto clip = ImageSequence::open(posix_storage(), folder.path);
  INFO(sample::error_of(clip).message);
  REQUIRE(clip.ok());
  CHECK(clip.value().facts(0).exposure_s == 0);
  CHECK(clip.value().facts(0).exposure_source == ExposureSource::Unknown);
  const auto refused = [&](const char* exposure) {
    CHECK(folder.error_of_frame_1(R"("file":"1.png","time_s":0.1,"exposure_s":)" + std::string(exposure))
              .code == ErrorCode::BadExposure);
  };
  refused(R"(0,"exposure_source":"reported")");
  refused(R"(-1,"exposure_source":"unknown")");
}

TEST_CASE("facts that cannot be a camera's are refused by their frame, file and value") {
  const ClipFolder folder;
  const auto refused = [&](const std::string& facts, std::initializer_list<const char*> words) {
    const Error error = folder.error_of_frame_1(R"("file":"1.png","exposure_s":0.001)" + facts);
    CHECK(error.code == ErrorCode::Invalid);
    CHECK(says(error, words));
  };
  refused(R"(,"time_s":-0.1)", {"frame 1", "'1.png'", "time", "-0.1"});
  refused(R"(,"time_s":0)", {"frame 1", "time"});
  refused(R"(,"time_s":0.1,"sequence":0)", {"frame 1", "number 0"});
  refused(R"(,"time_s":0.1,"black_level":255)", {"frame 1", "black level"});
  refused(R"(,"time_s":0.1,"black_level":-3)", {"frame 1", "black level"});
  refused(R"(,"time_s":0.1,"timestamp_ns":9223372036854775807)", {"frame 1", "time"});
  refused(R"(,"time_s":0.1,"c2w":[1,0,0,1e300,0,1,0,0,0,0,1,0])", {"frame 1", "1e+300"});
  refused(R"(,"time_s":0.1,"c2w":[0,0,0,0,0,0,0,0,0,0,0,0])", {"frame 1", "rotation"});
  for (const char* lens : {R"("fx":1e40,"fy":5.5,"cx":3,"cy":2)", R"("fx":0,"fy":5.5,"cx":3,"cy":2)",
                           R"("fx":-5,"fy":5.5,"cx":3,"cy":2)", R"("fx":5,"fy":5,"cx":1e9,"cy":2)"}) {
    folder.write(
        R"("width":6,"height":4,"fps":30,"bits":8,)" + std::string(lens),
        {R"("file":"0.png","time_s":0,"exposure_s":1)", R"("file":"1.png","time_s":1,"exposure_s":1)"});
    CHECK(folder.error().code == ErrorCode::Invalid);
  }
}

TEST_CASE("a clip.json names images of its own folder: no device, and no invalid name") {
  const ClipFolder folder;
  const std::string good = R"(,"time_s":0.1,"exposure_s":0.001)";
  const std::string outside = sample::scratch_folder("outside") + "/secret.png";
  write_picture(outside, 3, 4, 6, 8);
  SECTION("a NUL") {
    CHECK(says(folder.error_of_frame_1(R"("file":"1.png\u0000.txt")" + good), {"frame 1", "NUL"}));
  }
  SECTION("a FIFO, which nobody would ever write to") {
    REQUIRE(mkfifo((folder.path + "/fifo.png").c_str(), 0600) == 0);
    CHECK(says(folder.error_of_frame_1(R"("file":"fifo.png")" + good), {"frame 1", "fifo.png", "FIFO"}));
  }
  SECTION("a way out, by its name or by a symbolic link") {
    std::filesystem::create_symlink(outside, folder.path + "/link.png");
    for (const std::string& file : {std::string("../outside/secret.png"), outside, std::string("link.png")}) {
      const Error error = folder.error_of_frame_1(R"("file":")" + file + '"' + good);
      CHECK(error.code == ErrorCode::Permission);
      CHECK(says(error, {"frame 1", "outside", "--allow-outside"}));
      const auto allowed = ImageSequence::open(posix_storage(), folder.path, ClipReach::Anywhere);
      REQUIRE(allowed.ok());
      CHECK(allowed.value().read(1).ok());
    }
  }
}

TEST_CASE("what is no PNG is called by its name") {
  const ClipFolder folder;
  for (const auto& [bytes, what] : {std::pair{"\xff\xd8\xff\xe0 and so on", "JPEG"}, {"II*", "TIFF"}}) {
    write_file(folder.path + "/x.png", std::string(bytes) + std::string(8, '\0'));
    const Error error = folder.error_of_frame_1(R"("file":"x.png","time_s":0.1,"exposure_s":0.001)");
    CHECK(error.code == ErrorCode::Unsupported);
    CHECK(says(error, {"frame 1", "x.png", what, "PNG"}));
  }
}

TEST_CASE("a clip of fewer than two frames is too short") {
  const ClipFolder folder;
  folder.write(kHead, {});
  CHECK(folder.error().code == ErrorCode::TooShort);
  folder.write(kHead, {R"("file":"0.png","time_s":0,"exposure_s":0.001)"});
  const Error error = folder.error();
  CHECK(error.code == ErrorCode::TooShort);
  CHECK(says(error, {"clip.json", "1 frame; at least two"}));
}

TEST_CASE("images that do not fit the clip are refused by their frame, file and value") {
  const ClipFolder folder;
  const std::string good = R"(,"time_s":0.1,"exposure_s":0.001)";
  SECTION("missing") {
    const Error error = folder.error_of_frame_1(R"("file":"ldr/none.png")" + good);
    CHECK(error.code == ErrorCode::NotFound);
    CHECK(says(error, {"frame 1", "ldr/none.png"}));
  }
  SECTION("another size") {
    write_picture(folder.path + "/big.png", 3, 4, 7, 8);
    const Error error = folder.error_of_frame_1(R"("file":"big.png")" + good);
    CHECK(error.code == ErrorCode::SizeChanged);
    CHECK(says(error, {"frame 1", "big.png", "7x4", "6x4"}));
  }
  SECTION("grey among RGB") {
    write_picture(folder.path + "/grey.png", 1, 4, 6, 8);
    CHECK(folder.error_of_frame_1(R"("file":"grey.png")" + good).code == ErrorCode::SizeChanged);
  }
  SECTION("not a PNG") {
    write_file(folder.path + "/text.png", "hello");
    const Error error = folder.error_of_frame_1(R"("file":"text.png")" + good);
    CHECK(error.code == ErrorCode::Corrupt);
    CHECK(says(error, {"frame 1", "text.png"}));
  }
  SECTION("a folder") {
    CHECK(folder.error_of_frame_1(R"("file":".")" + good).code == ErrorCode::Permission);
  }
  SECTION("of more bits than the clip says") {
    write_picture(folder.path + "/deep.png", 3, 4, 6, 16);
    const Error error = folder.error_of_frame_1(R"("file":"deep.png")" + good);
    CHECK(error.code == ErrorCode::Invalid);
    CHECK(says(error, {"frame 1", "deep.png", "no 8-bit codes"}));
  }
}

TEST_CASE("a clip.json that cannot be read is refused with what is wrong and where") {
  const ClipFolder folder;
  const std::string frames =
      R"(,"frames":[{"file":"0.png","time_s":0,"exposure_s":1},{"file":"1.png","time_s":1,"exposure_s":1}]})";
  const auto refused = [&](const std::string& text, std::initializer_list<const char*> words) {
    write_file(folder.path + "/clip.json", text);
    const Error error = folder.error();
    CHECK(error.code == ErrorCode::Invalid);
    CHECK(says(error, words));
  };
  refused("", {"clip.json", "line 1"});
  refused("{\n\"width\":6,\n\"height\" 4}", {"clip.json", "line 3", "byte 23"});
  refused("[]", {"clip.json", "object"});
  const std::string deep(200'000, '['), shallow(200'000, ']');
  refused(deep, {"clip.json", "64"});
  refused("{\"width\":" + deep + shallow + "}", {"clip.json", "64"});
  refused("{" + std::string(kHead) + ",\"frames\":[{\"file\":" + deep + shallow + "},{}]}",
          {"clip.json", "64"});
  refused(R"({"width":6,"height":4,"width":8,"fps":30,"bits":8)" + frames, {"clip.json", "'width' twice"});
  refused("{" + std::string(kHead) + R"(,"frames":[{"file":"0.png","later":{"a":[{},{"b":1,"b":1}]}},{}]})",
          {"clip.json", "'b' twice"});
  refused("{\"frames\":[1e999]}", {"clip.json' is not usable", "1e999"});
  refused(R"({"width":6,"height":4,"fps":30,"bits":8})", {"'frames' is missing"});
  refused(R"({"height":4,"fps":30,"bits":8)" + frames, {"'width' is missing; a whole number is needed"});
  refused(R"({"width":0,"height":4,"fps":30,"bits":8)" + frames, {"'width' is 0"});
  refused(R"({"width":6.5,"height":4,"fps":30,"bits":8)" + frames,
          {"'width' is 6.5; a whole number is needed"});
  refused(R"({"width":6,"height":99999999999,"fps":30,"bits":8)" + frames,
          {"'height' is 99999999999; it is out of range"});
  refused(R"({"width":6,"height":4,"fps":0,"bits":8)" + frames, {"'fps' is 0"});
  refused(R"({"width":6,"height":4,"fps":30,"bits":17)" + frames, {"'bits' is 17"});
  refused(R"({"width":6,"height":4,"fps":30,"bits":8,"layout":"xyz")" + frames, {"'layout' is \"xyz\""});
  refused(R"({"width":6,"height":4,"fps":30,"bits":8,"fx":3)" + frames, {"'fy' is missing"});
  refused(R"({"width":6,"height":4,"fps":30,"bits":8,"f_x":3,"fy":3,"cx":3,"cy":2)" + frames,
          {"'fx' is missing"});
  refused(R"({"width":6,"height":4,"fps":30,"bits":8,"response":[[1],[2],[3]])" + frames,
          {"response", "256"});
  refused("{" + std::string(kHead) + R"(,"frames":[{"time_s":0},{}]})", {"frame 0", "'file' is missing"});
  refused("{" + std::string(kHead) + R"(,"frames":[3,4]})", {"frame 0", "'file' is missing"});
  refused("{" + std::string(kHead) + R"(,"frames":[{"file":"0.png","exposure_s":1},{}]})",
          {"frame 0", "'time_s' is missing"});
  refused("{" + std::string(kHead) + R"(,"frames":[{"file":"0.png","exposure_s":1,"time_s":1e300},{}]})",
          {"'time_s' is 1e+300"});
  refused(
      "{" + std::string(kHead) + R"(,"frames":[{"file":"0.png","exposure_s":1,"time_s":0,"c2w":[1,2]},{}]})",
      {"c2w", "12"});
  CHECK(sample::error_of(ImageSequence::open(posix_storage(), folder.path + "/none")).code ==
        ErrorCode::NotFound);
}

TEST_CASE("a value that is too long for a message is cut between two characters") {
  const ClipFolder folder;
  const auto umlauts = [](int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += "\xc3\xa4";
    return text;
  };
  write_file(folder.path + "/clip.json",
             "{" + std::string(kHead) + R"(,"layout":")" + umlauts(30) + R"(","frames":[{},{}]})");
  const std::string shown = "'layout' is \"" + umlauts(19) + "..;";
  CHECK(says(folder.error(), {shown.c_str()}));
}

TEST_CASE("a response that cannot be one is refused by its file, channel and code") {
  const ClipFolder folder;
  // Whose green has this at code 9.
  const auto refused = [&](const std::string& value, std::initializer_list<const char*> words) {
    const auto curve = [](const std::string& ninth) {
      std::string text = "[";
      for (int code = 0; code < 256; ++code)
        text += (code == 0 ? "" : ",") + (code == 9 ? ninth : fmt::format("{}", code / 255.0));
      return text + "]";
    };
    const std::string plain = curve("0.0353");
    folder.write(
        fmt::format("{},\"response\":[{},{},{}]", kHead, plain, curve(value), plain),
        {R"("file":"0.png","time_s":0,"exposure_s":1)", R"("file":"1.png","time_s":1,"exposure_s":1)"});
    const Error error = folder.error();
    CHECK(error.code == ErrorCode::Invalid);
    CHECK(says(error, words));
  };
  refused("0.001", {"clip.json", "green", "falls at code 9"});
  refused("-1", {"clip.json", "green", "-1 at code 9"});
  refused("NaN", {"clip.json", "green", "NaN at code 9"});
  refused("Infinity", {"clip.json", "green", "Infinity at code 9"});
  refused("null", {"clip.json", "green", "null at code 9"});
  refused("\"x\"", {"clip.json", "green", "\"x\" at code 9"});
}

TEST_CASE("codes of 9 to 16 bits are read from the upper bits or from the full scale of a 16-bit image") {
  for (const int bits : {8, 9, 10, 12, 14, 16}) {
    INFO(bits << " bits");
    const std::string folder = sample::scratch_folder("deep");
    const int largest = (1 << bits) - 1;
    PngImage shifted{16, Image<std::uint16_t>(1, 2, 64)}, scaled{16, Image<std::uint16_t>(1, 2, 64)};
    Image<std::uint16_t> codes(1, 2, 64);
    for (std::size_t i = 0; i < 128; ++i) {
      const int code = static_cast<int>(i) * largest / 127;
      codes.samples()[i] = static_cast<std::uint16_t>(code);
      shifted.samples.samples()[i] = static_cast<std::uint16_t>(code << (16 - bits));
      scaled.samples.samples()[i] = static_cast<std::uint16_t>(std::lround(code * 65535.0 / largest));
    }
    REQUIRE(write_png(posix_storage(), folder + "/a.png", shifted).ok());
    REQUIRE(write_png(posix_storage(), folder + "/b.png", scaled).ok());
    write_file(folder + "/clip.json", fmt::format(R"({{"width":64,"height":2,"fps":30,"bits":{},"frames":[
      {{"file":"a.png","time_s":0,"exposure_s":1}},{{"file":"b.png","time_s":1,"exposure_s":1}}]}})",
                                                  bits));
    const auto clip = ImageSequence::open(posix_storage(), folder);
    REQUIRE(clip.ok());
    CHECK(clip.value().camera().layout == PixelLayout::Mono);
    for (int i = 0; i < 2; ++i) {
      const auto frame = clip.value().read(i);
      REQUIRE(frame.ok());
      CHECK(sample::same(frame.value().codes, codes));
    }
  }
}

TEST_CASE("codes in the lower bits of a 16-bit image are refused with the way up, others as neither") {
  const ClipFolder folder;
  const auto said = [&](int bits, std::uint16_t largest) {
    PngImage image{16, Image<std::uint16_t>(1, 4, 6)};
    for (std::size_t i = 0; i < 24; ++i) image.samples.samples()[i] = static_cast<std::uint16_t>(largest - i);
    REQUIRE(write_png(posix_storage(), folder.path + "/deep.png", image).ok());
    folder.write(
        fmt::format(R"("width":6,"height":4,"fps":30,"bits":{})", bits),
        {R"("file":"deep.png","time_s":0,"exposure_s":1)", R"("file":"deep.png","time_s":1,"exposure_s":1)"});
    const Error error = folder.error();
    CHECK(error.code == ErrorCode::Invalid);
    return error.message;
  };
  for (const auto& [bits, way_up] : {std::pair(9, 7), {10, 6}, {12, 4}, {15, 1}}) {
    INFO(bits << " bits");
    CHECK(said(bits, static_cast<std::uint16_t>((1 << bits) - 1)) ==
          fmt::format("frame 0: '{}/deep.png' has its {}-bit codes in the lower bits of 16; shift them up by "
                      "{} (docs/recording.md, Bits)",
                      folder.path, bits, way_up));
  }
  for (const auto& [bits, largest] : {std::pair(10, 1024), {10, 4095}, {12, 65535}}) {
    INFO(bits << " bits, samples up to " << largest);
    CHECK(said(bits, static_cast<std::uint16_t>(largest)) ==
          fmt::format("frame 0: '{}/deep.png' has samples that are no {}-bit codes, neither in the upper "
                      "bits of 16 nor scaled to 16; set 'bits' to the bits that they use, 16 for all "
                      "(docs/recording.md, Bits)",
                      folder.path, bits));
  }
}

TEST_CASE("an 8-bit image in a clip of more bits is refused") {
  const ClipFolder folder;
  folder.write(R"("width":6,"height":4,"fps":30,"bits":12)", {R"("file":"0.png","time_s":0,"exposure_s":1)",
                                                              R"("file":"1.png","time_s":1,"exposure_s":1)"});
  const Error error = folder.error();
  CHECK(error.code == ErrorCode::Invalid);
  CHECK(says(error, {"frame 0", "0.png", "8 bits", "12"}));
}

TEST_CASE("a damaged PNG is an error or the same picture, never a crash, wherever the damage is") {
  const std::string path = sample::scratch_folder("png") + "/x.png";
  write_picture(path, 3, 9, 13, 16);
  const std::uint64_t bytes = posix_storage().open(path).value()->size().value();
  for (std::uint64_t cut = 0; cut < bytes; ++cut) {
    FaultyStorage disk(posix_storage(), {.cut_at_bytes = cut});
    const auto image = read_png(disk, path, 13, 9);
    INFO("cut at byte " << cut);
    REQUIRE(!image.ok());
    REQUIRE(sample::error_of(image).code == ErrorCode::Corrupt);
  }
  const auto whole = read_png(posix_storage(), path, 13, 9);
  REQUIRE(whole.ok());
  int refused = 0;
  std::mt19937 random(8);
  for (int trial = 0; trial < 5000; ++trial) {
    std::set<std::uint64_t> bits;
    for (unsigned i = 0, n = 1 + random() % 4; i < n; ++i) bits.insert(random() % (bytes * 8));
    FaultyStorage disk(posix_storage(), {.flipped_bits = {bits.begin(), bits.end()}});
    CAPTURE(bits);
    const auto image = read_png(disk, path, 13, 9);
    // libpng 1.6.48 reads on where only the last chunk is damaged
    if (image.ok()) REQUIRE(sample::same(image.value().samples, whole.value().samples));
    refused += image.ok() ? 0 : 1;
  }
  CHECK(refused > 4900);
}

TEST_CASE("an earlier clip stays until the first image of the clip that replaces it") {
  const std::string folder = sample::scratch_folder("replaced_clip");
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto frames = sample::frames(camera, 4, 3);
  auto earlier = ImageSequenceWriter::create(posix_storage(), folder, camera);
  REQUIRE(earlier.ok());
  for (const RawFrame& frame : frames) REQUIRE(earlier.value().append(frame).ok());
  REQUIRE(earlier.value().finish().ok());
  const auto frame_count = [&] {
    const auto clip = ImageSequence::open(posix_storage(), folder);
    INFO(sample::error_of(clip).message);
    REQUIRE(clip.ok());
    return clip.value().frame_count();
  };

  auto writer = ImageSequenceWriter::create(posix_storage(), folder, camera, Creation::Replace);
  REQUIRE(writer.ok());
  CHECK(frame_count() == 4);
  REQUIRE(writer.value().finish().ok());  // without an image
  CHECK(frame_count() == 4);
  const RawFrame larger{frames[0].facts, Image<std::uint16_t>(3, 23, 38)};
  CHECK(sample::error_of(writer.value().append(larger)).code == ErrorCode::SizeChanged);
  CHECK(frame_count() == 4);
  REQUIRE(writer.value().append(frames[2]).ok());
  CHECK(sample::error_of(ImageSequence::open(posix_storage(), folder)).code == ErrorCode::NotFound);
  REQUIRE(writer.value().append(frames[3]).ok());
  REQUIRE(writer.value().finish().ok());
  CHECK(frame_count() == 2);
}

TEST_CASE("a clip.json claims its images once they are on the disk, and no sooner") {
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto frames = sample::frames(camera, 4, 3);
  const std::string folder = sample::scratch_folder("durable_clip");
  const auto written = [&](FaultyStorage& disk, const std::string& name) {
    auto writer = ImageSequenceWriter::create(disk, folder + name, camera);
    REQUIRE(writer.ok());
    for (const RawFrame& frame : frames) REQUIRE(writer.value().append(frame).ok());
    CHECK(disk.syncs() == 0);
    return writer.value().finish();
  };
  constexpr std::uint64_t kOfImages = 4 + 1;  // each, then the folder that has their names
  FaultyStorage disk(posix_storage(), {});
  REQUIRE(written(disk, "/whole").ok());
  CHECK(disk.syncs() == kOfImages + 2);  // the clip.json, then its name
  for (std::uint64_t refused = 0; refused < kOfImages; ++refused) {
    INFO("sync " << refused);
    FaultyStorage failing(posix_storage(), {.failing_sync = refused});
    const std::string name = fmt::format("/refused{}", refused);
    CHECK(sample::error_of(written(failing, name)).code == ErrorCode::Io);
    CHECK(sample::error_of(ImageSequence::open(posix_storage(), folder + name)).code == ErrorCode::NotFound);
  }
}

TEST_CASE("writing a clip and reading it gives back every bit, in every layout and depth") {
  for (const auto layout : {PixelLayout::Rgb, PixelLayout::Mono, PixelLayout::BayerGbrg})
    for (const int bits : {8, 10, 11, 16}) {
      INFO(name(layout) << ' ' << bits);
      const std::string folder = sample::scratch_folder("written") + "/deep/clip";
      CameraFacts camera = sample::camera(layout, bits, 37, 23);
      camera.linear = bits == 16;
      camera.response.assign(3, std::vector<double>(256, 1.0 / 3.0));
      camera.white_balance = ChannelGains{2.1, 1, 1.0 / 0.7};
      camera.turned_upright = bits == 11;
      const auto frames = sample::frames(camera, 7, 3);
      auto writer = ImageSequenceWriter::create(posix_storage(), folder, camera);
      REQUIRE(writer.ok());
      for (const RawFrame& frame : frames) REQUIRE(writer.value().append(frame).ok());
      CHECK(ImageSequence::open(posix_storage(), folder).error().code ==
            ErrorCode::NotFound);  // not before it is whole
      REQUIRE(writer.value().finish().ok());
      const auto clip = ImageSequence::open(posix_storage(), folder);
      REQUIRE(clip.ok());
      CHECK(clip.value().camera().name == camera.name);
      CHECK(clip.value().camera().layout == layout);
      CHECK(clip.value().camera().linear == camera.linear);
      CHECK(clip.value().camera().response == camera.response);
      CHECK(clip.value().camera().white_balance == camera.white_balance);
      CHECK(clip.value().camera().turned_upright == camera.turned_upright);
      CHECK(sample::same_bits(clip.value().camera().framerate_hz, camera.framerate_hz));
      REQUIRE(clip.value().frame_count() == 7);
      for (int i = 0; i < 7; ++i) {
        const auto frame = clip.value().read(i);
        REQUIRE(frame.ok());
        CHECK(sample::same(frame.value(), frames[static_cast<std::size_t>(i)]));
      }
      CHECK(sample::error_of(ImageSequenceWriter::create(posix_storage(), folder, camera)).code ==
            ErrorCode::Exists);
    }
}

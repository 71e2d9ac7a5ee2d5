// The file of a scene: what is cut, damaged or cannot be is one sentence, whatever it is.
#include "firmware_host/film/scene_snapshot.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "firmware_host/commands/snapshot_summary.h"
#include "online/scene/hash_grid/hash_grid_field.h"
#include "tests/online/scene/hash_grid/fit/fit_stream.h"
#include "tests/support/scratch_folder.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::text_of;
using test::write_file;

namespace {

constexpr int kRows = 32, kCols = 48;

Keyframe keyframe(int number) {
  Keyframe key;
  key.frame.facts.sequence = static_cast<std::uint64_t>(number);
  key.frame.facts.timestamp = Instant::from_seconds(10 + number / 30.);
  key.frame.facts.exposure_s = 0.004;
  key.frame.reference_exposure = 0.004;
  key.frame.white = 4;
  key.frame.neutral_gains = ChannelGains{1.25, 1, 0.8};
  key.frame.pose.emplace();
  key.time_s = key.frame.facts.timestamp.seconds();
  key.lens = {1.0 * kCols, 1.0 * kCols, kCols / 2.0, kRows / 2.0};
  key.frame.radiance = Image<float>(3, kRows, kCols);
  for (std::size_t i = 0; i < key.frame.radiance.size(); ++i)
    key.frame.radiance.samples()[i] = static_cast<float>(number) + 0.001f * static_cast<float>(i);
  key.frame.sigma = Image<float>(1, kRows, kCols);
  key.frame.provenance = Image<std::uint8_t>(1, kRows, kCols);
  key.inverse_depth = Image<float>(1, kRows, kCols);
  key.inverse_depth.fill(0.5f);
  if (number == 0) return key;
  for (FlowField* flow : {&key.to_previous, &key.from_previous}) {
    flow->vectors = Image<float>(2, kRows, kCols), flow->vectors.fill(1.5f);
    flow->confidence = Image<float>(1, kRows, kCols), flow->confidence.fill(1);
  }
  return key;
}

// A scene of three frames, with what a test changes of it.
struct Written {
  SceneHead head;
  Response response = Response::gamma(2.2f);

  Written() {
    head.program = "hdrcam 1.0";
    head.camera.name = "a camera", head.camera.width = kCols, head.camera.height = kRows;
    head.first = Instant::from_seconds(8);
    head.path.push_back({9.9, {}, 0});
    for (int i = 0; i < 3; ++i) head.frames.push_back(keyframe(i));
    head.input.facts = head.frames.back().frame.facts;
    head.input.codes = Image<float>(3, kRows, kCols);
    head.input.codes.fill(127);
    head.has_field = true;
  }

  std::string to(const std::string& name) const {
    const std::string path = test::scratch_folder("scene_" + name) + "/s.hdrscene";
    WorkerPool pool(1);
    FitStream stream;
    HashGridField field(FitStream::small_options(), {head.frames.back().lens, kRows, kCols}, pool);
    SceneWriter writer =
        value_of(SceneWriter::create(value_of(FileInMaking::beside(posix_storage(), path)), head, response));
    for (const Keyframe& key : head.frames) require_done(writer.add(key));
    ExposedFrame frame;
    RadianceState state;
    StateMotion motion;
    CameraPose pose;
    DepthMap depth;
    stream.frame(0);
    frame.codes.copy_from(stream.codes);
    state.radiance.copy_from(stream.radiance), state.variance.copy_from(stream.variance);
    require_done(
        field.observe({frame, state, unseen_variance_from(4), motion, pose, depth, stream.response}));
    require_done(writer.finish(head.input, head.has_field ? field.snapshot() : SnapshotHold()));
    return path;
  }
};

// Where each section begins, by the lengths that the file states; its end last.
std::vector<std::size_t> sections_of(const std::string& text) {
  std::vector<std::size_t> at{12};
  while (at.back() < text.size()) {
    std::uint64_t length = 0;
    std::copy_n(text.data() + at.back() + 16, sizeof length, reinterpret_cast<char*>(&length));
    at.push_back(at.back() + 32 + static_cast<std::size_t>(length));
  }
  return at;
}

Error refused(const std::string& path) {
  const auto loaded = load_scene(posix_storage(), path);
  REQUIRE_FALSE(loaded.ok());
  CHECK_THAT(loaded.error().message, Contains(path));
  return loaded.error();
}

}  // namespace

TEST_CASE("a scene comes back from its file to the bit", "[film]") {
  const Written written;
  const std::string path = written.to("whole");
  const SceneSnapshot scene = value_of(load_scene(posix_storage(), path));
  CHECK(value_of(is_scene_snapshot(posix_storage(), path)));
  CHECK(scene.program == "hdrcam 1.0");
  CHECK(scene.camera.name == "a camera");
  CHECK(scene.first == Instant::from_seconds(8));
  REQUIRE(scene.path.size() == 1);
  CHECK(scene.path[0].time_s == 9.9);
  REQUIRE(scene.frames.size() == 3);
  const auto same = [](const auto& a, const auto& b) {
    return a.same_shape(b) && std::ranges::equal(a.samples(), b.samples());
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Keyframe &was = written.head.frames[i], &is = scene.frames[i];
    CHECK(is.time_s == was.time_s);
    CHECK(is.frame.facts.sequence == was.frame.facts.sequence);
    CHECK(is.frame.white == was.frame.white);
    CHECK(is.frame.neutral_gains == was.frame.neutral_gains);
    CHECK(same(is.frame.radiance, was.frame.radiance));
    CHECK(same(is.frame.provenance, was.frame.provenance));
    CHECK(same(is.inverse_depth, was.inverse_depth));
    CHECK(same(is.from_previous.vectors, was.from_previous.vectors));
    CHECK(is.to_previous.empty() == (i == 0));
  }
  CHECK(same(scene.input.codes, written.head.input.codes));
  CHECK(scene.field != nullptr);
  for (int code = 0; code < Response::kCodes; ++code)
    CHECK(scene.response->inverse(1)[static_cast<std::size_t>(code)] ==
          written.response.inverse(1)[static_cast<std::size_t>(code)]);
  CHECK(value_of(check_scene(posix_storage(), path)).frames.size() == 3);
}

TEST_CASE("a response comes back from its curves to the bit, and so do its codes", "[film]") {
  // so flat in the dark that its steps are the least ones, which scaling made smaller still
  std::array<Response::Curve, 3> curves{};
  for (auto& curve : curves)
    for (std::size_t z = 0; z < curve.size(); ++z) curve[z] = 3 * std::pow(static_cast<float>(z) / 255, 4.f);
  const Response before(curves);
  const Response after =
      Response::of_curves({before.inverse(0), before.inverse(1), before.inverse(2)},
                          {before.uncertainty(0), before.uncertainty(1), before.uncertainty(2)});
  for (float x = 0; x < 1; x += 0.001f) {
    CHECK(after.code_of(0, x) == before.code_of(0, x));
    CHECK(after.exposure_of(1, 255 * x) == before.exposure_of(1, 255 * x));
    CHECK(after.slope(2, 255 * x) == before.slope(2, 255 * x));
  }
}

TEST_CASE("a scene has the poses and the unit of its newest frame that has a pose", "[film]") {
  Written written;
  for (Keyframe& key : written.head.frames) {
    key.frame.pose->source = PoseSource::Given;
    key.frame.length_unit = LengthUnit::Metre;
  }
  written.head.frames.back().frame.pose.reset();
  CHECK(filmed(written.head).has_poses);
  CHECK_FALSE(filmed(written.head).stands_still);
  CHECK_THAT(as_table(written.head, "s.hdrscene", 0), Contains("given") && Contains("metre"));
  written.head.frames.front().frame.pose->source = PoseSource::Fixed;
  written.head.frames[1].frame.pose->source = PoseSource::Fixed;
  CHECK(filmed(written.head).stands_still);
  for (Keyframe& key : written.head.frames) key.frame.pose.reset();
  CHECK_FALSE(filmed(written.head).has_poses);
  CHECK_THAT(as_table(written.head, "s.hdrscene", 0), Contains("unknown"));
}

TEST_CASE("a scene without a field comes back without one", "[film]") {
  Written written;
  written.head.has_field = false;
  const SceneSnapshot scene = value_of(load_scene(posix_storage(), written.to("no_field")));
  CHECK(scene.field == nullptr);
  CHECK(filmed(scene).kind == FilmedKind::SnapshotWithoutField);
}

TEST_CASE("a scene's file that ends in or after any of its sections is called truncated", "[film]") {
  const std::string path = Written().to("cut"), whole = text_of(path);
  for (const std::size_t at : sections_of(whole))
    for (const std::size_t size : {at - 1, at, at + 1, at + 31, at + 40}) {
      if (size >= whole.size()) continue;
      write_file(path, whole.substr(0, size));
      INFO(size);
      CHECK(refused(path).code == ErrorCode::Truncated);
      CHECK_FALSE(check_scene(posix_storage(), path).ok());
    }
}

TEST_CASE("a flipped bit in any section of a scene's file is told with the section", "[film]") {
  const std::string path = Written().to("flipped"), whole = text_of(path);
  const std::vector<std::size_t> sections = sections_of(whole);
  CHECK(sections.size() >= 9);  // head, response, three frames, input, field, its frame, its networks, end
  for (std::size_t i = 0; i + 1 < sections.size(); ++i)
    for (const std::size_t at : {sections[i], sections[i] + 20, sections[i] + 32, sections[i + 1] - 1}) {
      if (at >= whole.size()) continue;
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 4);
      write_file(path, damaged);
      INFO("section " << i << ", byte " << at);
      const Error error = refused(path);
      CHECK(error.code == ErrorCode::Corrupt);
      CHECK_THAT(error.message, Contains("copy it again, or save it again with --snapshot"));
      CHECK_FALSE(check_scene(posix_storage(), path).ok());
    }
}

TEST_CASE("values that no scene has are refused, though their checksums are right", "[film]") {
  const auto told = [](const std::function<void(Written&)>& change) {
    Written written;
    change(written);
    const Error error = refused(written.to("wrong"));
    CHECK(error.code == ErrorCode::Corrupt);
    return error.message;
  };
  const auto kNoNumber = std::numeric_limits<float>::quiet_NaN();
  const auto kHead = Contains("section 'scene': it holds values that no scene has");
  CHECK_THAT(told([](Written& w) { w.head.camera.width = 1 << 30; }), kHead);
  CHECK_THAT(told([](Written& w) { w.head.camera.framerate_hz = 0; }), kHead);
  CHECK_THAT(told([](Written& w) { w.head.frames[1].time_s = 0; }), kHead);
  CHECK_THAT(told([](Written& w) { w.head.frames[2].time_s = 1e300; }), kHead);
  CHECK_THAT(told([](Written& w) { w.head.first.since_boot = Duration::min(); }), kHead);
  CHECK_THAT(told([](Written& w) { w.head.frames[2].T_world_camera.R.setZero(); }), kHead);
  CHECK_THAT(told([](Written& w) { w.head.frames[2].lens.fx_px = 0; }), kHead);
  CHECK_THAT(told([&](Written& w) { w.head.frames[0].frame.white = kNoNumber; }), kHead);
  CHECK_THAT(told([&](Written& w) { w.head.frames[0].frame.neutral_gains = ChannelGains{1, 0, 1}; }), kHead);
  CHECK_THAT(told([](Written& w) { w.head.frames[0].depth_unit = 0; }), kHead);
  CHECK_THAT(told([&](Written& w) { w.head.frames[0].frame.radiance.at(1, 2, 3) = kNoNumber; }),
             Contains("section 'frame': it holds a value that no picture has"));
  CHECK_THAT(told([](Written& w) { w.head.frames[1].frame.provenance.at(0, 2, 3) = 5; }),
             Contains("section 'frame': it holds a value that no picture has"));
  CHECK_THAT(told([](Written& w) { w.head.frames[1].inverse_depth.at(0, 2, 3) = 0; }),
             Contains("section 'frame': it holds a value that no picture has"));
  CHECK_THAT(told([](Written& w) { w.head.frames[1].from_previous.vectors.at(0, 2, 3) = 1e9f; }),
             Contains("section 'frame': it holds a value that no picture has"));
  CHECK_THAT(told([](Written& w) { w.head.frames[1] = keyframe(0), w.head.frames[1].time_s = 10.01; }),
             Contains("section 'frame': it has no motion"));
  CHECK_THAT(told([](Written& w) { w.head.camera.height = 2 * kRows; }),
             Contains("section 'frame': it is not as large as its pictures"));
  CHECK_THAT(told([&](Written& w) { w.head.input.codes.at(0, 0, 0) = kNoNumber; }),
             Contains("section 'input': it holds a value that is no code"));
}

TEST_CASE("what is no snapshot is not taken for one, whatever its name", "[film]") {
  const std::string path = test::scratch_folder("scene_none") + "/s.hdrscene";
  for (const char* text : {"", "\x89HDR", "Matroska, perhaps"}) {
    write_file(path, text);
    CHECK_FALSE(value_of(is_scene_snapshot(posix_storage(), path)));
    CHECK(refused(path).code == ErrorCode::NotRecording);
  }
}

#include "firmware_host/sinks/sink_set.h"

#include <new>

#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::example_frame;

namespace {

// A sink that exists in this test alone: it writes the number of frames into a file.
class TallySink : public FrameSink {
 public:
  explicit TallySink(const SinkRequest& request) : storage_(request.storage), path_(request.path) {}

  Result<void> emit(const EmittedFrame&) override { return ++frames_, Result<void>{}; }
  Result<void> finish() override {
    const std::string text = std::to_string(frames_);
    return write_whole(storage_, path_, std::as_bytes(std::span(text)));
  }
  Result<void> conclude(const RunRecord& record) override {
    CHECK(record.emitted == frames_);
    return {};
  }

 private:
  Storage& storage_;
  const std::string path_;
  int frames_ = 0;
};

Result<std::unique_ptr<FrameSink>> open_tally(const SinkRequest& request) {
  return std::unique_ptr<FrameSink>(std::make_unique<TallySink>(request));
}

class UnfinishedSink : public FrameSink {
 public:
  Result<void> emit(const EmittedFrame&) override { return {}; }
  Result<void> finish() override { throw std::bad_alloc(); }
  Result<void> conclude(const RunRecord&) override { throw std::bad_alloc(); }
};

const CameraFacts kCamera;
const SinkRequest kRequest{.path = {}, .camera = kCamera, .layers = {}, .storage = posix_storage()};

const SinkKind kKinds[] = {
    {"tally", "--tally", "number of frames", SinkPace::Complete, SinkTarget::Files, open_tally},
    {"light", "--light", "the same, in the thread that emits", SinkPace::Light, SinkTarget::Files,
     open_tally},
};

}  // namespace

TEST_CASE("one line of the table is one more sink: it is opened where a path is named, fed and finished") {
  const std::string folder = sample::scratch_folder("sink_set");
  auto sinks = SinkSet::open(kKinds, {{"tally", folder + "/a"}, {"light", folder + "/b"}, {"other", "c"}},
                             kRequest, RunPace::Clip);
  REQUIRE(sinks.ok());
  const HdrFrame frame = example_frame(0);
  for (int i = 0; i < 5; ++i) REQUIRE(sinks.value().emit({frame, ExposedFrame{}, FrameRecord{}}).ok());
  REQUIRE(sinks.value().finish().ok());
  CHECK(read_whole(posix_storage(), folder + "/a").value() == "5");
  CHECK(read_whole(posix_storage(), folder + "/b").value() == "5");
  RunRecord record;
  record.emitted = 5;
  CHECK(sinks.value().conclude(record).ok());
  const auto times = sinks.value().times();
  REQUIRE(times.size() == 2);
  for (const SinkTimes& sink : times) CHECK(sink.frames == 5);
  CHECK(times[0].name == "tally");
}

TEST_CASE("the standard output takes frames alone, and a sheet is a PNG picture") {
  const auto refusal = [&](const char* sink, const std::string& path) {
    const auto refused = SinkSet::open(sink_kinds(), {{sink, path}}, kRequest, RunPace::Clip);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::Invalid);
    return refused.error().message;
  };
  CHECK(refusal("stats", "-") ==
        "--stats - would write a file named '-': only HDR frames go to the standard output; name a file");
  CHECK(refusal("report", "-").starts_with("--report - would write"));
  const std::string sheet = sample::scratch_folder("sink_names") + "/s.jpg";
  CHECK(refusal("sheet", sheet) ==
        "--sheet '" + sheet + "' is not the name of a PNG picture; name it sheet.png");
}

TEST_CASE("a sink without a path is not opened, and one that cannot be opened says why") {
  CHECK(SinkSet::open(kKinds, {{"tally", ""}}, kRequest, RunPace::Clip).value().empty());
  const auto refused = SinkSet::open(sink_kinds(), {{"frames", "frame.exr"}}, kRequest, RunPace::Clip);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::Invalid);
}

TEST_CASE("a video of pictures smaller than its codec takes is refused before the first frame") {
  const std::string path = sample::scratch_folder("tiny_video") + "/x.mp4";
  const auto opened = [&](int width, int height, CodecChoice codec) {
    CameraFacts camera;
    camera.width = width, camera.height = height;
    const VideoOptions video{.codec = codec};
    const SinkRequest request{.path = "", .camera = camera, .video = video, .storage = posix_storage()};
    return SinkSet::open(sink_kinds(), {{"frames", path}}, request, RunPace::Clip);
  };
  const auto refused = opened(8, 64, CodecChoice::Suitable);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::Unsupported);
  CHECK(opened(16, 16, CodecChoice::Suitable).ok());
  CHECK(opened(8, 64, CodecChoice::Av1).ok());
}

TEST_CASE("every sink is finished, also after another one failed") {
  const std::string folder = sample::scratch_folder("sink_set_fails");
  auto sinks =
      SinkSet::open(kKinds, {{"tally", "/proc/no/such"}, {"light", folder + "/b"}}, kRequest, RunPace::Clip);
  REQUIRE(sinks.ok());
  CHECK_FALSE(sinks.value().finish().ok());
  CHECK(read_whole(posix_storage(), folder + "/b").value() == "0");
  CHECK(sinks.value().whole_outputs(posix_storage()) == folder + "/b\n");
}

TEST_CASE(
    "every sink is finished and concluded, also where another one throws, and the first failure is told") {
  const std::string folder = sample::scratch_folder("sink_set_throws");
  const SinkKind kinds[] = {kKinds[0],
                            {"unfinished", "--unfinished", "what memory does not suffice for",
                             SinkPace::Complete, SinkTarget::Files,
                             [](const SinkRequest&) -> Result<std::unique_ptr<FrameSink>> {
                               return std::unique_ptr<FrameSink>(std::make_unique<UnfinishedSink>());
                             }},
                            kKinds[1]};
  const OutputPaths paths = {{"unfinished", folder + "/a"}, {"light", folder + "/b"}};
  auto sinks = SinkSet::open(kinds, paths, kRequest, RunPace::Clip);
  REQUIRE(sinks.ok());
  const HdrFrame frame = example_frame(0);
  REQUIRE(sinks.value().emit({frame, ExposedFrame{}, FrameRecord{}}).ok());
  CHECK_THROWS_AS(sinks.value().finish(), std::bad_alloc);
  CHECK(read_whole(posix_storage(), folder + "/b").value() == "1");
  RunRecord record;
  record.emitted = 1;  // which the last sink checks
  CHECK_THROWS_AS(sinks.value().conclude(record), std::bad_alloc);
  CHECK(sinks.value().whole_outputs(posix_storage()) == folder + "/b\n");

  OutputPaths with_error = paths;
  with_error["tally"] = "/proc/no/such";  // the first to fail
  auto failing = SinkSet::open(kinds, with_error, kRequest, RunPace::Clip);
  REQUIRE(failing.ok());
  CHECK(sample::error_of(failing.value().finish()).message.find("/proc/no/such") != std::string::npos);
}

TEST_CASE("a numbered output is told with the frames that arrived and those left out, once there are any") {
  const std::string frames = sample::scratch_folder("sink_set_numbered") + "/%06d.txt";
  const SinkKind kinds[] = {{"previews", "--previews", "a picture of each frame", SinkPace::Latest,
                             SinkTarget::Files, open_tally, ".txt"}};
  auto sinks = SinkSet::open(kinds, {{"previews", frames}}, kRequest, RunPace::Clip);
  REQUIRE(sinks.ok());
  CHECK(sinks.value().whole_outputs(posix_storage()).empty());
  const HdrFrame frame = example_frame(0);
  const ExposedFrame input;
  const FrameRecord record;
  const EmittedFrame emitted{frame, input, record};
  REQUIRE(sinks.value().emit(emitted).ok());
  REQUIRE(sinks.value().emit(emitted, Previews::LeftOut).ok());
  REQUIRE(sinks.value().finish().ok());
  CHECK(sinks.value().whole_outputs(posix_storage()) == frames + ": 1 frame, 1 left out to keep up\n");
}

TEST_CASE("one file whose name looks numbered is told as one file, and not where it could not be written") {
  const std::string file = sample::scratch_folder("sink_set_one") + "/%06d.txt";
  const auto told = [&](const std::string& path) {
    auto sinks = SinkSet::open(kKinds, {{"light", path}}, kRequest, RunPace::Clip);
    REQUIRE(sinks.ok());
    const HdrFrame frame = example_frame(0);
    for (int i = 0; i < 3; ++i) REQUIRE(sinks.value().emit({frame, ExposedFrame{}, FrameRecord{}}).ok());
    (void)sinks.value().finish();
    return sinks.value().whole_outputs(posix_storage());
  };
  CHECK(told(file) == file + "\n");
  CHECK(told("/proc/no/%06d.txt").empty());
}

TEST_CASE(
    "a percent sign alone makes no numbered output: the file is told, and the previews are the pictures") {
  const std::string file = sample::scratch_folder("sink_set_percent") + "/50%.txt";
  auto sinks = SinkSet::open(kKinds, {{"tally", file}}, kRequest, RunPace::Clip);
  REQUIRE(sinks.ok());
  const HdrFrame frame = example_frame(0);
  REQUIRE(sinks.value().emit({frame, ExposedFrame{}, FrameRecord{}}).ok());
  REQUIRE(sinks.value().finish().ok());
  CHECK(sinks.value().whole_outputs(posix_storage()) == file + "\n");
  CHECK(patterns_of({{"frames", "50%.mp4"}, {"preview", "p/%06d.png"}}).pictures == "p/%06d.png");
  CHECK(patterns_of({{"frames", "50%/%06d.exr"}, {"preview", "p/%06d.png"}}).pictures == "50%/%06d.exr");
}

TEST_CASE("an earlier run's file that this run did not replace is not told as one of this run") {
  const std::string folder = sample::scratch_folder("sink_set_earlier");
  const OutputPaths paths = {
      {"frames", folder + "/out.mkv"}, {"preview", folder + "/%06d.png"}, {"colmap", folder + "/model"}};
  REQUIRE(write_whole(posix_storage(), folder + "/out.mkv", {}).ok());
  auto stopped = SinkSet::open(sink_kinds(), paths, kRequest, RunPace::Clip);
  REQUIRE(stopped.ok());
  REQUIRE(stopped.value().finish().ok());
  CHECK(stopped.value().whole_outputs(posix_storage()).empty());

  auto replaces = SinkSet::open(kKinds, {{"light", folder + "/out.mkv"}}, kRequest, RunPace::Clip);
  REQUIRE(replaces.ok());
  REQUIRE(replaces.value().finish().ok());
  CHECK(replaces.value().whole_outputs(posix_storage()) == folder + "/out.mkv\n");
}

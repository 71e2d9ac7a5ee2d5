// The sinks that write poses when a run ends: which frames they name.
#include "firmware_host/sinks/scene_files/pose_files.h"

#include <fstream>
#include <span>
#include <string>

#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/support/scene_file_readers.h"

using namespace hdrcam;

namespace {

HdrFrame posed_frame(std::uint64_t sequence) {
  HdrFrame frame = test::example_frame(sequence);
  frame.pose.emplace().source = PoseSource::Tracked;
  frame.pose->T_world_camera.t.x() = 0.1 * static_cast<double>(sequence);
  frame.length_unit = LengthUnit::FirstDepth;
  frame.lens = Intrinsics{30, 30, 16, 12};
  frame.lens_is_assumed = true;
  return frame;
}

void write_picture(const std::string& path) { std::ofstream(path) << "a picture"; }

}  // namespace

TEST_CASE("a frame whose pose is lost, and one whose picture is not there, are left out and counted") {
  const std::string folder = sample::scratch_folder("pose_files");
  const PicturePatterns patterns{folder + "/%04d.png", ""};
  auto transforms = create_transforms(posix_storage(), folder + "/poses/transforms.json", patterns);
  auto colmap = create_colmap(posix_storage(), folder + "/colmap", patterns);
  REQUIRE((transforms.ok() && colmap.ok()));
  for (const std::uint64_t sequence : {0U, 1U, 2U, 3U}) {
    HdrFrame frame = posed_frame(sequence);
    frame.pose->lost = sequence == 1;
    if (sequence >= 2)
      frame.points.push_back({{0, 0, 2.0 + static_cast<double>(sequence)}, 10.5, 8.5, {1, 1, 1}});
    for (FrameSink* sink : {transforms.value().get(), colmap.value().get()})
      REQUIRE(test::emit(*sink, frame).ok());
    if (sequence != 2) write_picture(folder + "/000" + std::to_string(sequence) + ".png");
  }
  for (FrameSink* sink : {transforms.value().get(), colmap.value().get()})
    REQUIRE((sink->finish().ok() && sink->conclude({}).ok()));

  const auto read = test::read_transforms(folder + "/poses/transforms.json");
  CHECK(read.cameras.size() == 2);
  CHECK((read.cameras.contains("../0000.png") && read.cameras.contains("../0003.png")));
  CHECK(read.json["hdrcam"]["frames_left_out"] == 2);
  CHECK(read.json["hdrcam"]["lens"] == "assumed");
  const auto model = test::read_colmap(folder + "/colmap");
  REQUIRE(model.images.size() == 2);
  CHECK(model.named("0003.png").camera.t[0] == Approx(-0.3));
  REQUIRE(model.points.size() == 1);  // the other one's picture is not there
  const auto& [id, point] = *model.points.begin();
  CHECK(point.p_world.z == 5);
  CHECK(model.images.at(point.track[0].first).sightings[0].point == id);
}

TEST_CASE("a point of a world that is measured from far away is written to a tenth of a millimetre") {
  const std::string folder = sample::scratch_folder("pose_files_far");
  auto colmap = create_colmap(posix_storage(), folder + "/colmap", {folder + "/%04d.png", ""});
  REQUIRE(colmap.ok());
  const Eigen::Vector3d p_world(500000.12345, 4500000.12345, 120.12345);  // as a map counts metres
  HdrFrame frame = posed_frame(0);
  frame.points.push_back({p_world, 10.5, 8.5, {1, 1, 1}});
  REQUIRE(test::emit(*colmap.value(), frame).ok());
  write_picture(folder + "/0000.png");
  REQUIRE((colmap.value()->finish().ok() && colmap.value()->conclude({}).ok()));
  const auto model = test::read_colmap(folder + "/colmap");
  REQUIRE(model.points.size() == 1);
  const test::Vector3& read = model.points.begin()->second.p_world;
  CHECK((p_world - Eigen::Vector3d(read.x, read.y, read.z)).norm() < 1e-4);
}

TEST_CASE("a film whose first frames have no pose has those of the later ones, and an error where none has") {
  const std::string folder = sample::scratch_folder("pose_files_unposed");
  auto transforms =
      create_transforms(posix_storage(), folder + "/transforms.json", {folder + "/%04d.png", ""});
  REQUIRE(transforms.ok());
  for (const std::uint64_t sequence : {0U, 1U, 2U}) {
    HdrFrame frame = posed_frame(sequence);
    frame.depth = Image<float>(1, frame.radiance.rows(), frame.radiance.cols());
    if (sequence < 2) frame.pose.reset();
    REQUIRE(test::emit(*transforms.value(), frame).ok());
    write_picture(folder + "/000" + std::to_string(sequence) + ".png");
    if (sequence != 1) continue;
    const Result<void> none = transforms.value()->conclude({});
    REQUIRE_FALSE(none.ok());
    CHECK_THAT(none.error().message, Catch::Contains("no frame has one"));
    CHECK_FALSE(posix_storage().open(folder + "/transforms.json").ok());
  }
  REQUIRE((transforms.value()->finish().ok() && transforms.value()->conclude({}).ok()));
  const auto read = test::read_transforms(folder + "/transforms.json");
  REQUIRE(read.cameras.size() == 1);
  CHECK(read.cameras.contains("0002.png"));
  CHECK(read.json["hdrcam"]["frames_left_out"] == 2);
}

TEST_CASE("an exposure that was estimated is a ratio, and is not stated as a time") {
  const std::string folder = sample::scratch_folder("pose_files_estimated");
  auto transforms =
      create_transforms(posix_storage(), folder + "/transforms.json", {folder + "/%04d.png", ""});
  REQUIRE(transforms.ok());
  for (const std::uint64_t sequence : {0U, 1U}) {
    HdrFrame frame = posed_frame(sequence);
    frame.facts.exposure_s = 0.004;
    if (sequence == 1) frame.facts.exposure_source = ExposureSource::Estimated;
    REQUIRE(test::emit(*transforms.value(), frame).ok());
    write_picture(folder + "/000" + std::to_string(sequence) + ".png");
  }
  REQUIRE((transforms.value()->finish().ok() && transforms.value()->conclude({}).ok()));
  const auto read = test::read_transforms(folder + "/transforms.json");
  CHECK(read.json["frames"][0]["exposure_s"] == 0.004);
  CHECK_FALSE(read.json["frames"][1].contains("exposure_s"));
}

TEST_CASE("a new pose is not that of an earlier run's picture, where the run shed its own") {
  const std::string folder = sample::scratch_folder("pose_files_earlier");
  const auto picture = [&](int sequence) { return folder + "/000" + std::to_string(sequence) + ".png"; };
  for (const int sequence : {0, 1, 2}) write_picture(picture(sequence));
  const PicturePatterns patterns{folder + "//%04d.png", ""};
  auto transforms = create_transforms(posix_storage(), folder + "/transforms.json", patterns);
  auto colmap = create_colmap(posix_storage(), folder + "/colmap", patterns);
  REQUIRE((transforms.ok() && colmap.ok()));
  const std::string text = "a new picture";
  const auto replace = [&](int sequence) {
    REQUIRE(write_whole(posix_storage(), picture(sequence), std::as_bytes(std::span(text))).ok());
  };
  replace(0);  // a sink of pictures may be faster than that of poses
  for (const int sequence : {0, 1, 2})
    for (FrameSink* sink : {transforms.value().get(), colmap.value().get()})
      REQUIRE(test::emit(*sink, posed_frame(static_cast<std::uint64_t>(sequence))).ok());
  replace(2);
  for (FrameSink* sink : {transforms.value().get(), colmap.value().get()})
    REQUIRE((sink->finish().ok() && sink->conclude({}).ok()));

  const auto read = test::read_transforms(folder + "/transforms.json");
  CHECK(read.cameras.size() == 2);
  CHECK((read.cameras.contains("0000.png") && read.cameras.contains("0002.png")));
  CHECK(read.json["hdrcam"]["frames_left_out"] == 1);
  CHECK(test::read_colmap(folder + "/colmap").images.size() == 2);
}

TEST_CASE("poses of a run that left none of its pictures replace no earlier ones") {
  const std::string folder = sample::scratch_folder("pose_files_no_picture");
  const PicturePatterns patterns{folder + "/%04d.png", ""};
  const std::string earlier = "an earlier model", model = folder + "/colmap",
                    poses = folder + "/transforms.json", images = model + "/images.txt";
  auto transforms = create_transforms(posix_storage(), poses, patterns);
  auto colmap = create_colmap(posix_storage(), model, patterns);
  REQUIRE((transforms.ok() && colmap.ok()));
  for (const std::string& file : {poses, images})
    REQUIRE(write_whole(posix_storage(), file, std::as_bytes(std::span(earlier))).ok());
  for (FrameSink* sink : {transforms.value().get(), colmap.value().get()}) {
    REQUIRE(test::emit(*sink, posed_frame(0)).ok());
    CHECK((sink->finish().ok() && sink->conclude({}).ok()));
  }
  for (const std::string& file : {poses, images}) CHECK(read_whole(posix_storage(), file).value() == earlier);
}

TEST_CASE("a model has the poses of one world, of that with most pictures, and of equals the newest") {
  const struct { std::size_t ended, newest, kept; } runs[] = {{2, 3, 1}, {3, 2, 0}, {2, 2, 1}};
  for (const auto& run : runs) {
    CAPTURE(run.ended, run.newest);
    const std::string folder = sample::scratch_folder("pose_files_worlds");
    const PicturePatterns patterns{folder + "/%04d.png", ""};
    auto transforms = create_transforms(posix_storage(), folder + "/transforms.json", patterns);
    auto colmap = create_colmap(posix_storage(), folder + "/colmap", patterns);
    REQUIRE((transforms.ok() && colmap.ok()));
    for (std::uint64_t sequence = 0; sequence < run.ended + run.newest; ++sequence) {
      HdrFrame frame = posed_frame(sequence);
      frame.pose->world = sequence < run.ended ? 0 : 1;
      frame.points.push_back({{0, 0, 1.0 + frame.pose->world}, 10.5, 8.5, {1, 1, 1}});
      for (FrameSink* sink : {transforms.value().get(), colmap.value().get()})
        REQUIRE(test::emit(*sink, frame).ok());
      write_picture(folder + "/000" + std::to_string(sequence) + ".png");
    }
    for (FrameSink* sink : {transforms.value().get(), colmap.value().get()})
      REQUIRE((sink->finish().ok() && sink->conclude({}).ok()));

    const std::size_t kept = run.kept == 1 ? run.newest : run.ended;
    const auto read = test::read_transforms(folder + "/transforms.json");
    CHECK(read.cameras.size() == kept);
    CHECK(read.cameras.contains("0000.png") == (run.kept == 0));
    CHECK(read.json["hdrcam"]["frames_left_out"] == run.ended + run.newest - kept);
    const auto model = test::read_colmap(folder + "/colmap");
    CHECK(model.images.size() == kept);
    CHECK(model.points.size() == kept);
    for (const auto& [id, point] : model.points) {
      CHECK(point.p_world.z == 1.0 + static_cast<double>(run.kept));
      CHECK(model.images.at(point.track[0].first).sightings[0].point == id);
    }
  }
}

TEST_CASE("however often tracking begins anew, points are kept of the largest worlds alone") {
  const std::string folder = sample::scratch_folder("pose_files_many_worlds");
  auto colmap = create_colmap(posix_storage(), folder + "/colmap", {folder + "/%02d.png", ""});
  REQUIRE(colmap.ok());
  const bool large = GENERATE(true, false);  // the first world, whose pictures alone are written
  const int pictures_of_first = large ? 3 : 1;
  std::uint64_t sequence = 0;
  for (int world = 0; world < 9; ++world)
    for (int i = 0; i < (world == 0 ? pictures_of_first : 2); ++i, ++sequence) {
      HdrFrame frame = posed_frame(sequence);
      frame.pose->world = world;
      frame.points.push_back({{0, 0, 5}, 10.5, 8.5, {1, 1, 1}});
      REQUIRE(test::emit(*colmap.value(), frame).ok());
      if (world == 0) write_picture(folder + "/0" + std::to_string(sequence) + ".png");
    }
  REQUIRE((colmap.value()->finish().ok() && colmap.value()->conclude({}).ok()));
  const auto model = test::read_colmap(folder + "/colmap");
  CHECK(model.images.size() == static_cast<std::size_t>(pictures_of_first));
  CHECK(model.points.size() == (large ? 3U : 0U));
}

TEST_CASE("a full disk ends the run with its own error and leaves no half of a file") {
  const std::string folder = sample::scratch_folder("pose_files_full");
  FaultyStorage full(posix_storage(), test::disk_of(100));
  auto sink = create_transforms(full, folder + "/transforms.json", {folder + "/%04d.png", ""});
  REQUIRE(sink.ok());
  write_picture(folder + "/0000.png");
  REQUIRE(test::emit(*sink.value(), posed_frame(0)).ok());
  CHECK(sample::error_of(sink.value()->conclude({})).code == ErrorCode::NoSpace);
  CHECK_FALSE(posix_storage().open(folder + "/transforms.json").ok());
}

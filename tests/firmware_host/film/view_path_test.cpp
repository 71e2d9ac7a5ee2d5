#include "firmware_host/film/view_path.h"

#include <cmath>
#include <span>

#include "firmware_host/film/steady_path.h"
#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

std::string file_with(const std::string& name, const std::string& text) {
  static const std::string folder = sample::scratch_folder("paths");
  const std::string path = folder + "/" + name;
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span(text))).ok());
  return path;
}

std::string refusal(const Result<ViewPath>& path) {
  REQUIRE_FALSE(path.ok());
  CHECK(path.error().code == ErrorCode::Invalid);
  return path.error().message;
}

}  // namespace

TEST_CASE("a view is a shift to the right, down and forward, and a turn to the right, up and clockwise",
          "[film]") {
  const RigidTransform T = ViewPath::parse_view("0.1,-0.2,3").value().at(0).T_recorded_view();
  CHECK((T.t - Eigen::Vector3d(0.1, -0.2, 3)).norm() < 1e-12);
  CHECK(T.R.isIdentity());
  const auto forward = [](const char* text) {
    return Eigen::Vector3d(ViewPath::parse_view(text).value().at(0).T_recorded_view().R.col(2));
  };
  CHECK(forward("0,0,0,90,0,0").isApprox(Eigen::Vector3d(1, 0, 0), 1e-9));
  CHECK(forward("0,0,0,0,90,0").isApprox(Eigen::Vector3d(0, -1, 0), 1e-9));
  const Eigen::Matrix3d rolled = ViewPath::parse_view("0,0,0,0,0,90").value().at(0).T_recorded_view().R;
  CHECK(rolled.col(0).isApprox(Eigen::Vector3d(0, 1, 0), 1e-9));
}

TEST_CASE("a length with a unit is in metres and says so", "[film]") {
  CHECK(parse_length("--stereo", "63mm").value().value == Approx(0.063));
  CHECK(parse_length("--stereo", "6.3cm").value().value == Approx(0.063));
  CHECK(parse_length("--stereo", "2m").value().value == Approx(2));
  CHECK(parse_length("--stereo", "63mm").value().in_metres);
  CHECK_FALSE(parse_length("--stereo", "0.02").value().in_metres);
  CHECK(ViewPath::parse_view("0.1,0,5cm").value().in_metres());
  const auto wrong = parse_length("--stereo", "63km");
  REQUIRE_FALSE(wrong.ok());
  CHECK(wrong.error().message ==
        "--stereo takes a length, such as 63mm or 0.02 (units of the scene), not '63km'");
}

TEST_CASE("an invalid view is refused with an example of a valid one", "[film]") {
  CHECK_THAT(refusal(ViewPath::parse_view("left")),
             Contains("--view takes dx,dy,dz") && Contains("not 'left'"));
  CHECK_THAT(refusal(ViewPath::parse_view("1,2")), Contains("0.1,0,0,-5,0,0"));
  CHECK_THAT(refusal(ViewPath::parse_view("1,2,x")), Contains("'x'"));
  CHECK_THAT(refusal(ViewPath::parse_view("1,2,nan")), Contains("'nan'"));
  CHECK_THAT(refusal(ViewPath::parse_view("0,0,0,ten,0,0")),
             Contains("'ten' is not an angle in degrees for yaw"));
  CHECK_THAT(refusal(ViewPath::parse_view("1e9,0,0")), Contains("--view"));
}

TEST_CASE("a path passes through its poses, holds at its ends, and reads the same as CSV and as JSON",
          "[film]") {
  const std::string csv =
      file_with("move.csv", "time_s, dx, yaw\n# a note\n0, 0, 0\n1, 0.5, 10\n2, 0.4, -10\n");
  const std::string json = file_with(
      "move.json", R"([{"time_s":0},{"time_s":1,"dx":0.5,"yaw":10},{"time_s":2,"dx":0.4,"yaw":-10}])");
  for (const std::string& path : {csv, json}) {
    const ViewPath walk = ViewPath::read_path(posix_storage(), path).value();
    CHECK(walk.is_path());
    CHECK(walk.end_s() == 2);
    CHECK(walk.at(-1).shift.x() == 0);
    CHECK(walk.at(1).shift.x() == Approx(0.5));
    CHECK(walk.at(1).turn_deg.x() == Approx(10));
    CHECK(walk.at(9).turn_deg.x() == -10);
    const double middle = walk.at(0.5).shift.x();
    CHECK((middle > 0.2 && middle < 0.35));
    // smooth: the speed before a pose is the speed after it
    const double before = (walk.at(1).shift.x() - walk.at(1 - 1e-4).shift.x()) / 1e-4;
    const double after = (walk.at(1 + 1e-4).shift.x() - walk.at(1).shift.x()) / 1e-4;
    CHECK(before == Approx(after).margin(1e-3));
  }
}

TEST_CASE("a path file of a spreadsheet begins with a byte order mark", "[film]") {
  const auto csv = file_with("bom.csv", "\xef\xbb\xbftime_s,dx\n0,0.5\n");
  CHECK(ViewPath::read_path(posix_storage(), csv).value().at(0).shift.x() == 0.5);
  const auto json = file_with("bom", "\xef\xbb\xbf[{\"time_s\": 0, \"dx\": 0.5}]");
  CHECK(ViewPath::read_path(posix_storage(), json).value().at(0).shift.x() == 0.5);
}

TEST_CASE("a path file with a mistake is refused, naming its line", "[film]") {
  const auto read = [](const char* name, const char* text) {
    return refusal(ViewPath::read_path(posix_storage(), file_with(name, text)));
  };
  CHECK_THAT(read("a.csv", "time_s,dx\n0,1\n1,two\n"), Contains("a.csv:3: 'two' is not a number for dx"));
  CHECK_THAT(read("b.csv", "time_s,yau\n0,1\n"),
             Contains("b.csv:1: unknown name 'yau' (did you mean 'yaw'?)"));
  CHECK_THAT(read("c.csv", "time_s,dx\n0,1,2\n"), Contains("c.csv:2: 3 values, but the first line names 2"));
  CHECK_THAT(read("d.csv", "time_s,dx\n1,1\n0,1\n"), Contains("not in the order of their times"));
  CHECK_THAT(read("o.csv", "time_s,dx\n1,1\n1,2\n"), Contains("two poses are of 1 s; leave out one"));
  CHECK_THAT(read("k.csv", "dx,dy\n0,1\n"), Contains("k.csv:1: names no time_s"));
  CHECK_THAT(read("m.csv", "time_s,dx,dx\n0,1,2\n"), Contains("m.csv:1: names dx twice"));
  CHECK_THAT(read("e.csv", ""), Contains("has no poses"));
  CHECK_THAT(read("f.json", "{\"time_s\": 0}"), Contains("is not a JSON array of poses"));
  CHECK_THAT(read("g.json", "[{\"time_s\": 0, \"dx\": \"1\"}]"), Contains("pose 0"));
  CHECK_THAT(read("l.json", "[{\"time_s\": 0}, {\"dx\": 1}]"), Contains("l.json, pose 1: has no time_s"));
  CHECK_THAT(read("n.json", "[{\"time_s\": 0}, {\"time_s\": 1, \"dx\": 1, \"dx\": 1}]"),
             Contains("n.json: a pose names dx twice"));
  for (const char* time_s : {"-1", "2e6"})
    CHECK_THAT(read("h.csv", fmt::format("time_s,dx\n{},1\n", time_s).c_str()),
               Contains("a time from 0 to 1000000 s"));
  CHECK_THAT(read("i.csv", "time_s;dx\n0;0,1\n"), Contains("i.csv:1: the values are separated by ';'"));
  const std::string bytes("\x1a\x45\xdf\xa3\0\0,\x01", 8);
  CHECK_THAT(refusal(ViewPath::read_path(posix_storage(), file_with("j.mkv", bytes))),
             Contains("j.mkv' is not a path of views: it is not text"));
  CHECK(ViewPath::read_path(posix_storage(), "/nowhere/x.csv").error().code == ErrorCode::NotFound);
}

TEST_CASE("where tracking began anew, a steady path is that of the nearest pose's world", "[film]") {
  SteadyPath path;
  RigidTransform first, anew;
  first.t = {1, 0, 0}, anew.t = {9, 0, 0};
  anew.R = rotation(Eigen::Vector3d(0, 1, 0));
  for (int i = 0; i < 20; ++i) path.add(i / 20.0, i < 10 ? first : anew, i < 10 ? 0 : 1);
  for (int i = 0; i < 20; ++i) {
    const RigidTransform T = path.at(i / 20.0);
    CHECK(T.t.x() == Approx(i < 10 ? 1 : 9));
    CHECK((T.R - (i < 10 ? first : anew).R).norm() < 1e-9);
  }
}

TEST_CASE("a steady path forgets what no later moment needs", "[film]") {
  SteadyPath path, whole;
  for (int i = 0; i < 90; ++i) {
    RigidTransform T;
    T.t.x() = i % 3;
    for (SteadyPath* one : {&path, &whole}) one->add(i / 30.0, T);
    path.forget_before(i / 30.0);
  }
  CHECK(path.poses() <= 17);
  CHECK(path.at(89 / 30.0).t == whole.at(89 / 30.0).t);
  path.forget_before(100);
  CHECK(path.at(100).t.x() == Approx(2));
}

TEST_CASE("a steady path loses the shake of the recorded one and keeps its way", "[film]") {
  SteadyPath path;
  constexpr int kFrames = 90;
  const auto shaken = [](int i) { return 0.02 * (i % 2 == 0 ? 1 : -1); };
  for (int i = 0; i < kFrames; ++i) {
    RigidTransform T;
    T.t.x() = 0.01 * i + shaken(i);
    T.R = rotation(Eigen::Vector3d(0, 0.005 * i + shaken(i), 0));
    path.add(i / 30.0, T);
  }
  for (int i = 20; i < kFrames - 20; ++i) {
    const RigidTransform T = path.at(i / 30.0);
    CHECK(T.t.x() == Approx(0.01 * i).margin(0.002));
    CHECK((T.R - rotation(Eigen::Vector3d(0, 0.005 * i, 0))).norm() < 0.003);
    CHECK(T.is_rigid());
  }
}

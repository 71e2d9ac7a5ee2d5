// The live view as a browser and a monitor meet it, over real sockets.
#include "firmware_host/sinks/live_view/live_view.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>
#include <tuple>

#include "hal/jpeg_decoder.h"
#include "hal/recording/png_image.h"
#include "render/display_light.h"
#include "tests/contracts/expect.h"
#include "tests/firmware_host/sinks/example_frames.h"
#include "tests/firmware_host/web/http_client.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/places.h"
#include "tests/support/becomes_true.h"

#include "tests/support/files.h"

using namespace hdrcam;
using nlohmann::json;
using test::becomes_true;
using test::emit;
using test::example_frame;
using test::HttpClient;
using test::HttpReply;

namespace {

const std::string kToken = "a token of the test";

class ExampleControl : public RunControl {
 public:
  std::string file, shutter, gain;  // what it was told

  std::string recording() const override { return file; }
  Result<std::string> start_recording() override {
    if (!file.empty()) return Error{ErrorCode::Busy, "a recording is open"};
    return file = "takes/001.mkv";
  }
  Result<void> stop_recording() override {
    if (file.empty()) return Error{ErrorCode::NotFound, "nothing is being recorded"};
    return file.clear(), Result<void>();
  }
  Result<void> change_cycle(const std::string& to, const std::string& with_gain) override {
    if (to == "wrong") return Error{ErrorCode::Invalid, "'wrong' is no exposure time"};
    if (to == "late") return Error{ErrorCode::Interrupted, "the run ends"};
    return shutter = to, gain = with_gain, Result<void>();
  }
  std::vector<NamedValue> counters() const override {
    return {{"captured", 12},        {"emitted", 7},
            {"recorded", 0},         {"dropped", 5},
            {"dropped.shed", 3},     {"dropped.unproved", 2},
            {"camera.lost", 1},      {"camera.proved", 9},
            {"camera.plausible", 1}, {"camera.contradicted", 0},
            {"camera.unknown", 2}};
  }
};

// Whose counters take until they are released: meanwhile the server's thread answers nobody.
class HeldControl : public ExampleControl {
 public:
  mutable std::atomic<bool> asked{false}, gave_up{false};
  std::atomic<bool> released{false};

  std::vector<NamedValue> counters() const override {
    asked = true;
    if (!becomes_true([&] { return released.load(); })) gave_up = true;
    return ExampleControl::counters();
  }
};

std::unique_ptr<LiveView> open_view(RunControl* control = nullptr) {
  return value_of(LiveView::open("127.0.0.1:0", {.token = kToken}, control));
}

HttpReply get(const LiveView& view, const std::string& path) {
  return HttpClient(view.address().port).get(path);
}

json json_at(const LiveView& view, const std::string& path) {
  const HttpReply reply = get(view, path);
  REQUIRE(reply.status == 200);
  return json::parse(reply.body);
}

Image<std::uint16_t> decoded_jpeg(const std::string& bytes, int rows, int cols) {
  Image<std::uint16_t> picture(3, rows, cols);
  require_done(jpeg_decoder()(std::as_bytes(std::span(bytes)), picture));
  return picture;
}

// Name{labels} -> value. Fails for a line that Prometheus would not take.
std::map<std::string, double> parsed_metrics(const std::string& text) {
  std::map<std::string, double> values;
  std::set<std::string> families;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    INFO(line);
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    if (first == "#") {
      CHECK((second == "HELP" || second == "TYPE"));
      families.insert(third);
      continue;
    }
    CHECK(families.contains(first.substr(0, first.find('{'))));
    CHECK(third.empty());
    CHECK(values.emplace(first, std::stod(second)).second);
  }
  CHECK(text.ends_with('\n'));
  return values;
}

}  // namespace

TEST_CASE("the live page and its parts are served, and ask nothing of other machines") {
  const auto view = open_view();
  const HttpReply page = get(*view, "/");
  CHECK(page.status == 200);
  CHECK(page.headers.at("content-type").starts_with("text/html"));
  for (const char* part : {"/live.css", "/live.js"}) {
    CHECK(page.body.find(part + 1) != std::string::npos);
    CHECK(get(*view, part).status == 200);
  }
  for (const char* path : {"/", "/live.css", "/live.js"})
    CHECK(get(*view, path).body.find("://") == std::string::npos);
}

TEST_CASE("before the first frame the live view says that there is none") {
  const auto view = open_view();
  for (const char* path : {"/frame.jpg", "/frame.exr", "/pixel?x=0&y=0", "/healthz"})
    CHECK(get(*view, path).status == 503);
  CHECK(get(*view, "/metrics").status == 200);
  CHECK_FALSE(json_at(*view, "/status.json").contains("frame"));
}

TEST_CASE("every path that docs/live-view.md lists is served, and an action to no GET") {
  ExampleControl control;
  const auto view = open_view(&control);
  REQUIRE(emit(*view, example_frame(6)).ok());
  std::istringstream page(test::text_of(HDRCAM_SOURCE_DIR "/docs/live-view.md"));
  int listed = 0;
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| `")) continue;
    const std::string path = line.substr(3, line.find('`', 3) - 3), action = "POST ";
    INFO(path);
    const bool acts = path.starts_with(action);
    CHECK(get(*view, acts ? path.substr(action.size()) : path).status == (acts ? 405 : 200));
    ++listed;
  }
  CHECK(listed >= 10);
}

TEST_CASE("the picture is the newest frame, at the exposure and in the look that each client asks for") {
  const auto view = open_view();
  REQUIRE(emit(*view, example_frame(6)).ok());
  REQUIRE(emit(*view, example_frame(7)).ok());
  const HttpReply reply = get(*view, "/frame.jpg");
  CHECK(reply.status == 200);
  CHECK(reply.headers.at("content-type") == "image/jpeg");
  CHECK(reply.headers.at("x-sequence") == "7");
  const auto mean_of = [&](const std::string& path) {
    const auto picture = decoded_jpeg(get(*view, path).body, 24, 32);
    double sum = 0;
    for (const std::uint16_t code : picture.samples()) sum += code;
    return sum / static_cast<double>(picture.size());
  };
  const double usual = mean_of("/frame.jpg");
  CHECK(mean_of("/frame.jpg?ev=2") > usual + 10);
  CHECK(mean_of("/frame.jpg?ev=-2") < usual - 10);
  std::set<std::string> looks;
  for (const char* look : {"tone", "false", "provenance"})
    looks.insert(get(*view, std::string("/frame.jpg?look=") + look).body);
  CHECK(looks.size() == 3);
  for (const char* wrong : {"/frame.jpg?look=x", "/frame.jpg?ev=nan", "/frame.jpg?ev=17", "/frame.jpg?ev=x"})
    CHECK(get(*view, wrong).status == 400);
}

TEST_CASE("the picture for HDR displays holds the light of the radiance in PQ and says so") {
  const auto view = open_view();
  const HdrFrame frame = example_frame(7);  // up to radiance 166, saturated at 16
  REQUIRE(emit(*view, frame).ok());
  const HttpReply reply = get(*view, "/frame.png?ev=-1");
  CHECK(reply.status == 200);
  CHECK(reply.headers.at("content-type") == "image/png");
  CHECK(reply.headers.at("x-sequence") == "7");
  const std::string cicp{"\0\0\0\4cICP\11\20\0\1", 12};  // BT.2020, PQ, RGB, full range
  CHECK(reply.body.find(cicp) < reply.body.find("IDAT"));

  const std::string path = sample::scratch_folder("light_picture") + "/x.png";
  require_done(write_whole(posix_storage(), path, std::as_bytes(std::span(reply.body))));
  const PngImage png = value_of(read_png(posix_storage(), path, 32, 24));
  REQUIRE(png.bits_per_sample == 16);
  const VideoOptions usual;
  const DisplayLight display(usual.white_nits / 2, usual.peak_nits, static_cast<double>(frame.white));
  Image<float> light(3, 24, 32);
  display.show(frame.radiance, light);
  double furthest = 0;  // codes of 10 bits
  for (std::size_t i = 0; i < light.size(); ++i)
    furthest = std::max(furthest, std::abs(png.samples.samples()[i] / 65535.0 * 1023 -
                                           1023 * pq_signal(static_cast<double>(light.samples()[i]))));
  CHECK(furthest < 1);
  CHECK(get(*view, "/frame.png?after=7").status == 204);
  CHECK(get(*view, "/frame.png?ev=x").status == 400);
  CHECK(get(*view, "/frame.png?ev=1").body != reply.body);
  CHECK(get(*view, "/frame.png?ev=-1").body == reply.body);

  // Wider than a page, and of another size than before.
  REQUIRE(emit(*view, example_frame(8, test::With::RadianceOnly, 40, FramePicture::kWidest_px * 2)).ok());
  const HttpReply smaller = get(*view, "/frame.png");
  require_done(write_whole(posix_storage(), path, std::as_bytes(std::span(smaller.body))));
  CHECK(read_png(posix_storage(), path, FramePicture::kWidest_px, 20).ok());
}

TEST_CASE("a client that has the newest picture gets no second copy of it") {
  const auto view = open_view();
  REQUIRE(emit(*view, example_frame(6)).ok());
  CHECK(get(*view, "/frame.jpg?after=6").status == 204);
  CHECK(get(*view, "/frame.jpg?after=5").status == 200);
  REQUIRE(emit(*view, example_frame(7)).ok());
  CHECK(get(*view, "/frame.jpg?after=6").headers.at("x-sequence") == "7");
}

TEST_CASE("a frame wider than a page is shown smaller, and its pixels are still those of the frame") {
  const auto view = open_view();
  const int cols = FramePicture::kWidest_px * 2, rows = 40;
  HdrFrame frame = example_frame(1, test::With::RadianceOnly, rows, cols);
  frame.radiance.at(0, rows - 1, cols - 1) = 77;
  REQUIRE(emit(*view, frame).ok());
  decoded_jpeg(get(*view, "/frame.jpg").body, rows / 2, FramePicture::kWidest_px);
  CHECK(json_at(*view, fmt::format("/pixel?x={}&y={}", cols - 1, rows - 1))["radiance"][0] == 77);
}

TEST_CASE("the radiance of a pixel is the value in the EXR file of the frame") {
  const auto view = open_view();
  HdrFrame frame = example_frame(3);
  frame.radiance.at(1, 5, 6) = 1e9f;  // more than the file holds
  REQUIRE(emit(*view, frame).ok());
  const HttpReply reply = get(*view, "/frame.exr");
  CHECK(reply.status == 200);
  CHECK(reply.headers.at("x-sequence") == "3");
  const ExrImage image = value_of(decode_exr(std::as_bytes(std::span(reply.body)), "the live frame"));
  int compared = 0;
  for (const auto& [x, y] : {std::pair(0, 0), {6, 5}, {31, 23}, {17, 9}}) {
    const json pixel = json_at(*view, fmt::format("/pixel?x={}&y={}", x, y));
    CHECK(pixel["sequence"] == 3);
    float rgb[3];
    for (int c = 0; c < 3; ++c) {
      rgb[c] = image.samples.at(image.find(exr_channel::kRadiance[c]).value(), y, x);
      CHECK(pixel["radiance"][static_cast<std::size_t>(c)].get<float>() == rgb[c]);
      ++compared;
    }
    const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    CHECK(pixel["stops"].get<double>() == Approx(std::log2(luminance)).margin(1e-4));
    CHECK(pixel["sigma"].get<double>() == Approx(0.01 * (1 + y)));
  }
  CHECK(compared == 12);
  for (const char* outside :
       {"/pixel", "/pixel?x=1", "/pixel?x=32&y=0", "/pixel?x=-1&y=0", "/pixel?x=1&y=1a"})
    CHECK(get(*view, outside).status == 400);
}

TEST_CASE("the status has the histogram, the exposures, the counters and the sources of the pixels") {
  ExampleControl control;
  const auto view = open_view(&control);
  HdrFrame bright = example_frame(1);
  bright.exposure = 4, bright.facts.exposure_s = 0.064;
  bright.radiance.fill(2.1f);  // a little above one stop
  REQUIRE(emit(*view, example_frame(0)).ok());
  REQUIRE(emit(*view, bright).ok());
  const json status = json_at(*view, "/status.json");
  const json& frame = status["frame"];
  CHECK(frame["sequence"] == 1);
  CHECK(frame["width"] == 32);
  const std::vector<int> bins = frame["histogram"];
  REQUIRE(bins.size() == kHistogramBins);
  const auto place = static_cast<std::size_t>((1 - kLeastStop) * kHistogramBins / (kMostStop - kLeastStop));
  CHECK(bins[place] == 24 * 32);
  REQUIRE(status["exposures"].size() == 2);
  CHECK(status["exposures"][0]["time_s"] == 0.004);
  CHECK(status["exposures"][0]["saturates_at_stops"].get<double>() == Approx(2));
  CHECK(status["exposures"][1]["saturates_at_stops"].get<double>() == Approx(-2));
  CHECK(status["counters"]["dropped.shed"] == 3);
  CHECK(status["frames"] == 2);
  const json scale = json_at(*view, "/scale.json");
  CHECK(scale["provenance"].size() == kProvenances);
  for (const json& look : scale["provenance"])
    CHECK(frame["provenance"].contains(look["key"].get<std::string>()));
}

TEST_CASE("the reference exposure saturates at 0 stops, not below zero") {
  const auto view = open_view();
  HdrFrame frame = example_frame(0);
  frame.exposure = 1;
  REQUIRE(emit(*view, frame).ok());
  const json status = json_at(*view, "/status.json");
  REQUIRE(status["exposures"].size() == 1);
  const auto stops = status["exposures"][0]["saturates_at_stops"].get<double>();
  CHECK(stops == 0);
  CHECK_FALSE(std::signbit(stops));
}

TEST_CASE("a recording whose name is not UTF-8 is shown with a mark in its place") {
  ExampleControl control;
  control.file = "caf\xe9.mkv";
  const auto view = open_view(&control);
  CHECK(json_at(*view, "/status.json")["recording"] == "caf\ufffd.mkv");
}

TEST_CASE("the metrics are Prometheus' text, with every drop under its reason") {
  ExampleControl control;
  const auto view = open_view(&control);
  HdrFrame frame = example_frame(0);
  FrameRecord record;
  record.stages_ms = {{"motion", 20}, {"state", 5}};
  record.total_ms = 25, record.latency_ms = 40;
  const ExposedFrame input;
  for (int i = 0; i < 3; ++i) REQUIRE(view->emit({frame, input, record}).ok());
  const auto values = parsed_metrics(get(*view, "/metrics").body);
  CHECK(values.at("hdrcam_frames_captured_total") == 12);
  CHECK(values.at("hdrcam_frames_emitted_total") == 7);
  CHECK(values.at("hdrcam_frames_dropped_total{reason=\"shed\"}") == 3);
  CHECK(values.at("hdrcam_frames_dropped_total{reason=\"unproved\"}") == 2);
  CHECK(values.at("hdrcam_exposures_total{verdict=\"proved\"}") == 9);
  CHECK(values.at("hdrcam_stage_seconds_total{stage=\"motion\"}") == Approx(0.06));
  CHECK(values.at("hdrcam_processing_seconds_total") == Approx(0.075));
  CHECK(values.at("hdrcam_latency_seconds") == Approx(0.04));
  CHECK(values.contains("hdrcam_newest_frame_age_seconds"));
  CHECK(values.at("hdrcam_build_info{version=\"" HDRCAM_VERSION "\"}") == 1);
}

TEST_CASE("a replay's metrics count the frames that were emitted") {
  const auto view = open_view();
  HdrFrame frame = example_frame(0);
  frame.facts.verdict = Verdict::Proved;
  REQUIRE(emit(*view, frame).ok());
  const auto values = parsed_metrics(get(*view, "/metrics").body);
  CHECK(values.at("hdrcam_frames_emitted_total") == 1);
  CHECK(values.at("hdrcam_exposures_total{verdict=\"proved\"}") == 1);
  CHECK_FALSE(values.contains("hdrcam_frames_captured_total"));
}

TEST_CASE("a run stands still after five seconds without a frame, a slow camera's after three frames") {
  CHECK_FALSE(is_stalled(4.9, 30));
  CHECK(is_stalled(5.1, 30));
  CHECK_FALSE(is_stalled(29, 0.1));
  CHECK(is_stalled(31, 0.1));
}

TEST_CASE("the live view is healthy while frames come") {
  const auto view = open_view();
  REQUIRE(emit(*view, example_frame(0)).ok());
  const HttpReply reply = get(*view, "/healthz");
  CHECK(reply.status == 200);
  CHECK(json::parse(reply.body)["newest_frame_age_s"].get<double>() >= 0);
}

TEST_CASE("recording and cycle are changed with the token alone, and refusals say why") {
  ExampleControl control;
  const auto view = open_view(&control);
  const auto post = [&](const std::string& path, const std::string& body, const std::string& token) {
    HttpClient client(view->address().port);
    client.send(
        fmt::format("POST {} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {}\r\n"
                    "Content-Length: {}\r\n\r\n{}",
                    path, token, body.size(), body));
    return client.receive();
  };
  const std::string on = R"({"on": true})", off = R"({"on": false})";
  CHECK(post("/record", on, "another token").status == 403);
  CHECK(control.file.empty());
  const HttpReply started = post("/record", on, kToken);
  CHECK(started.status == 200);
  CHECK(json::parse(started.body)["recording"] == "takes/001.mkv");
  CHECK(json_at(*view, "/status.json")["recording"] == "takes/001.mkv");
  CHECK(post("/record", on, kToken).status == 409);
  CHECK(post("/record", off, kToken).status == 200);
  CHECK(control.file.empty());
  CHECK(post("/record", off, kToken).status == 409);
  CHECK(post("/cycle", R"({"shutter": "1ms,8ms", "gain": "2"})", kToken).status == 200);
  CHECK(control.shutter == "1ms,8ms");
  CHECK(control.gain == "2");
  const HttpReply wrong = post("/cycle", R"({"shutter": "wrong"})", kToken);
  CHECK(wrong.status == 400);
  CHECK(json::parse(wrong.body)["error"] == "'wrong' is no exposure time");
  CHECK(post("/cycle", R"({"shutter": "late"})", kToken).status == 409);
  for (const char* body : {"", "on", "[]", R"({"on": 1})", R"({"on": "true"})"})
    CHECK(post("/record", body, kToken).status == 400);
  for (const auto& [path, body] : {std::pair("/record", R"({"on": false, "on": true})"),
                                   {"/cycle", R"({"shutter": "2ms,4ms", "shutter": "1ms"})"}}) {
    const HttpReply twice = post(path, body, kToken);
    CHECK(twice.status == 400);
    CHECK_THAT(json::parse(twice.body)["error"], Catch::Contains("twice"));
  }
  for (const auto& [path, body, refusal] :
       {std::tuple("/record", R"({"on": true, "name": "a.mkv"})", "the body names 'name'; it takes on"),
        {"/cycle", R"({"shutter": "2ms,4ms", "gian": "4"})",
         "the body names 'gian'; it takes shutter and gain"}}) {
    const HttpReply unknown = post(path, body, kToken);
    CHECK(unknown.status == 400);
    CHECK(json::parse(unknown.body)["error"] == refusal);
  }
  CHECK(control.file.empty());
  CHECK(control.shutter == "1ms,8ms");
  for (const char* body : {"{}", R"({"shutter": 1})", R"({"shutter": "1ms", "gain": 1})"})
    CHECK(post("/cycle", body, kToken).status == 400);
}

TEST_CASE("a replay has nothing to record and no cycle to change") {
  const auto view = open_view();
  HttpClient client(view->address().port);
  client.send(
      fmt::format("POST /record HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {}\r\n"
                  "Content-Length: 12\r\n\r\n{{\"on\": true}}",
                  kToken));
  CHECK(client.receive().status == 409);
}

TEST_CASE("an invalid address and a token that is too short end the run before it begins") {
  require_error(LiveView::open("here", {}, nullptr), ErrorCode::Invalid);
  require_error(LiveView::open("127.0.0.1:0", {.token = "short"}, nullptr), ErrorCode::Invalid);
  const auto view = open_view();
  require_error(LiveView::open(to_text(view->address()), {}, nullptr), ErrorCode::Busy);
}

TEST_CASE("twenty clients that look and five that hardly read do not hold up the emission") {
  const auto view = open_view();
  LiveView& sink = *view;
  const std::uint16_t port = view->address().port;
  const int rows = 240, cols = 320;
  HdrFrame frame = example_frame(0, test::With::RadianceOnly, rows, cols);
  REQUIRE(emit(sink, frame).ok());

  std::atomic<bool> ending{false};
  std::atomic<int> pictures{0};
  std::vector<std::thread> clients;
  for (int i = 0; i < 20; ++i)
    clients.emplace_back([&, i] {
      HttpClient client(port);
      while (!ending) pictures += client.get(fmt::format("/frame.jpg?ev={}", i % 4)).status == 200 ? 1 : 0;
    });
  std::vector<HttpClient> slow;
  for (int i = 0; i < 5; ++i) {
    slow.emplace_back(port);
    for (int j = 0; j < 20; ++j) slow.back().send(test::get_request("/frame.exr"));
  }
  // For how long the emitting thread was held at most. On a machine that is busy with other things a thread
  // may wait for a processor; a client that held it up would do so until it is cut off.
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kMuch = HttpLimits().patience / 2;
  Clock::duration longest{};
  for (std::uint64_t i = 1; i <= 60; ++i) {
    frame.facts.sequence = i;
    const auto begin = Clock::now();
    REQUIRE(emit(sink, frame).ok());
    longest = std::max(longest, Clock::now() - begin);
    if (i % 20 == 0)
      for (HttpClient& client : slow) CHECK(client.read_byte());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(becomes_true([&] { return pictures > 20; }));
  ending = true;
  for (std::thread& client : clients) client.join();
  CHECK(longest < kMuch);
  require_done(sink.finish());
}

TEST_CASE("frames are emitted while an answer about an earlier one is being made") {
  HeldControl control;
  const auto view = open_view(&control);
  REQUIRE(emit(*view, example_frame(0)).ok());
  auto status = std::async(std::launch::async, [&] { return get(*view, "/status.json"); });
  REQUIRE(becomes_true([&] { return control.asked.load(); }));
  for (std::uint64_t i = 1; i <= 10; ++i) REQUIRE(emit(*view, example_frame(i)).ok());
  control.released = true;
  CHECK(json::parse(status.get().body)["frame"]["sequence"] == 0);
  CHECK_FALSE(control.gave_up);  // else the emission went on only after it
  CHECK(json_at(*view, "/status.json")["frame"]["sequence"] == 10);
}

#include "firmware_host/sinks/live_view/live_view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "firmware_host/sinks/exr_sequence.h"
#include "firmware_host/sinks/provenance_palette.h"
#include "firmware_host/terminal.h"
#include "firmware_host/web/live_page.h"
#include "hal/core/counted.h"
#include "hal/core/json_text.h"
#include "hal/core/parse_number.h"

namespace hdrcam {
namespace {

constexpr std::size_t kFewestTokenCharacters = 8;

template <class T>
std::optional<T> number_in(const HttpRequest& request, std::string_view name) {
  const auto text = request.query.find(name);
  if (text == request.query.end()) return std::nullopt;
  return parse_number<T>(text->second);
}

// Stops brighter; 0 where none are asked for. Errors: Invalid where they are none.
Result<double> exposure_in(const HttpRequest& request) {
  constexpr double kMost = 16;
  if (!request.query.contains("ev")) return 0.0;
  const auto ev = number_in<double>(request, "ev");
  if (ev && std::abs(*ev) <= kMost) return *ev;
  return Error{ErrorCode::Invalid, fmt::format("ev is a number of stops, -{0:g} to {0:g}", kMost)};
}

// Errors: Invalid for a look that is none.
Result<PictureRequest> picture_in(const HttpRequest& request) {
  PictureRequest wanted;
  if (const auto look = request.query.find("look"); look != request.query.end()) {
    const auto known = picture_look(look->second);
    if (!known) return Error{ErrorCode::Invalid, "look is tone, false or provenance"};
    wanted.look = *known;
  }
  wanted.exposure_ev = TRY(exposure_in(request));
  return wanted;
}

HttpAnswer no_frame() { return http_error(503, "no frame has been emitted yet"); }

HttpAnswer answer_of(const Error& error) {
  switch (error.code) {
    case ErrorCode::Invalid:
    case ErrorCode::BadExposure:
      return http_error(400, error.message);
    case ErrorCode::Busy:
    case ErrorCode::NotFound:
    case ErrorCode::Unsupported:
    case ErrorCode::Interrupted:
      return http_error(409, error.message);
    default:
      return http_error(500, error.message);
  }
}

// Of a picture or file of a frame: Busy where clients read too many others.
HttpAnswer no_picture(const Error& error) {
  return error.code == ErrorCode::Busy ? http_error(503, error.message) : answer_of(error);
}

HttpAnswer no_camera() { return http_error(409, "this run has no camera"); }

// The JSON object in a body; null where there is none. Errors: Invalid where it names a key twice, or one
// that is not among these.
Result<nlohmann::json> object_in(const HttpRequest& request, const std::vector<std::string>& keys) {
  auto json = parsed_json<nlohmann::json>(request.body);
  if (!json.is_object()) return nlohmann::json();
  if (const auto key = repeated_key<nlohmann::json>(request.body))
    return Error{ErrorCode::Invalid, fmt::format("the body names '{}' twice; name it once", *key)};
  for (const auto& member : json.items())
    if (std::ranges::find(keys, member.key()) == keys.end())
      return Error{ErrorCode::Invalid,
                   fmt::format("the body names '{}'; it takes {}", member.key(), fmt::join(keys, " and "))};
  return json;
}

HttpAnswer json_answer(const std::string& text) { return {.body = http_body(text)}; }

std::pair<const char*, std::string> sequence_header(const ShownFrame& frame) {
  return {"X-Sequence", std::to_string(frame.hdr.facts.sequence)};
}

}  // namespace

Result<void> check_http_token(std::string_view token) {
  if (token.empty() || token.size() >= kFewestTokenCharacters) return {};
  return Error{ErrorCode::Invalid, fmt::format("--http-token has {}; give {} or more, or none",
                                               counted(token.size(), "character"), kFewestTokenCharacters)};
}

Result<std::unique_ptr<LiveView>> LiveView::open(const std::string& address, const LiveViewOptions& options,
                                                 RunControl* control) {
  const HttpAddress wanted = TRY(parse_http_address(address));
  TRY(check_http_token(options.token));
  std::unique_ptr<LiveView> view(new LiveView(options, control));
  const std::string token = options.token.empty() ? random_token() : options.token;
  view->server_ = TRY(HttpServer::open(wanted, token, view->routes(), {}));
  const std::string place = to_text(view->address());
  const bool has_actions = control != nullptr;
  remark("live view: http://{}/{}\n", place, has_actions && options.token.empty() ? "#token=" + token : "");
  if (!is_loopback(wanted))
    remark("warning: whoever reaches {} sees the pictures; {}127.0.0.1 keeps them on this machine\n", place,
           has_actions ? "only actions need the token; " : "");
  return view;
}

Result<void> LiveView::emit(const EmittedFrame& frame) {
  if (!start_) start_ = frame.hdr.facts.timestamp;
  newest_.put(frame);
  tally_.count(frame);
  return {};
}

Result<void> LiveView::finish() { return server_.reset(), Result<void>{}; }

std::vector<HttpRoute> LiveView::routes() {
  std::vector<HttpRoute> routes;
  for (const PagePart& part : live_page_parts())
    routes.push_back({part.path, HttpAccess::Open, [body = http_body(part.text), &part](const HttpRequest&) {
                        return HttpAnswer{.type = part.type, .body = body};
                      }});
  const auto add = [&](const char* path, HttpAnswer (LiveView::*answer)(const HttpRequest&),
                       HttpAccess access = HttpAccess::Open) {
    routes.push_back(
        {path, access, [this, answer](const HttpRequest& request) { return (this->*answer)(request); }});
  };
  add("/frame.jpg", &LiveView::picture);
  add("/frame.png", &LiveView::light);
  add("/frame.exr", &LiveView::exr);
  add("/pixel", &LiveView::pixel);
  add("/status.json", &LiveView::status);
  add("/scale.json", &LiveView::scale);
  add("/metrics", &LiveView::metrics);
  add("/healthz", &LiveView::health);
  add("/record", &LiveView::record, HttpAccess::Token);
  add("/cycle", &LiveView::change_cycle, HttpAccess::Token);
  return routes;
}

template <class Encode>
HttpAnswer LiveView::newest_picture(const HttpRequest& request, const char* type, const Encode& encode) {
  const ShownFrame* const frame = newest_.read();
  if (frame == nullptr) return no_frame();
  if (number_in<std::uint64_t>(request, "after") == frame->hdr.facts.sequence) return {.status = 204};
  const Result<HttpBody> picture = encode(*frame);
  if (!picture) return no_picture(picture.error());
  return {.type = type, .body = picture.value(), .headers = {sequence_header(*frame)}};
}

HttpAnswer LiveView::picture(const HttpRequest& request) {
  return newest_picture(request, "image/jpeg", [&](const ShownFrame& frame) -> Result<HttpBody> {
    return pictures_.jpeg(frame, TRY(picture_in(request)));
  });
}

HttpAnswer LiveView::light(const HttpRequest& request) {
  return newest_picture(request, "image/png", [&](const ShownFrame& frame) -> Result<HttpBody> {
    const FileKey key{frame.hdr.facts.sequence, TRY(exposure_in(request))};
    return light_pictures_.share(key, [&] { return lights_.png(frame, key.exposure_ev); });
  });
}

HttpAnswer LiveView::exr(const HttpRequest&) {
  const ShownFrame* const frame = newest_.read();
  if (frame == nullptr) return no_frame();
  const std::uint64_t sequence = frame->hdr.facts.sequence;
  const auto file = exr_files_.share({sequence}, [&]() -> Result<HttpBody> {
    ExrSequenceOptions options;
    options.layers.confidence = options.layers.provenance = true;
    options.compression = options_.compression;
    options.framerate_hz = options_.framerate_hz;
    // An Instant that the first frame wrote before it was the newest.
    auto bytes = TRY(encode_frame(frame->hdr, options, *start_));
    return HttpBody(std::make_shared<const std::vector<std::byte>>(std::move(bytes)));
  });
  if (!file) return no_picture(file.error());
  const std::string name = fmt::format("attachment; filename=\"{:06}.exr\"", sequence);
  return {.type = "image/x-exr",
          .body = file.value(),
          .headers = {sequence_header(*frame), {"Content-Disposition", name}}};
}

HttpAnswer LiveView::pixel(const HttpRequest& request) {
  const ShownFrame* const frame = newest_.read();
  if (frame == nullptr) return no_frame();
  const auto x = number_in<int>(request, "x"), y = number_in<int>(request, "y");
  const Image<float>& radiance = frame->hdr.radiance;
  if (!x || !y || *x < 0 || *y < 0 || *x >= radiance.cols() || *y >= radiance.rows())
    return http_error(400, fmt::format("x and y are a pixel of {}x{}", radiance.cols(), radiance.rows()));
  return json_answer(pixel_json(*frame, *x, *y));
}

HttpAnswer LiveView::record(const HttpRequest& request) {
  if (control_ == nullptr) return no_camera();
  const Result<nlohmann::json> sent = object_in(request, {"on"});
  if (!sent) return answer_of(sent.error());
  const nlohmann::json& body = sent.value();
  if (!body.contains("on") || !body["on"].is_boolean())
    return http_error(400, "send {\"on\": true} or {\"on\": false}");
  if (body["on"].get<bool>()) {
    const Result<std::string> file = control_->start_recording();
    if (!file) return answer_of(file.error());
  } else if (const Result<void> stopped = control_->stop_recording(); !stopped) {
    return answer_of(stopped.error());
  }
  return json_answer(json_text(nlohmann::json{{"recording", control_->recording()}}));
}

HttpAnswer LiveView::change_cycle(const HttpRequest& request) {
  if (control_ == nullptr) return no_camera();
  const Result<nlohmann::json> sent = object_in(request, {"shutter", "gain"});
  if (!sent) return answer_of(sent.error());
  const nlohmann::json& body = sent.value();
  if (!body.contains("shutter") || !body["shutter"].is_string() ||
      (body.contains("gain") && !body["gain"].is_string()))
    return http_error(400, "send {\"shutter\": \"1ms,4ms,16ms\", \"gain\": \"1\"}; gain may be missing");
  const Result<void> changed =
      control_->change_cycle(body["shutter"].get<std::string>(), body.value("gain", std::string()));
  return changed ? json_answer("{}") : answer_of(changed.error());
}

LiveFigures LiveView::figures() {
  LiveFigures figures{newest_.read(), tally_.figures()};
  if (control_ != nullptr) figures.counters = control_->counters(), figures.recording = control_->recording();
  return figures;
}

HttpAnswer LiveView::status(const HttpRequest&) { return json_answer(status_json(figures())); }

HttpAnswer LiveView::metrics(const HttpRequest&) {
  return {.type = "text/plain; version=0.0.4; charset=utf-8", .body = http_body(prometheus_text(figures()))};
}

// What does not change during a run: the colours of the looks.
HttpAnswer LiveView::scale(const HttpRequest&) {
  constexpr int kSteps = 64;
  const auto css = [](Rgb colour) { return fmt::format("rgb({},{},{})", colour.r, colour.g, colour.b); };
  nlohmann::ordered_json json{{"false_colours", nlohmann::json::array()},
                              {"provenance", nlohmann::json::array()}};
  for (const Rgb colour : false_colour_scale(kSteps)) json["false_colours"].push_back(css(colour));
  for (const ProvenanceLook& look : kProvenanceLooks)
    json["provenance"].push_back({{"key", look.key}, {"name", look.name}, {"colour", css(look.colour)}});
  return json_answer(json_text(json));
}

bool is_stalled(double newest_frame_age_s, double framerate_hz) {
  constexpr double kLongest_s = 5, kFrames = 3;  // without a frame, for longer than both
  return newest_frame_age_s > std::max(kLongest_s, kFrames / framerate_hz);
}

HttpAnswer LiveView::health(const HttpRequest&) {
  const EmissionFigures emission = tally_.figures();
  if (emission.frames == 0) return no_frame();
  const std::chrono::duration<double> age = EmissionFigures::Clock::now() - emission.newest;
  if (is_stalled(age.count(), options_.framerate_hz))
    return http_error(503, fmt::format("the newest frame is {:.1f} s old", age.count()));
  return json_answer(json_text(nlohmann::json{{"newest_frame_age_s", age.count()}}));
}

}  // namespace hdrcam

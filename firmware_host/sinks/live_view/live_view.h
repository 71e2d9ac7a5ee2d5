// The run in a browser: --http 127.0.0.1:8080. A sink that keeps the newest frame and its figures, and a
// server (web/http_server.h) that shows them to whoever asks; docs/live-view.md lists what it answers. The
// emitting thread copies a frame and nothing more: pictures and histograms are made on the server's thread,
// and only when they are asked for. Thread-bound; its server has a thread of its own.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware_host/sinks/frame_sink.h"
#include "firmware_host/sinks/live_view/emission_tally.h"
#include "firmware_host/sinks/live_view/frame_picture.h"
#include "firmware_host/sinks/live_view/held_files.h"
#include "firmware_host/sinks/live_view/light_picture.h"
#include "firmware_host/sinks/live_view/live_figures.h"
#include "firmware_host/sinks/live_view/newest_frame.h"
#include "firmware_host/sinks/run_control.h"
#include "firmware_host/web/http_server.h"
#include "render/exr.h"

namespace hdrcam {

struct LiveViewOptions {
  std::string token;                               // for actions; "": made at the start and printed
  ExrCompression compression = kUsualCompression;  // of /frame.exr
  double framerate_hz = 30;                        // of the camera
  VideoOptions video = {};                         // how bright HDR pictures are
};

// A token that somebody gives; "" is none. Errors: Invalid where it is too short.
Result<void> check_http_token(std::string_view token);

// Whether a run whose newest frame is so old stands still.
bool is_stalled(double newest_frame_age_s, double framerate_hz);

class LiveView : public FrameSink {
 public:
  // address: "127.0.0.1:8080" (web/http_address.h). control: of a run on a camera, else null; it outlives the
  // sink. Tells the user where the page is. Errors: those of HttpServer::open; Invalid for an address that is
  // none, or a token that is too short.
  static Result<std::unique_ptr<LiveView>> open(const std::string& address, const LiveViewOptions& options,
                                                RunControl* control);

  Result<void> emit(const EmittedFrame& frame) override;
  Result<void> finish() override;

  // With the port that it has got; until finish().
  const HttpAddress& address() const { return server_->address(); }

 private:
  LiveView(LiveViewOptions options, RunControl* control)
      : options_(std::move(options)), control_(control), lights_(options_.video) {}

  std::vector<HttpRoute> routes();
  // Of the newest frame, unless the request names it as the one that it has. encode: of that frame.
  template <class Encode>
  HttpAnswer newest_picture(const HttpRequest& request, const char* type, const Encode& encode);
  HttpAnswer picture(const HttpRequest& request);
  HttpAnswer light(const HttpRequest& request);
  HttpAnswer exr(const HttpRequest& request);
  HttpAnswer pixel(const HttpRequest& request);
  HttpAnswer status(const HttpRequest& request);
  HttpAnswer scale(const HttpRequest& request);
  HttpAnswer metrics(const HttpRequest& request);
  HttpAnswer health(const HttpRequest& request);
  HttpAnswer record(const HttpRequest& request);
  HttpAnswer change_cycle(const HttpRequest& request);
  LiveFigures figures();

  const LiveViewOptions options_;
  RunControl* const control_;
  NewestFrame newest_;
  EmissionTally tally_;
  std::optional<Instant> start_;        // of the run; written before the first frame is put
  FramePicture pictures_;               // of the server's thread
  LightPicture lights_;                 // of the server's thread
  HeldFiles light_pictures_{16};        // of the server's thread: 50 MB of 16:9
  HeldFiles exr_files_{4, 192 << 20};   // of the server's thread: two of 4K, uncompressed
  std::unique_ptr<HttpServer> server_;  // last: its thread uses all of them
};

}  // namespace hdrcam

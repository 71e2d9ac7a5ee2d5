// A run on a camera: one thread captures, one records, the caller's fits.
//
//   camera -> CaptureStage -> FramePool --+--> Recorder (every frame) ---> recording
//             (its own thread)            '--> FitInbox (whole cycles) --> the caller: pipeline, sinks
//
// Capture waits for the camera only. A slow consumer drops frames in a declared order: the fit sheds whole
// cycles (fit_inbox.h); when the disk is so slow that the pool is full, the newest frame is dropped before
// recorder and fit, and the next one carries kFrameAfterDrop. The recorder never drops. Every captured frame
// is accounted for at every moment (LiveCounters). Thread-bound, except counters(), learn_response(),
// follow() and what a person may change.
#pragma once

#include <array>
#include <atomic>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "capture/capture_stage.h"
#include "firmware_host/live/fit_inbox.h"
#include "firmware_host/live/frame_pool.h"
#include "firmware_host/live/recorder.h"

namespace hdrcam {

// What becomes of the frames of a camera: HDR frames and a recording, or a recording alone.
enum class LiveWork { Fit, RecordOnly };

struct LiveOptions {
  std::uint64_t frames = 0;               // to capture; 0: until stopped
  Duration timeout{0};                    // of the run; 0: none
  std::size_t memory_bytes = 256U << 20;  // for queued frames, at least kFewestFrames of them
  LiveWork work = LiveWork::Fit;
  Trace* trace = nullptr;  // gets capture and recording; null, or outlives the session

  static constexpr int kFewestFrames = 12, kMostFrames = 4096;
};

// Frames by outcome. At every moment captured() = emitted + dropped() + in_fit where the run fits, and
// captured() = recorded + not_recorded() + to_record + not_requested; in_fit and to_record are 0 at the end.
struct LiveCounters {
  CaptureCounters camera;        // camera.captured = camera.emitted + camera.dropped()
  bool ended = false;            // no further frame is captured
  std::uint64_t pool_full = 0;   // dropped: the pool was full
  std::uint64_t shed = 0;        // dropped: the fit was slower than the camera
  std::uint64_t unproved = 0;    // dropped: kept out of the fit, because its exposure is not certain
  std::uint64_t left_out = 0;    // dropped: in the state, and not emitted, to hold the deadline
  std::uint64_t unfinished = 0;  // dropped: the run ended with an error before the frame was emitted
  std::uint64_t emitted = 0;     // became an HDR frame
  std::uint64_t in_fit = 0;      // queued for the fit, or in it
  std::uint64_t taken = 0;       // by the fit, in all
  std::uint64_t recorded = 0, to_record = 0;
  std::uint64_t in_takes = 0;       // of those recorded: in recordings that were started during the run
  std::uint64_t unwritten = 0;      // not recorded: the recording had failed
  std::uint64_t not_requested = 0;  // came while nobody wanted a recording
  // From a frame's arrival to its emission: the last one, the longest.
  Duration latency{0}, longest_latency{0};
  Duration first_frame{0};  // from the arrival of the first captured frame to the first emission

  std::uint64_t captured() const { return camera.captured; }
  // Frames that wait until the fit takes them.
  std::uint64_t waiting() const { return in_fit + emitted + left_out + unfinished - taken; }
  std::uint64_t dropped() const {
    return camera.dropped() + pool_full + shed + unproved + left_out + unfinished;
  }
  std::uint64_t not_recorded() const { return camera.dropped() + pool_full + unwritten; }
};

// Why a run ended without an error: all frames, all the time, or the user stopped it.
enum class LiveEnd { Frames, Timeout, Stopped };

class LiveSession {
 public:
  // The camera and its stage belong to the session until it is finished. recording: may be null.
  LiveSession(CaptureStage& capture, std::unique_ptr<RecordingWriter> recording, const LiveOptions& options);
  ~LiveSession();  // like finish(), but without its result

  // Capture ends between two frames, however busy the fit is: all frames came, the time is up, `stop` was
  // set, or something failed. `stop` outlives the session. Errors: those of starting the camera.
  Result<void> start(const std::atomic<bool>& stop);
  // The next frame for the fit; empty when capture has ended and the fit has had its frames (finish() returns
  // the error, if any). `tick` is called meanwhile, at least ten times a second, to show progress. A run that
  // only records returns no frames: the call lasts as long as it.
  FrameShare next(const std::function<void()>& tick);
  // The frames that wait behind that one.
  Backlog backlog() const { return inbox_.backlog(); }
  // Records that a frame became an HDR frame. Returns its latency since its arrival.
  Duration emitted(std::uint64_t sequence);
  // Records that a frame that the fit took does not become one.
  void left_out();
  // Stops the camera, if it still runs, and completes the recording. Errors: those of the camera (Unplugged,
  // Timeout...) or of the recording that ended the run; frames captured before are recorded even then. What
  // capture or recording threw on its thread, such as std::bad_alloc, ends the run likewise and is thrown
  // here.
  Result<LiveEnd> finish();
  // Once it is finished: after how many whole frames the recording that it was given failed; none where it
  // did not.
  std::optional<std::uint64_t> recording_cut_after() const;
  // Likewise: whether the last one that a person started failed.
  bool last_take_failed() const;

  // Takes the camera's response, for the proof of later frames (CaptureStage::learn_response).
  void learn_response(const PhotometricResponse::Curve& inverse, const BlackLevel& black_level);
  // Later requests follow the cycle that the fit asks for (CaptureStage::change_cycle). Errors: those of
  // CaptureStage::schedule_of; the cycle before goes on.
  Result<void> follow(const std::vector<Exposure>& cycle);
  LiveCounters counters() const;

  // What a person may change while it runs: any thread, one at a time.
  // Errors: Busy while a recording is open or is being completed; that of the last recording, which also ends
  // the run; Interrupted where it ends.
  Result<void> may_record() const;
  // Records from the next frame on. Errors: those of may_record(); Io where the system starts no thread for
  // it.
  Result<void> start_recording(std::unique_ptr<RecordingWriter> recording);
  // Takes no more frames; the recording is completed in the background. Errors: NotFound where none is open.
  Result<void> stop_recording();
  // Later requests follow this cycle of as many exposures. Errors: those of CaptureStage::change_cycle;
  // Invalid for another number of exposures; Timeout where no frame arrives; Interrupted where the run ends.
  // What the change throws on the capturing thread, such as std::bad_alloc, is thrown here alone: the run
  // goes on with the cycle before.
  Result<void> change_cycle(std::vector<Exposure> cycle);

 private:
  struct LearnedResponse {
    PhotometricResponse::Curve inverse{};
    BlackLevel black_level;
  };
  struct Arrival {
    std::uint64_t sequence = 0;
    Instant at;
  };
  struct WantedCycle {
    std::vector<Exposure> exposures;
    std::promise<Result<void>> done;
  };
  enum class StartedBy { Run, Person };

  void capture_frames(const std::atomic<bool>& stop);
  Result<void> capture_until_end(const std::atomic<bool>& stop);
  Result<void> capture_one(const std::atomic<bool>& stop);
  Result<void> next_frame(CapturedFrame& captured, const std::atomic<bool>& stop);
  Result<void> may_record_under_lock() const;
  Result<void> finish_recordings();
  void end();
  void count_camera();
  void hand_on(FrameShare frame);
  void count_shed(int frames);
  void take_feedback();
  void take_cycle();
  Result<void> adopt_cycle(std::span<const Exposure> cycle);
  std::shared_ptr<Recorder> recorder_of(std::unique_ptr<RecordingWriter> recording, StartedBy started_by);
  std::optional<LiveEnd> reason_to_end(const std::atomic<bool>& stop) const;
  bool is_to_end(const std::atomic<bool>& stop) const;

  CaptureStage& capture_;
  const LiveOptions options_;
  FramePool pool_;
  FitInbox inbox_;

  std::thread thread_;  // the members that it alone uses:
  CapturedFrame scratch_;
  int lost_here_ = 0;  // frames dropped for lack of room since the last stored one

  std::atomic<bool> ending_{false};  // ends after the frame that it waits for
  Instant begin_;
  bool finished_ = false;
  LiveEnd why_ = LiveEnd::Frames;  // with the next two, the capturing thread's, until it is joined
  Result<void> capture_result_;
  std::exception_ptr thrown_;

  mutable std::mutex mutex_;  // guards the members below
  LiveCounters counters_;
  static constexpr std::size_t kArrivals = 64;  // more than the fit holds of frames that it has not emitted
  std::array<Arrival, kArrivals> arrivals_{};   // a ring, of the frames that the fit took last
  std::size_t arrival_count_ = 0;               // of all that it took
  std::optional<Instant> first_arrival_;
  std::optional<LearnedResponse> learned_;
  std::optional<std::vector<Exposure>> followed_;  // the cycle that the fit asked for last
  std::optional<WantedCycle> wanted_cycle_;
  std::shared_ptr<Recorder> recorder_, completing_;  // completing_: takes no more frames
  std::shared_ptr<const Recorder> own_;              // of the recording that the session was given
};

}  // namespace hdrcam

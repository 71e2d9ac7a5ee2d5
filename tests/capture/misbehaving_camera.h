// A camera for the tests of capture/: a sensor whose exposure really changes its pictures, and which can
// simulate every fault of a real one. It knows the true exposure of each frame that it delivers. Time is
// virtual.
#pragma once

#include <deque>
#include <optional>
#include <random>
#include <vector>

#include "capture/exposure.h"
#include "hal/camera.h"
#include "hal/sync_line.h"

namespace hdrcam::test {

// The conversion from light to codes.
enum class SensorKind {
  RawBayer10,  // linear, black level 64 of 1023
  Gamma8,      // processed grey, x^(1/2.2)
  Film8,       // processed grey, an S-shaped curve unlike any power
};

// Each is a probability per frame unless stated otherwise.
struct SensorFaults {
  double drop = 0;                               // the frame never comes
  int drop_run = 1;                              // and as many in a row
  bool hide_drops = false;                       // the sequence number does not count them
  bool freeze_time = false;                      // nor does the timestamp (a driver that invents it)
  double damage = 0;                             // pixels incomplete, and reported so
  double report_missing = 0, report_late = 0;    // late: the report is that of the previous frame
  double cookie_doubled = 0;                     // the same request completes again
  double exposure_late = 0, exposure_early = 0;  // this frame has its neighbour's exposure
  double exposure_clipped = 0;                   // this frame's is cut off at clip_time
  Duration clip_time{10'000'000};
  bool clips_always = false;   // the sensor cannot do longer ones and does not report it
  bool never_applied = false;  // the exposure stays that of the first frame
  double written_late = 0;     // a control is written after its frame began, and the driver reports it
  double slip = 0;             // from here on every exposure acts one frame earlier than requested
  double strobe_lost = 0;
};

struct SensorSettings {
  SensorKind kind = SensorKind::RawBayer10;
  int width = 160, height = 120;
  bool per_request = true;  // otherwise controls act `latency` frames after their own
  int latency = 0;          // frames: exposure
  int gain_latency = 0;
  bool reports = false, embedded = false;
  bool states_black = false;        // each frame states the black level of its raw codes, and nobody else
  Duration kept_frame{33'333'333};  // from frame to frame, whatever was agreed
  Duration strobe_offset{0};        // of the pulse's rise against the timestamp
  double pan_px = 2;                // per frame
  bool object = true;               // a disc that moves across
  double light_walk = 0.01;         // rms change of the light per frame, ln
  double cut = 0;                   // probability per frame of another scene
  double least_gain = 1;            // analogue
  double key = 1;                   // radiance of the median against the saturation of 4 ms
  unsigned seed = 1;
};

class MisbehavingCamera : public Camera, private BufferLease::Owner {
 public:
  static constexpr Duration kFrame{33'333'333};

  MisbehavingCamera(const SensorSettings& settings, const SensorFaults& faults);

  const CameraCapabilities& capabilities() const override { return capabilities_; }
  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override;
  Result<void> start() override;
  Result<void> queue(const ExposureRequest& request) override;
  Result<CapturedBuffer> wait(Duration timeout) override;
  Result<void> stop() override;

  // Of the last delivered buffer: ln of time x gain as the sensor applied them.
  double truth() const { return truth_; }
  // Edges of the strobe line until now, oldest first.
  std::deque<Edge>& edges() { return edges_; }
  std::uint64_t frames() const { return frame_; }

 private:
  struct Controls {
    Duration time{4'000'000};
    double gain = 1;
  };
  void give_back(int index) override;
  bool happens(double probability);
  Controls asked_for(const ExposureRequest& request) const {
    return {request.exposure, request.analogue_gain};
  }
  void write_controls(const ExposureRequest& request, bool late);
  Controls applied(std::size_t request);
  void expose_frame(const Controls& controls, Instant begin);
  void paint(double product);
  void light_row(int y, std::vector<float>& row) const;
  float value_of(float x) const;  // relative exposure 0..1 -> 0..1

  SensorSettings settings_;
  SensorFaults faults_;
  CameraCapabilities capabilities_;
  StreamMode mode_;
  std::mt19937 random_;
  std::vector<float> texture_, noise_, row_, values_;
  std::vector<std::byte> pixels_;
  std::deque<ExposureRequest> queued_;
  std::deque<ExposureRequest> history_;  // every request, for controls that slipped
  std::uint64_t first_in_history_ = 0, completed_ = 0;
  std::vector<Controls> schedule_of_frame_;  // what frame i shows, for controls that act when queued
  int buffers_ = 0, leased_ = 0, slipped_ = 0;
  bool running_ = false;
  std::uint64_t frame_ = 0, sequence_ = 0, last_cookie_ = 0, edge_sequence_ = 0;
  Instant clock_;
  double light_ = 0, scene_x_ = 0, scene_y_ = 0, truth_ = 0;
  std::optional<Controls> first_, before_;
  std::deque<Edge> edges_;
};

// The strobe line of that sensor.
class StrobeModel : public SyncLine {
 public:
  explicit StrobeModel(MisbehavingCamera& sensor) : sensor_(sensor) {}
  Result<Edge> wait_edge(Duration timeout) override;
  void close() override {}

 private:
  MisbehavingCamera& sensor_;
};

}  // namespace hdrcam::test

// A camera that renders a scene (simulated_sensor.h) as a sensor with delayed controls would deliver it. The
// sensor runs freely: frame n starts n frame durations after the start, whether or not a buffer is queued.
// The request at the head of the queue is latched then, its controls act some frames later, and its buffer is
// that frame's; of a frame that is lost the controls are written all the same, and the request stays due. A
// frame without a request is lost, which the sequence number shows. Timestamps mark the start of exposure.
// wait() computes the pixels, on the waiting thread and a pool, so that no thread runs in between.
//
// With a trigger the sensor does not run freely: each pulse on that wire is a frame, and no pulse is none. In
// external trigger mode the pulse's width is the exposure, whatever is requested. A pulse that begins before
// the frame before it is read out is ignored, as sensors do.
//
// A test sees the truth and injects faults through sim_bench.h. Thread-bound, except stop() and the return of
// buffers; no allocation per frame after the first.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "hal/camera.h"
#include "hal/sim/effects/delayed_control.h"
#include "hal/sim/simulated_sensor.h"
#include "hal/sim/simulated_sync_line.h"
#include "hal/sim/stream_effects.h"
#include "hal/trigger_line.h"

namespace hdrcam {

class SimBench;

// The wires of a simulated sensor; they outlive it.
struct SimulatedWiring {
  SimulatedWire* strobe = nullptr;  // high during an exposure; may be null
  SimulatedWire* trigger = nullptr;
  TriggerMode mode = TriggerMode::Off;  // Off: the sensor runs freely
};

class SimulatedCamera : public Camera, private BufferLease::Owner {
 public:
  // threads: for rendering, 1..
  SimulatedCamera(const Simulation& simulation, SimTime time, int threads,
                  const SimulatedWiring& wiring = {});
  ~SimulatedCamera() override;

  const CameraCapabilities& capabilities() const override { return capabilities_; }
  Result<StreamMode> configure(const StreamMode& wanted, int buffers) override;
  Result<void> start() override;
  Result<void> queue(const ExposureRequest& request) override;
  Result<CapturedBuffer> wait(Duration timeout) override;
  Result<void> stop() override;

  // The scene and its effects, once configured.
  const SimulatedSensor* sensor() const { return sensor_.get(); }

 private:
  friend class SimBench;
  struct Request {
    ExposureRequest asked;
    int buffer = -1;
  };
  // The facts that a completed buffer reports.
  struct Report {
    std::uint64_t cookie = 0;
    Duration exposure{0};
    double gain = 1;
  };
  struct Frame {
    std::uint64_t sequence = 0;
    int buffer = -1;
    Duration exposure{0};
    double gain = 1;
    Instant begin, stamp, ready;  // ready: read out
    Report report;
    bool reported = true;
  };
  // First in, first out, of a size that is known at configure().
  template <class T>
  class Ring {
   public:
    void reset(std::size_t capacity) { slots_.assign(capacity, T{}), begin_ = size_ = 0; }
    bool empty() const { return size_ == 0; }
    std::size_t size() const { return size_; }
    void push(const T& item) {
      HDRCAM_CHECK_LT(size_, slots_.size());
      slots_[(begin_ + size_++) % slots_.size()] = item;
    }
    T pop() {
      HDRCAM_CHECK_GT(size_, 0u);
      T item = slots_[begin_];
      begin_ = (begin_ + 1) % slots_.size(), --size_;
      return item;
    }
    const T& front() const { return slots_[begin_]; }

   private:
    std::vector<T> slots_;
    std::size_t begin_ = 0, size_ = 0;
  };
  struct InjectedFaults;  // faults that a test has requested: injected_faults.h

  void give_back(int buffer) override;
  Instant begin_of(std::uint64_t frame) const;
  void advance(Instant now);
  void begin_frame(std::uint64_t frame, Instant begin, std::optional<Duration> pulse);
  Instant end_of(const Frame& frame) const;
  bool triggered() const { return wiring_.mode != TriggerMode::Off; }
  void trigger(const Edge& edge);
  bool is_lost(std::uint64_t frame);
  void write_controls(std::uint64_t frame, const ExposureRequest& asked);
  void tell(Frame& frame, std::uint64_t cookie);
  CapturedBuffer develop(const Frame& frame);

  Simulation simulation_;
  const StreamEffects stream_;
  const SimTime time_;
  const SimulatedWiring wiring_;
  WorkerPool pool_;
  CameraCapabilities capabilities_;
  StreamMode mode_;
  std::unique_ptr<SimulatedSensor> sensor_;
  Image<std::uint16_t> codes_;
  std::vector<std::vector<std::byte>> buffers_;

  mutable std::mutex mutex_;  // of everything below
  std::condition_variable changed_;
  bool started_ = false;
  Instant epoch_;                  // frame 0 opens; with a trigger: the camera starts
  std::uint64_t next_frame_ = 0;   // to open
  std::optional<Instant> opened_;  // by a pulse that lasts
  Instant read_out_;               // the last frame, but for a rolling shutter's last rows
  Ring<int> free_;
  Ring<Request> requests_;
  Ring<Frame> frames_;  // exposed, not waited for yet
  DelayedControl<Duration> exposure_;
  DelayedControl<double> gain_;
  Report last_report_;
  std::unique_ptr<InjectedFaults> faults_;
};

// `scene`: what follows "sim:", see simulation.h. It runs in real time, on as many threads as the machine
// has, at most 4.
Result<std::unique_ptr<Camera>> open_simulated_camera(std::string_view scene,
                                                      const SimulatedWiring& wiring = {});

}  // namespace hdrcam

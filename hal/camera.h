// A camera: requests for exposures go in, completed buffers come out. Four implementations: real (libcamera,
// V4L2), simulated (sim/), replayed (replay/), and a wrapper that injects faults (fault/). Its capabilities
// state what a camera cannot do; it has no methods that always fail. Thread-bound, except stop(), which any
// thread may call to end a wait().
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/buffer_lease.h"
#include "hal/core/black_level.h"
#include "hal/core/frame.h"
#include "hal/core/instant.h"
#include "hal/core/result.h"

namespace hdrcam {

// How the bytes of a buffer are laid out; Bayer orders as the sensor reads them out, left to right, top to
// bottom.
enum class PixelFormat {
  Rgb24,
  Bgr24,
  Yuyv,
  Uyvy,
  Nv12,
  Mjpeg,
  Grey8,
  // mono, as the Bayer formats of as many bits below
  Grey10,
  Grey12,
  Grey10Packed,
  Rggb8,
  Grbg8,
  Gbrg8,
  Bggr8,
  // 16-bit little-endian words
  Rggb10,
  Grbg10,
  Gbrg10,
  Bggr10,
  Rggb12,
  Grbg12,
  Gbrg12,
  Bggr12,
  Rggb16,
  Grbg16,
  Gbrg16,
  Bggr16,
  // MIPI CSI-2: 4 pixels in 5 bytes
  Rggb10Packed,
  Grbg10Packed,
  Gbrg10Packed,
  Bggr10Packed,
  // the same: 2 pixels in 3 bytes
  Rggb12Packed,
  Grbg12Packed,
  Gbrg12Packed,
  Bggr12Packed,
};
const char* name(PixelFormat format);
std::optional<PixelFormat> pixel_format(std::string_view name);

// Control delays: frames from the write of a control to the first that shows it (DelayedControls).
struct ControlDelays {
  int exposure = 0, gain = 0;
  friend bool operator==(const ControlDelays&, const ControlDelays&) = default;
};

// What the timestamp marks: start or end of exposure; the end is that of the last line's exposure.
enum class TimestampMark { ExposureBegin, ExposureEnd };

// How luma and chroma stand for red, green and blue (ITU-R BT.601, BT.709, BT.2020), and whether luma takes
// 16..235 or 0..255.
enum class YuvMatrix { Bt601, Bt709, Bt2020 };
enum class YuvRange { Limited, Full };
struct YuvCoding {
  YuvMatrix matrix = YuvMatrix::Bt601;
  YuvRange range = YuvRange::Limited;
  friend bool operator==(const YuvCoding&, const YuvCoding&) = default;
};

inline constexpr Duration kUsualFrameDuration{33'333'333};  // 30 Hz: where none is asked for or stated

struct StreamMode {
  PixelFormat format = PixelFormat::Rgb24;
  int width = 0, height = 0;                      // pixels
  Duration frame_duration = kUsualFrameDuration;  // constant: the schedule must not move the frame rate
};

// The exposure for the next frame. The cookie returns with the buffer that completes the request; capture/
// proves whether that buffer shows this exposure.
struct ExposureRequest {
  std::uint64_t cookie = 0;
  Duration exposure{0};
  double analogue_gain = 1;
};

struct CameraCapabilities {
  std::string id, model, driver;  // id: what --camera takes
  std::vector<StreamMode> modes;  // with the shortest frame duration of each
  // Of the stream, once configured, where the device has its own number: fewer than asked for, as its memory
  // allows or as its driver always has, or more, as it needs queued to deliver frames at all.
  std::optional<int> buffers;
  Duration usual_frame_duration = kUsualFrameDuration;  // unless another is requested
  Duration exposure_min{0}, exposure_max{0};
  // Steps begin at min. Of most sensors a line: no whole number of nanoseconds, and thousands make an
  // exposure.
  std::chrono::duration<std::int64_t, std::pico> exposure_step{1000};
  double gain_min = 1, gain_max = 1;  // analogue
  double gain_step = 0;               // 0: continuous, or as gains says
  // All of them, increasing, where their steps are not alike; empty: gain_step.
  std::vector<double> gains;
  bool sets_exposure = false;          // false: the camera delivers frames, but its exposure is fixed
  std::vector<ExposureRequest> cycle;  // exposures of its frames, where it sets none and they are known
  bool reports_exposure = false;       // completed buffers report their exposure
  bool exposure_per_request = false;   // a request sets the exposure of its own frame (request API, metadata)
  std::optional<ControlDelays> delays;    // of a known sensor
  std::optional<BlackLevel> black_level;  // of its codes, where the camera states it
  TimestampMark timestamp_mark = TimestampMark::ExposureBegin;
  std::optional<CameraFacts> recorded;  // of a recording that plays the camera, what it states of its own
};

// Invalid, naming the limits, where the camera can set exposures but not this one.
Result<void> check_exposure(const CameraCapabilities& camera, const ExposureRequest& request);

struct CapturedBuffer {
  std::uint64_t cookie = 0;          // of the request that it completed
  std::uint64_t sequence = 0;        // the driver's counter; a gap is a dropped frame
  Instant timestamp;                 // at the point that the capabilities' timestamp_mark names
  std::optional<Instant> centre;     // of the exposure, where a recording states it
  bool damaged = false;              // the driver reports incomplete pixels
  std::optional<Duration> exposure;  // as reported with the frame; none where it is not
  std::optional<double> analogue_gain, digital_gain;
  // Read-out of a rolling shutter: by how much each row is exposed later than the one above it, times the
  // rows; 0: unknown.
  Duration readout{0};
  std::optional<BlackLevel> black_level;  // of this frame, where each states its own
  // Where the report comes from, if not from the driver: the sensor's embedded data, which neither V4L2 nor
  // libcamera tells from a prediction, so that real cameras never set it; or what a recording states.
  std::optional<ExposureSource> exposure_source;
  // For controls that act immediately: this request's exposure was written late or never. The frame may show
  // an earlier request's exposure instead of the one that the control delay predicts.
  bool control_late = false;
  // What only a recording states of a frame: where it was seen from, and that its trigger pulse was late.
  std::optional<PoseMatrix> T_world_camera;
  bool trigger_late = false;
  StreamMode mode;
  YuvCoding yuv;                      // of YUV formats, as the camera states it
  std::size_t stride = 0;             // bytes a row (of the first plane)
  std::span<const std::byte> pixels;  // all planes, one after the other; valid as long as the lease
  int dmabuf_fd = -1;  // the same memory for other devices, where the driver exports it; the camera's
  BufferLease lease;
};

class Camera {
 public:
  virtual ~Camera() = default;
  virtual const CameraCapabilities& capabilities() const = 0;
  // Sets the nearest mode that the camera has and returns it: of a flipped sensor, in another Bayer order.
  // Unsupported where it has none of this format; Invalid while started, Busy while a frame is leased. Of
  // another number of buffers than requested (capabilities().buffers) queue() returns Busy at that one.
  virtual Result<StreamMode> configure(const StreamMode& wanted, int buffers) = 0;
  virtual Result<void> start() = 0;
  // One request, one frame. Busy when every buffer has a queued request. Some devices start only when two or
  // three requests are queued.
  virtual Result<void> queue(const ExposureRequest& request) = 0;
  // The next completed buffer, in order. Timeout, Unplugged, Interrupted (stop() was called).
  virtual Result<CapturedBuffer> wait(Duration timeout) = 0;
  // Ends the stream; queued requests are dropped, a waiting wait() returns Interrupted. start() may follow.
  virtual Result<void> stop() = 0;
  // What to tell the user of the frames so far, such as damaged ones of a recording; empty if there is
  // nothing.
  virtual std::vector<std::string> warnings() const { return {}; }
};

}  // namespace hdrcam

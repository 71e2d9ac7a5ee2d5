#include "hal/real/v4l2_modes.h"

#include <linux/videodev2.h>

#include <algorithm>

#include "hal/pixel_format_table.h"
#include "hal/real/stream_errors.h"
#include "hal/real/v4l2_formats.h"

namespace hdrcam {
namespace {

// A frame that takes no time, or endless time, is one of which the driver knows nothing.
bool is_stated(const v4l2_fract& seconds) { return seconds.numerator != 0 && seconds.denominator != 0; }
Duration duration_of(const v4l2_fract& seconds) {
  if (!is_stated(seconds)) return kUsualFrameDuration;
  return Duration(static_cast<Duration::rep>(1e9 * seconds.numerator / seconds.denominator + 0.5));
}

Duration shortest_frame(const DeviceNode& video, std::uint32_t fourcc, std::uint32_t width,
                        std::uint32_t height) {
  Duration shortest = Duration::max();
  v4l2_frmivalenum interval{};
  interval.pixel_format = fourcc, interval.width = width, interval.height = height;
  for (; video.ask(VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
    const bool discrete = interval.type == V4L2_FRMIVAL_TYPE_DISCRETE;
    shortest = std::min(shortest, duration_of(discrete ? interval.discrete : interval.stepwise.min));
    if (!discrete) break;
  }
  return shortest == Duration::max() ? kUsualFrameDuration : shortest;
}

// Unified access to a format: one plane in `pix`, or the first plane of `pix_mp`.
struct PixFormat {
  std::uint32_t width, height, fourcc, stride, bytes, field;
  YuvCoding yuv;
};

// include/uapi/linux/videodev2.h: what a driver leaves to the colour space follows from it.
YuvCoding coding_of(std::uint32_t colour_space, std::uint32_t encoding, std::uint32_t quantization) {
  if (encoding == V4L2_YCBCR_ENC_DEFAULT) encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(colour_space);
  if (quantization == V4L2_QUANTIZATION_DEFAULT)
    quantization = V4L2_MAP_QUANTIZATION_DEFAULT(false, colour_space, encoding);
  YuvCoding yuv;
  yuv.range = quantization == V4L2_QUANTIZATION_FULL_RANGE ? YuvRange::Full : YuvRange::Limited;
  switch (encoding) {
    case V4L2_YCBCR_ENC_709:
    case V4L2_YCBCR_ENC_XV709:
    case V4L2_YCBCR_ENC_SMPTE240M:  // .212 and .087 instead of .2126 and .0722
      yuv.matrix = YuvMatrix::Bt709;
      break;
    case V4L2_YCBCR_ENC_BT2020:
    case V4L2_YCBCR_ENC_BT2020_CONST_LUM:  // its chroma is made of other luma; the shares are the same
      yuv.matrix = YuvMatrix::Bt2020;
      break;
    default:
      break;
  }
  return yuv;
}

PixFormat read_format(const v4l2_format& format) {
  if (format.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    const auto& mp = format.fmt.pix_mp;
    return {mp.width,
            mp.height,
            mp.pixelformat,
            mp.plane_fmt[0].bytesperline,
            mp.plane_fmt[0].sizeimage,
            mp.field,
            coding_of(mp.colorspace, mp.ycbcr_enc, mp.quantization)};
  }
  const auto& pix = format.fmt.pix;
  return {pix.width,
          pix.height,
          pix.pixelformat,
          pix.bytesperline,
          pix.sizeimage,
          pix.field,
          coding_of(pix.colorspace, pix.ycbcr_enc, pix.quantization)};
}

void add_sizes(const DeviceNode& video, std::uint32_t queue_type, PixelFormat format, std::uint32_t fourcc,
               std::vector<StreamMode>& modes) {
  const auto add = [&](std::uint32_t width, std::uint32_t height) {
    modes.push_back({format, static_cast<int>(width), static_cast<int>(height),
                     shortest_frame(video, fourcc, width, height)});
  };
  v4l2_frmsizeenum size{};
  size.pixel_format = fourcc;
  for (; video.ask(VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      for (const PixelSize& one : sizes_within(size.stepwise)) add(one.width, one.height);
      return;
    }
    add(size.discrete.width, size.discrete.height);
  }
  if (size.index > 0) return;
  v4l2_format current{};  // a driver that lists no sizes has one
  current.type = queue_type;
  if (video.ask(VIDIOC_G_FMT, &current) != 0) return;
  const PixFormat found = read_format(current);
  add(found.width, found.height);
}

std::string offered_formats(const DeviceNode& video, std::uint32_t queue_type) {
  std::string list;
  v4l2_fmtdesc format{};
  format.type = queue_type;
  for (; video.ask(VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
    const auto known = format_of(format.pixelformat);
    list +=
        (list.empty() ? "" : ", ") + (known ? std::string(name(*known)) : fourcc_text(format.pixelformat));
  }
  return list.empty() ? "none" : list;
}

void write_format(const StreamMode& mode, v4l2_format& format) {
  const auto width = static_cast<std::uint32_t>(mode.width), height = static_cast<std::uint32_t>(mode.height);
  if (format.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    auto& mp = format.fmt.pix_mp;
    mp.width = width, mp.height = height, mp.pixelformat = fourcc_of(mode.format), mp.field = V4L2_FIELD_NONE;
    mp.num_planes = 1;
    return;
  }
  auto& pix = format.fmt.pix;
  pix.width = width, pix.height = height, pix.pixelformat = fourcc_of(mode.format),
  pix.field = V4L2_FIELD_NONE;
}

// Returns the one that the driver then states; `wanted` where it states none.
Duration set_frame_duration(const DeviceNode& video, std::uint32_t queue_type, Duration wanted) {
  v4l2_streamparm parameters{};
  parameters.type = queue_type;
  auto& capture = parameters.parm.capture;
  if (video.ask(VIDIOC_G_PARM, &parameters) != 0) return wanted;
  const Duration before = is_stated(capture.timeperframe) ? duration_of(capture.timeperframe) : wanted;
  if ((capture.capability & V4L2_CAP_TIMEPERFRAME) == 0) return before;
  capture.timeperframe.numerator = static_cast<std::uint32_t>((wanted.count() + 50) / 100);
  capture.timeperframe.denominator = 10'000'000;
  if (video.ask(VIDIOC_S_PARM, &parameters) != 0) return before;
  return is_stated(capture.timeperframe) ? duration_of(capture.timeperframe) : wanted;
}

// Both fields of an interlaced signal, woven into one picture, are of two moments; a single one lacks every
// second row. ANY is what no driver should answer: it reports no fields.
Result<void> check_progressive(const DeviceNode& video, std::uint32_t field) {
  if (field == V4L2_FIELD_NONE || field == V4L2_FIELD_ANY) return {};
  return Error{ErrorCode::Unsupported,
               fmt::format("'{}' delivers {}; feed it a progressive signal (1080p, not 1080i), or choose "
                           "another input or size",
                           video.path(),
                           V4L2_FIELD_HAS_BOTH(field) ? "interlaced pictures, whose rows are of two moments"
                                                      : "single fields, which lack every second row")};
}

// The standards of TV and DV timings belong to inputs that take the signal of another device.
bool takes_signal(const DeviceNode& video) {
  int selected = 0;
  if (video.ask(VIDIOC_G_INPUT, &selected) != 0) return false;
  v4l2_input input{};
  input.index = static_cast<std::uint32_t>(selected);
  constexpr std::uint32_t kOfSignals = V4L2_IN_CAP_STD | V4L2_IN_CAP_DV_TIMINGS;
  return video.ask(VIDIOC_ENUMINPUT, &input) == 0 && (input.capabilities & kOfSignals) != 0;
}

}  // namespace

std::vector<PixelSize> sizes_within(const v4l2_frmsize_stepwise& range) {
  constexpr PixelSize kUsual{640, 480};
  const auto offers = [](std::uint32_t size, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
    return size >= least && size <= most && (size - least) % std::max(1U, step) == 0;
  };
  const PixelSize largest{range.max_width, range.max_height};
  const bool is_largest = kUsual.width == largest.width && kUsual.height == largest.height;
  if (!is_largest && offers(kUsual.width, range.min_width, range.max_width, range.step_width) &&
      offers(kUsual.height, range.min_height, range.max_height, range.step_height))
    return {kUsual, largest};
  return {largest};
}

Result<V4l2Identity> identify(const DeviceNode& video) {
  v4l2_capability capability{};
  TRY(video.demand(VIDIOC_QUERYCAP, &capability, "say what it is"));
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps
                                                                                  : capability.capabilities;
  V4l2Identity identity;
  const auto text = [](const auto& field) { return std::string(reinterpret_cast<const char*>(field)); };
  identity.card = text(capability.card), identity.driver = text(capability.driver);
  identity.bus = text(capability.bus_info);
  if ((can & V4L2_CAP_VIDEO_CAPTURE) != 0)
    identity.queue_type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  else if ((can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0)
    identity.queue_type = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  if ((can & V4L2_CAP_STREAMING) == 0) identity.queue_type = 0;
  identity.media_controlled = (can & V4L2_CAP_IO_MC) != 0;
  identity.takes_signal = takes_signal(video);
  return identity;
}

bool needs_sensor_node(const V4l2Identity& identity, const CameraCapabilities& camera) {
  if (identity.bus.starts_with("usb-") || identity.driver == "v4l2 loopback") return false;
  return identity.media_controlled || (!identity.takes_signal && !camera.sets_exposure);
}

std::vector<StreamMode> modes_of(const DeviceNode& video, std::uint32_t queue_type) {
  std::vector<StreamMode> modes;
  v4l2_fmtdesc format{};
  format.type = queue_type;
  for (; video.ask(VIDIOC_ENUM_FMT, &format) == 0; ++format.index)
    if (const auto known = format_of(format.pixelformat))
      add_sizes(video, queue_type, *known, format.pixelformat, modes);
  return modes;
}

Result<V4l2Picture> set_mode(const DeviceNode& video, std::uint32_t queue_type, const StreamMode& wanted) {
  TRY(check_size(wanted));
  v4l2_format format{};
  format.type = queue_type;
  write_format(wanted, format);
  const int code = video.ask(VIDIOC_S_FMT, &format);
  if (code != 0 && code != EINVAL) return device_error(code, video.path(), "take the picture format");
  const PixFormat agreed = read_format(format);
  const bool one_piece = queue_type == V4L2_BUF_TYPE_VIDEO_CAPTURE || format.fmt.pix_mp.num_planes == 1;
  if (code == EINVAL || agreed.fourcc != fourcc_of(wanted.format) || !one_piece || agreed.width == 0)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' does not offer {}; it offers {}", video.path(), name(wanted.format),
                             offered_formats(video, queue_type))};
  TRY(check_progressive(video, agreed.field));
  V4l2Picture picture;
  picture.mode = wanted;
  picture.mode.width = static_cast<int>(agreed.width), picture.mode.height = static_cast<int>(agreed.height);
  picture.mode.frame_duration = set_frame_duration(video, queue_type, wanted.frame_duration);
  picture.yuv = agreed.yuv;
  picture.stride = wanted.format == PixelFormat::Mjpeg ? 0 : agreed.stride;
  // sizeimage may be padded, and the driver need not fill that
  picture.bytes = picture.stride == 0 ? agreed.bytes
                                      : picture_bytes(packing_of(wanted.format).packing, picture.mode.width,
                                                      picture.mode.height, picture.stride);
  return picture;
}

}  // namespace hdrcam

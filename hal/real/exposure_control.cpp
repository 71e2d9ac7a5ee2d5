#include "hal/real/exposure_control.h"

#include <linux/v4l2-controls.h>
#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>

namespace hdrcam {
namespace {

// Once more, and again, where a transfer to the device failed: it usually takes the next one. Not after a
// time-out, which took its time, nor where the device is busy.
int ask_again(const DeviceNode& node, unsigned long request, void* argument) {
  constexpr int kTries = 3;
  int code = 0;
  for (int i = 0; i < kTries; ++i) {
    code = node.ask(request, argument);
    if (!is_failed_transfer(code)) break;
  }
  return code;
}

}  // namespace

ExposureControl::Control ExposureControl::query(std::uint32_t id) const {
  v4l2_query_ext_ctrl answer{};
  answer.id = id;
  constexpr std::uint32_t kFixed = V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY;
  if (ask_again(*node_, VIDIOC_QUERY_EXT_CTRL, &answer) != 0 || (answer.flags & kFixed) != 0) return {};
  const auto step = std::max<std::int64_t>(1, static_cast<std::int64_t>(answer.step));
  return {id, answer.minimum, answer.maximum - (answer.maximum - answer.minimum) % step, step};
}

std::optional<std::int64_t> ExposureControl::value(std::uint32_t id) const {
  const bool wide = id == V4L2_CID_PIXEL_RATE;  // the one control here that has 64 bits
  v4l2_ext_control control{};
  control.id = id;
  v4l2_ext_controls controls{};
  controls.which = V4L2_CTRL_WHICH_CUR_VAL, controls.count = 1, controls.controls = &control;
  if (ask_again(*node_, VIDIOC_G_EXT_CTRLS, &controls) != 0) return std::nullopt;
  return wide ? control.value64 : control.value;
}

// "'Exposure, Auto'", as the driver calls it; else its number.
std::string ExposureControl::name_of(std::uint32_t id) const {
  v4l2_query_ext_ctrl answer{};
  answer.id = id;
  const bool named = node_->ask(VIDIOC_QUERY_EXT_CTRL, &answer) == 0 && answer.name[0] != '\0';
  return named ? fmt::format("'{}'", answer.name) : fmt::format("{:#x}", id);
}

// Of a control that a run needs as it asks for it.
Result<void> ExposureControl::set(v4l2_control& control, const char* doing) const {
  const int code = ask_again(*node_, VIDIOC_S_CTRL, &control);
  if (code == 0) return {};
  if (code == EBUSY && !holder_of(node_->path()).empty()) return device_error(code, node_->path(), doing);
  const std::string what = fmt::format("{} (control {} to {})", doing, name_of(control.id), control.value);
  Error error = control_error(code, node_->path(), what);
  if (error.code != ErrorCode::Unplugged)
    error.message += fmt::format(
        "; see with 'v4l2-ctl -d {} -L' what the control takes, plug a USB camera in again, or choose "
        "another",
        node_->path());
  return error;
}

// A gain whose codes define no factors is left alone.
void ExposureControl::take_gain(std::uint32_t id, const std::string& sensor) {
  const Control found = query(id);
  const auto codes = gain_codes_of(sensor, static_cast<double>(found.min));
  if (found.id != 0 && codes) gain_ = found, gain_codes_ = *codes;
}

ExposureControl ExposureControl::of_sensor(const DeviceNode& sensor, const std::string& name) {
  ExposureControl control(sensor);
  control.sensor_ = true;
  control.exposure_ = control.query(V4L2_CID_EXPOSURE);
  control.take_gain(V4L2_CID_ANALOGUE_GAIN, name);
  control.shutter_ = shutter_of(name);
  v4l2_subdev_format picture{};  // as it is now
  picture.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  if (sensor.ask(VIDIOC_SUBDEV_G_FMT, &picture) == 0)
    control.unit_ns_ = control.line_ns(picture.format.width).value_or(control.unit_ns_);
  return control;
}

ExposureControl ExposureControl::of_video_node(const DeviceNode& video) {
  ExposureControl control(video);
  control.exposure_ = control.query(V4L2_CID_EXPOSURE_ABSOLUTE);
  control.unit_ns_ = 1e5;
  control.take_gain(V4L2_CID_GAIN, "");
  return control;
}

ExposureControl ExposureControl::of_private(const DeviceNode& video, const PrivateExposureControl& wanted) {
  ExposureControl control(video);
  control.exposure_ = control.query(wanted.id);
  control.unit_ns_ = static_cast<double>(wanted.unit.count());
  return control;
}

Result<void> ExposureControl::take_over() {
  struct Manual {
    std::uint32_t id;
    std::int32_t value;
    const char* doing;
  };
  constexpr Manual kManual[] = {
      {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, "switch its automatic exposure off"},
      {V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0, "keep its frame rate, whatever the exposure"},
      {V4L2_CID_AUTOGAIN, 0, "switch its automatic gain off"},
      {V4L2_CID_AUTO_WHITE_BALANCE, 0, "switch its automatic white balance off"},
  };
  if (found_.empty()) {
    const auto remember = [&](std::uint32_t id) {
      if (query(id).id == 0) return;
      if (const auto now = value(id)) found_.push_back({id, static_cast<std::int32_t>(*now)});
    };
    // blanking before the exposure, whose maximum follows it; both before automatic ones, which would not
    // take them
    if (sensor_) remember(V4L2_CID_VBLANK);
    for (const std::uint32_t id : {exposure_.id, gain_.id})
      if (id != 0) remember(id);
    for (const Manual& manual : kManual) remember(manual.id);
  }
  for (const Manual& manual : kManual) {
    if (query(manual.id).id == 0) continue;
    v4l2_control control{manual.id, manual.value};
    TRY(set(control, manual.doing));
  }
  return {};
}

void ExposureControl::give_back() {
  for (const Found& found : found_) {
    v4l2_control control{found.id, found.value};
    // one that hangs would let each of them time out: half a minute, at the end of a run
    if (ask_again(*node_, VIDIOC_S_CTRL, &control) == ETIMEDOUT) break;
  }
  found_.clear();
}

std::optional<double> ExposureControl::line_ns(std::int64_t width) const {
  const auto pixel_rate = value(V4L2_CID_PIXEL_RATE), hblank = value(V4L2_CID_HBLANK);
  if (!pixel_rate || !hblank || *pixel_rate <= 0) return std::nullopt;
  return static_cast<double>(width + *hblank) / static_cast<double>(*pixel_rate) * 1e9;
}

Result<std::optional<Duration>> ExposureControl::fix_frame_duration(int width, int height, Duration wanted) {
  if (!sensor_ || !exists()) return std::optional<Duration>();
  const auto line = line_ns(width);
  if (!line)
    return Error{
        ErrorCode::Unsupported,
        fmt::format(
            "sensor '{}' does not report how long a line lasts (no pixel rate or blanking control), so its "
            "exposure has no unit",
            node_->path())};
  unit_ns_ = *line;
  const Control vblank = query(V4L2_CID_VBLANK);
  std::int64_t blank_lines = value(V4L2_CID_VBLANK).value_or(0);
  if (vblank.id != 0) {
    blank_lines = std::llround(static_cast<double>(wanted.count()) / unit_ns_) - height;
    blank_lines = std::clamp(blank_lines, vblank.min, vblank.max);
    v4l2_control control{V4L2_CID_VBLANK, static_cast<std::int32_t>(blank_lines)};
    TRY(set(control, "fix its frame duration"));
    blank_lines = value(V4L2_CID_VBLANK).value_or(control.value);  // as the driver rounded it to its steps
  }
  exposure_ = query(V4L2_CID_EXPOSURE);  // its maximum follows the blanking
  return std::optional(Duration(std::llround(static_cast<double>(height + blank_lines) * unit_ns_)));
}

Duration ExposureControl::readout(int height) const {
  if (shutter_ != Shutter::Rolling || !exists()) return Duration::zero();
  return Duration(std::llround(height * unit_ns_));  // the exposure's unit is a line
}

void ExposureControl::describe(CameraCapabilities& camera) const {
  camera.sets_exposure = exists();
  if (!exists()) return;
  const auto steps_to_positive =
      exposure_.min > 0 ? 0 : (exposure_.step - exposure_.min) / exposure_.step;  // 0 is no exposure
  const auto lowest = exposure_.min + steps_to_positive * exposure_.step;
  const auto duration = [&](std::int64_t code) {
    return Duration(std::llround(static_cast<double>(code) * unit_ns_));
  };
  camera.exposure_min = duration(lowest);
  camera.exposure_max = duration(exposure_.max);
  camera.exposure_step =
      decltype(camera.exposure_step)(std::llround(static_cast<double>(exposure_.step) * unit_ns_ * 1000));
  camera.gain_min = camera.gain_max = 1, camera.gain_step = 0;
  camera.gains.clear();
  if (gain_.id == 0) return;
  camera.gain_min = gain_codes_.gain_of(static_cast<double>(gain_.min));
  camera.gain_max = gain_codes_.gain_of(static_cast<double>(gain_.max));
  if (gain_codes_.law == GainCodes::Law::Proportional) {
    camera.gain_step = gain_codes_.gain_of(static_cast<double>(gain_.min + gain_.step)) - camera.gain_min;
    return;
  }
  constexpr std::int64_t kMostCodes = 1 << 16;  // of a sensor; a control of more is as good as continuous
  if ((gain_.max - gain_.min) / gain_.step > kMostCodes) return;
  for (std::int64_t code = gain_.min; code <= gain_.max; code += gain_.step)
    camera.gains.push_back(gain_codes_.gain_of(static_cast<double>(code)));
}

Result<void> ExposureControl::write(const ExposureRequest& wanted, int request_fd) const {
  const auto code_of = [](double exact, const Control& control) {
    const double steps =
        std::round((exact - static_cast<double>(control.min)) / static_cast<double>(control.step));
    const auto code = control.min + static_cast<std::int64_t>(steps) * control.step;
    return static_cast<std::int32_t>(std::clamp(code, control.min, control.max));
  };
  std::array<v4l2_ext_control, 2> both{};
  both[0].id = exposure_.id;
  both[0].value = code_of(static_cast<double>(wanted.exposure.count()) / unit_ns_, exposure_);
  both[1].id = gain_.id;
  if (gain_.id != 0) both[1].value = code_of(gain_codes_.code_of(wanted.analogue_gain), gain_);
  v4l2_ext_controls controls{};
  controls.which = request_fd >= 0 ? V4L2_CTRL_WHICH_REQUEST_VAL : V4L2_CTRL_WHICH_CUR_VAL;
  controls.request_fd = request_fd, controls.count = gain_.id != 0 ? 2 : 1, controls.controls = both.data();
  if (const int code = ask_again(*node_, VIDIOC_S_EXT_CTRLS, &controls); code != 0)
    return control_error(code, node_->path(), "set its exposure");
  return {};
}

std::optional<ExposureControl::Applied> ExposureControl::read(int request_fd) const {
  std::array<v4l2_ext_control, 2> both{};
  both[0].id = exposure_.id, both[1].id = gain_.id;
  v4l2_ext_controls controls{};
  controls.which = V4L2_CTRL_WHICH_REQUEST_VAL, controls.request_fd = request_fd;
  controls.count = gain_.id != 0 ? 2 : 1, controls.controls = both.data();
  if (node_->ask(VIDIOC_G_EXT_CTRLS, &controls) != 0) return std::nullopt;
  return Applied{Duration(std::llround(both[0].value * unit_ns_)),
                 gain_.id != 0 ? gain_codes_.gain_of(both[1].value) : 1};
}

}  // namespace hdrcam

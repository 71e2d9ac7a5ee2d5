// A USB camera in user space. The kernel's own uvcvideo driver binds to it; exposure and gain really change
// the picture, `latency` frames after they were set, and every picture says what it was taken with
// (picture_stamp.h).
// usage: hdrcam_usb_camera [--latency FRAMES] [--rate HZ] [--name TEXT] [--strobe PULL_FILE] [--lose-every N]
//   PULL_FILE is the `pull` attribute of a gpio-sim line, which is raised while a frame is transferred; of
//   every N frames the last is exposed but never sent.
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <string>
#include <string_view>

#include "tests/hil/usb_camera/picture_stamp.h"
#include "tests/hil/usb_camera/usbip_link.h"
#include "tests/hil/usb_camera/uvc_device.h"

namespace hdrcam::hil {
namespace {

struct Options {
  int latency = 1, rate_hz = 30;
  std::uint32_t lose_every = 0;  // 0: none
  std::string name = "hdrcam test camera", strobe;
};

std::uint64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(now.tv_nsec);
}

// A ramp over four decades of light, with stripes, and a black square that moves; luma as the device's colour
// descriptor says: BT.709's transfer, 16 to 235.
class Scene {
 public:
  void paint(PictureSize size, std::uint32_t frame, const CameraSettings& settings, std::uint8_t* yuyv) {
    prepare(size);
    const auto luma = luma_of_light(settings);
    for (std::size_t i = 0; i < light_.size(); ++i) yuyv[2 * i] = luma[light_[i]], yuyv[2 * i + 1] = 128;
    const int left = static_cast<int>(frame * 4 % static_cast<std::uint32_t>(size.width));
    for (int y = size.height / 2; y < size.height * 5 / 8; ++y)
      for (int x = left; x < std::min(left + 16, size.width); ++x) yuyv[2 * (y * size.width + x)] = 16;
  }

 private:
  static constexpr int kLevels = 256;  // of light, equal ratios
  static constexpr float kDecades = 4;

  // The brightest light saturates in 0.1 ms at gain 1.
  static std::array<std::uint8_t, kLevels> luma_of_light(const CameraSettings& settings) {
    const float amplify =
        static_cast<float>(settings.exposure_100us) * static_cast<float>(settings.gain_16ths) / 16.F;
    std::array<std::uint8_t, kLevels> luma{};
    for (int i = 0; i < kLevels; ++i) {
      const float decades = kDecades * (static_cast<float>(i) / (kLevels - 1) - 1);
      const float light = std::min(1.F, amplify * std::pow(10.F, decades));
      const float signal = light < 0.018F ? 4.5F * light : 1.099F * std::pow(light, 0.45F) - 0.099F;
      const float code = 16.5F + 219.F * signal + static_cast<float>(settings.brightness);
      luma[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::clamp(code, 0.F, 255.F));
    }
    return luma;
  }
  void prepare(PictureSize size) {
    const auto pixels = static_cast<std::size_t>(size.width * size.height);
    if (light_.size() == pixels) return;
    light_.resize(pixels);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        const int stripes = (y / 8) % 2 == 0 ? 0 : 6;
        const int level = x * (kLevels - 6) / size.width + stripes;
        light_[static_cast<std::size_t>(y * size.width + x)] = static_cast<std::uint8_t>(level);
      }
  }
  std::vector<std::uint8_t> light_;  // level, [rows, cols]
};

class UsbCamera {
 public:
  UsbCamera(UsbIpLink link, Options options)
      : link_(std::move(link)), options_(std::move(options)), device_(options_.name, options_.rate_hz) {}

  void run() {
    for (;;) {
      pollfd wire{link_.fd(), POLLIN, 0};
      timespec until_frame{};
      if (streaming_) {
        const std::uint64_t now = now_ns(), left = next_frame_ns_ > now ? next_frame_ns_ - now : 0;
        until_frame = {static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
      }
      (void)::ppoll(&wire, 1, streaming_ ? &until_frame : nullptr, nullptr);
      if (streaming_ && now_ns() >= next_frame_ns_) expose();
      if (wire.revents == 0) continue;
      const auto message = link_.receive();
      if (!message) return;
      take(*message);
    }
  }

 private:
  void take(const Message& message) {
    if (!message.transfer) {
      const auto pending = std::find_if(bulk_.begin(), bulk_.end(),
                                        [&](const Transfer& t) { return t.sequence == message.unlinked; });
      const bool found = pending != bulk_.end();
      if (found) bulk_.erase(pending);
      link_.answer_unlink(message.sequence, found);
      return;
    }
    const Transfer& transfer = *message.transfer;
    if (transfer.endpoint == 0) {
      const auto answer = device_.control(transfer);
      const std::size_t length = !answer ? 0 : transfer.to_host ? answer->size() : transfer.data.size();
      link_.answer(transfer.sequence, answer ? 0 : kStall, length,
                   answer ? *answer : std::vector<std::uint8_t>());
      if (!device_.committed()) streaming_ = false;
      return;
    }
    bulk_.push_back(transfer);
    if (device_.committed() && !streaming_) {
      streaming_ = true, frame_ = 0, history_.clear();
      payload_.clear(), sent_ = 0;
      next_frame_ns_ = now_ns() + device_.frame_period_ns();
    }
    pump();
  }

  // Settings as they are now act `latency` frames later.
  void expose() {
    const std::uint64_t period = device_.frame_period_ns();
    next_frame_ns_ += period;
    if (next_frame_ns_ + 5 * period < now_ns())
      next_frame_ns_ = now_ns() + period;  // after a long pause, no catching up
    history_.push_back(device_.settings());
    while (history_.size() > static_cast<std::size_t>(options_.latency) + 1) history_.pop_front();
    const CameraSettings& applied = history_.front();
    const std::uint32_t frame = frame_++;
    if (sent_ < payload_.size()) return;  // the last frame is still on the wire: this one is lost
    if (options_.lose_every > 0 && frame % options_.lose_every == options_.lose_every - 1) {
      strobe(true), strobe(false);
      return;
    }
    const PictureSize size = device_.size();
    payload_.resize(2 + static_cast<std::size_t>(size.width * size.height) * 2);
    toggle_ ^= 1;
    payload_[0] = 2,
    payload_[1] = static_cast<std::uint8_t>(0x80 | 0x02 | toggle_);  // header, end of frame [2.4.3.3]
    scene_.paint(size, frame, applied, payload_.data() + 2);
    PictureStamp stamp;
    stamp.frame = frame, stamp.exposure_100us = applied.exposure_100us;
    stamp.gain_16ths = applied.gain_16ths, stamp.brightness = applied.brightness;
    write_stamp(stamp, payload_.data() + 2);
    sent_ = 0;
    strobe(true);
    pump();
  }

  void pump() {
    while (!bulk_.empty() && sent_ < payload_.size()) {
      const Transfer transfer = std::move(bulk_.front());
      bulk_.pop_front();
      const std::size_t n = std::min<std::size_t>(payload_.size() - sent_, transfer.length);
      link_.answer(transfer.sequence, 0, n, std::span(payload_).subspan(sent_, n));
      sent_ += n;
      if (sent_ == payload_.size()) strobe(false);
    }
  }

  void strobe(bool on) const {
    if (options_.strobe.empty()) return;
    const int file = ::open(options_.strobe.c_str(), O_WRONLY | O_CLOEXEC);
    if (file < 0) return;
    const std::string_view word = on ? "pull-up" : "pull-down";
    (void)!::write(file, word.data(), word.size());
    ::close(file);
  }

  UsbIpLink link_;
  Options options_;
  UvcDevice device_;
  Scene scene_;
  std::deque<Transfer> bulk_;           // the host's empty hands
  std::deque<CameraSettings> history_;  // oldest first
  std::vector<std::uint8_t> payload_;   // of the frame on the wire
  std::size_t sent_ = 0;
  bool streaming_ = false;
  std::uint8_t toggle_ = 0;  // changes with every frame
  std::uint32_t frame_ = 0;
  std::uint64_t next_frame_ns_ = 0;
};

}  // namespace
}  // namespace hdrcam::hil

int main(int argc, char** argv) {
  hdrcam::hil::Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view flag = argv[i];
    if (flag == "--rate") options.rate_hz = std::atoi(argv[i + 1]);
    if (flag == "--latency") options.latency = std::atoi(argv[i + 1]);
    if (flag == "--lose-every") options.lose_every = static_cast<std::uint32_t>(std::atoi(argv[i + 1]));
    if (flag == "--name") options.name = argv[i + 1];
    if (flag == "--strobe") options.strobe = argv[i + 1];
  }
  const sched_param before_all{.sched_priority = 10};  // a camera does not wait for its host's processor
  (void)::sched_setscheduler(0, SCHED_FIFO, &before_all);
  auto link = hdrcam::hil::UsbIpLink::plug_in();
  if (!link) {
    std::perror(
        "hdrcam_usb_camera: the virtual host controller does not take a device (modprobe vhci-hcd; be root)");
    return 1;
  }
  hdrcam::hil::UsbCamera(std::move(*link), options).run();
}

// A USB Video Class 1.1 camera without the connection: descriptors, control requests, format negotiation. It
// has the controls that the product uses: exposure (mode and time), gain, brightness, four picture sizes in
// YUYV, a bulk endpoint. Numbers in brackets are chapters of "USB Device Class Definition for Video Devices,
// revision 1.1". Thread-bound.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/hil/usb_camera/usbip_link.h"

namespace hdrcam::hil {

struct PictureSize {
  int width, height;
};
constexpr std::array kSizes{PictureSize{320, 240}, PictureSize{640, 480}, PictureSize{1280, 720},
                            PictureSize{160, 120}};

struct CameraSettings {
  std::uint8_t exposure_mode = 1;  // manual [A.9.4]
  std::uint32_t exposure_100us = 100;
  std::uint16_t gain_16ths = 16;
  std::int16_t brightness = 0;  // codes
};

class UvcDevice {
 public:
  UvcDevice(std::string product, int usual_rate_hz);

  // Answers a transfer of endpoint 0: the bytes for the host (none for a write); nullopt: stall.
  std::optional<std::vector<std::uint8_t>> control(const Transfer& transfer);

  const CameraSettings& settings() const { return settings_; }
  PictureSize size() const { return kSizes[probe_frame_ - 1U]; }
  std::uint64_t frame_period_ns() const { return probe_interval_100ns_ * 100ULL; }
  // The host has committed a format and has not stopped the stream since.
  bool committed() const { return committed_; }

 private:
  using Bytes = std::vector<std::uint8_t>;
  Bytes make_configuration() const;
  std::optional<Bytes> standard_request(const Transfer& transfer);
  std::optional<Bytes> descriptor(std::uint8_t type, std::uint8_t index) const;
  std::optional<Bytes> streaming_request(const Transfer& transfer);
  std::optional<Bytes> setting_request(const Transfer& transfer);
  void take_probe(std::span<const std::uint8_t> data);
  Bytes probe_answer() const;

  std::string product_;
  std::uint32_t usual_interval_100ns_;
  Bytes configuration_;
  CameraSettings settings_;
  std::uint8_t probe_frame_ = 2;  // of kSizes, from 1
  std::uint32_t probe_interval_100ns_;
  std::uint8_t last_error_ = 0;
  bool committed_ = false;
};

}  // namespace hdrcam::hil

#include "tests/hil/usb_camera/uvc_device.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

namespace hdrcam::hil {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::array<std::uint32_t, 4> kIntervals_100ns{166667, 333333, 666667,
                                                        2'000'000};  // 60, 30, 15, 5 frames a second
constexpr std::size_t kProbeLength = 34;                             // [4.3.1.1], UVC 1.1
constexpr std::uint32_t kClock_hz = 48'000'000;
constexpr std::uint8_t kCameraTerminal = 1, kProcessingUnit = 2, kOutputTerminal = 3;

enum Request : std::uint8_t {  // [A.8]
  kSetCur = 0x01,
  kGetCur = 0x81,
  kGetMin = 0x82,
  kGetMax = 0x83,
  kGetRes = 0x84,
  kGetLen = 0x85,
  kGetInfo = 0x86,
  kGetDef = 0x87,
};

std::uint32_t nearest_interval(std::uint32_t wanted_100ns) {
  const auto distance = [&](std::uint32_t interval) {
    return std::max(interval, wanted_100ns) - std::min(interval, wanted_100ns);
  };
  return *std::min_element(kIntervals_100ns.begin(), kIntervals_100ns.end(),
                           [&](auto a, auto b) { return distance(a) < distance(b); });
}

std::uint8_t byte(std::uint64_t value, int index) { return static_cast<std::uint8_t>(value >> (8 * index)); }
void put(Bytes& bytes, std::initializer_list<std::uint8_t> more) {
  for (const std::uint8_t each : more) bytes.push_back(each);
}
void put_16(Bytes& bytes, std::size_t value) { put(bytes, {byte(value, 0), byte(value, 1)}); }
void put_32(Bytes& bytes, std::size_t value) {
  put(bytes, {byte(value, 0), byte(value, 1), byte(value, 2), byte(value, 3)});
}

std::size_t picture_bytes(PictureSize size) { return static_cast<std::size_t>(size.width * size.height) * 2; }

// The 16-byte name of YUYV [USB_Video_Payload_Uncompressed 1.1, 2.1].
constexpr std::initializer_list<std::uint8_t> kYuyvGuid{'Y',  'U', 'Y', '2',  0, 0,    0x10, 0,
                                                        0x80, 0,   0,   0xaa, 0, 0x38, 0x9b, 0x71};

void put_control_interface(Bytes& bytes) {
  put(bytes, {9, 4, 0, 0, 0, 14, 1, 0, 2});  // interface 0: VideoControl
  put(bytes, {13, 0x24, 1});                 // header [3.7.2]
  put_16(bytes, 0x110), put_16(bytes, 13 + 18 + 12 + 9), put_32(bytes, kClock_hz);
  put(bytes, {1, 1});
  put(bytes, {18, 0x24, 2, kCameraTerminal});  // input terminal [3.7.2.3]: exposure mode and time
  put_16(bytes, 0x201);
  put(bytes, {0, 0, 0, 0, 0, 0, 0, 0, 3, 0x0a, 0, 0});
  put(bytes, {12, 0x24, 5, kProcessingUnit, kCameraTerminal, 0, 0, 2, 0x01, 0x02, 0,
              0});  // brightness, gain [3.7.2.5]
  put(bytes, {9, 0x24, 3, kOutputTerminal});
  put_16(bytes, 0x101);
  put(bytes, {0, kProcessingUnit, 0});
}

void put_streaming_interface(Bytes& bytes, std::uint32_t usual_interval_100ns) {
  constexpr std::size_t kFrameLength = 26 + 4 * kIntervals_100ns.size();
  put(bytes, {9, 4, 1, 0, 1, 14, 2, 0, 0});  // interface 1: VideoStreaming
  put(bytes, {14, 0x24, 1, 1});              // input header [3.9.2.1]
  put_16(bytes, 14 + 27 + kSizes.size() * kFrameLength + 6);
  put(bytes, {0x81, 0, kOutputTerminal, 0, 0, 0, 1, 0});
  put(bytes, {27, 0x24, 4, 1, static_cast<std::uint8_t>(kSizes.size())});  // format: uncompressed
  put(bytes, kYuyvGuid);
  put(bytes, {16, 2, 0, 0, 0, 0});
  for (std::size_t i = 0; i < kSizes.size(); ++i) {
    const std::size_t picture = picture_bytes(kSizes[i]);
    put(bytes, {static_cast<std::uint8_t>(kFrameLength), 0x24, 5, static_cast<std::uint8_t>(i + 1), 0});
    put_16(bytes, static_cast<std::size_t>(kSizes[i].width)),
        put_16(bytes, static_cast<std::size_t>(kSizes[i].height));
    put_32(bytes, picture * 8 * 15), put_32(bytes, picture * 8 * 60), put_32(bytes, picture);
    put_32(bytes, usual_interval_100ns), put(bytes, {static_cast<std::uint8_t>(kIntervals_100ns.size())});
    for (const std::uint32_t interval : kIntervals_100ns) put_32(bytes, interval);
  }
  put(bytes, {6, 0x24, 0x0d, 1, 1, 4});  // colours: BT.709 primaries and transfer, BT.601 matrix
  put(bytes, {7, 5, 0x81, 2, 0, 2, 0});  // endpoint 1 in: bulk, 512 bytes
}

// One setting of the camera as the host sees it.
struct Setting {
  int length;
  std::int64_t now, min, max, resolution, initial;
};

Bytes answer(const Setting& setting, std::uint8_t request) {
  const auto value = [&](std::int64_t number) {
    Bytes bytes;
    for (int i = 0; i < setting.length; ++i) bytes.push_back(byte(static_cast<std::uint64_t>(number), i));
    return bytes;
  };
  switch (request) {
    case kGetMin:
      return value(setting.min);
    case kGetMax:
      return value(setting.max);
    case kGetRes:
      return value(setting.resolution);
    case kGetDef:
      return value(setting.initial);
    case kGetLen:
      return {static_cast<std::uint8_t>(setting.length), 0};
    case kGetInfo:
      return {3};  // can be read and written
    default:
      return value(setting.now);
  }
}

}  // namespace

UvcDevice::UvcDevice(std::string product, int usual_rate_hz)
    : product_(std::move(product)),
      usual_interval_100ns_(nearest_interval(10'000'000U / static_cast<std::uint32_t>(usual_rate_hz))),
      configuration_(make_configuration()),
      probe_interval_100ns_(usual_interval_100ns_) {}

Bytes UvcDevice::make_configuration() const {
  Bytes bytes{9, 2, 0, 0, 2, 1, 0, 0x80, 250};
  put(bytes, {8, 11, 0, 2, 14, 3, 0, 2});  // interface association [3.6]
  put_control_interface(bytes);
  put_streaming_interface(bytes, usual_interval_100ns_);
  bytes[2] = byte(bytes.size(), 0), bytes[3] = byte(bytes.size(), 1);
  return bytes;
}

std::optional<Bytes> UvcDevice::control(const Transfer& transfer) {
  const std::uint8_t kind = transfer.setup[0] & 0x60;
  const std::uint8_t interface = transfer.setup[4];
  std::optional<Bytes> answered;
  if (kind == 0)
    answered = standard_request(transfer);
  else if (kind == 0x20)
    answered = interface == 1 ? streaming_request(transfer) : setting_request(transfer);
  if (answered && answered->size() > transfer.length) answered->resize(transfer.length);
  return answered;
}

std::optional<Bytes> UvcDevice::standard_request(const Transfer& transfer) {
  enum {
    kGetStatus = 0,
    kClearFeature = 1,
    kSetFeature = 3,
    kGetDescriptor = 6,
    kGetConfiguration = 8,
    kSetConfiguration = 9,
    kGetInterface = 10,
    kSetInterface = 11
  };
  switch (transfer.setup[1]) {
    case kGetDescriptor:
      return descriptor(transfer.setup[3], transfer.setup[2]);
    case kGetStatus:
      return Bytes{0, 0};
    case kGetConfiguration:
      return Bytes{1};
    case kGetInterface:
      return Bytes{0};
    case kClearFeature:  // the host clears the endpoint's halt to stop a bulk stream
      if (transfer.setup[0] == 2) committed_ = false;
      return Bytes{};
    case kSetFeature:
    case kSetConfiguration:
    case kSetInterface:
      return Bytes{};
    default:
      return std::nullopt;
  }
}

std::optional<Bytes> UvcDevice::descriptor(std::uint8_t type, std::uint8_t index) const {
  enum { kDevice = 1, kConfiguration = 2, kString = 3, kQualifier = 6 };
  switch (type) {
    case kDevice:
      return Bytes{18, 1, 0, 2, 0xef, 2, 1, 64, 0x09, 0x12, 1, 0, 0, 1, 1, 2, 3, 1};  // 1209:0001
    case kConfiguration:
      return configuration_;
    case kQualifier:
      return Bytes{10, 6, 0, 2, 0xef, 2, 1, 64, 1, 0};
    case kString:
      break;
    default:
      return std::nullopt;
  }
  if (index == 0) return Bytes{4, 3, 9, 4};  // English
  const std::array<std::string, 3> texts{"hdrcam", product_, "1"};
  if (index > texts.size()) return std::nullopt;
  Bytes bytes;
  put(bytes, {0, 3});
  for (const char letter : texts[index - 1U]) put(bytes, {static_cast<std::uint8_t>(letter), 0});
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  return bytes;
}

std::optional<Bytes> UvcDevice::streaming_request(const Transfer& transfer) {
  const std::uint8_t selector = transfer.setup[3], request = transfer.setup[1];
  constexpr std::uint8_t kProbe = 1, kCommit = 2;
  if (selector != kProbe && selector != kCommit) return std::nullopt;
  if (request == kSetCur) {
    take_probe(transfer.data);
    committed_ = committed_ || selector == kCommit;
    return Bytes{};
  }
  if (request == kGetLen) return Bytes{kProbeLength, 0};
  if (request == kGetInfo) return Bytes{3};
  UvcDevice shown = *this;
  if (request == kGetMin) shown.probe_interval_100ns_ = kIntervals_100ns.front();
  if (request == kGetMax) shown.probe_interval_100ns_ = kIntervals_100ns.back();
  if (request == kGetDef) shown.probe_frame_ = 2, shown.probe_interval_100ns_ = usual_interval_100ns_;
  return shown.probe_answer();
}

void UvcDevice::take_probe(std::span<const std::uint8_t> data) {
  if (data.size() < 8) return;
  if (data[3] >= 1 && data[3] <= kSizes.size()) probe_frame_ = data[3];
  std::uint32_t wanted = 0;
  for (std::size_t i = 8; i-- > 4;) wanted = wanted << 8 | data[i];
  probe_interval_100ns_ = nearest_interval(wanted);
}

Bytes UvcDevice::probe_answer() const {
  Bytes bytes;
  put(bytes, {0, 0, 1, probe_frame_});
  put_32(bytes, probe_interval_100ns_);
  bytes.resize(18);
  const std::size_t picture = picture_bytes(size());
  put_32(bytes, picture), put_32(bytes, picture + 2),
      put_32(bytes, kClock_hz);  // payload: a header of two bytes
  put(bytes, {3});
  bytes.resize(kProbeLength);
  return bytes;
}

std::optional<Bytes> UvcDevice::setting_request(const Transfer& transfer) {
  const std::uint8_t unit = transfer.setup[5], selector = transfer.setup[3], request = transfer.setup[1];
  constexpr std::uint8_t kWrongRequest = 6;  // [4.2.1.2]
  std::int64_t written = 0;
  for (std::size_t i = 0; i < transfer.data.size() && i < 4; ++i)
    written |= static_cast<std::int64_t>(transfer.data[i]) << (8 * i);
  const bool write = request == kSetCur;
  std::optional<Setting> setting;
  if (unit == 0 && selector == 2) return Bytes{last_error_};
  if (unit == kCameraTerminal && selector == 2) {
    if (write) settings_.exposure_mode = static_cast<std::uint8_t>(written);
    setting = {1, settings_.exposure_mode, 1, 8, 1 | 2,
               1};  // resolution: a set of modes, manual and automatic
  } else if (unit == kCameraTerminal && selector == 4) {
    if (write) settings_.exposure_100us = std::max(1U, static_cast<std::uint32_t>(written));
    setting = {4, settings_.exposure_100us, 1, 10000, 1, 100};
  } else if (unit == kProcessingUnit && selector == 2) {
    if (write) settings_.brightness = static_cast<std::int16_t>(written);
    setting = {2, settings_.brightness, -64, 64, 1, 0};
  } else if (unit == kProcessingUnit && selector == 4) {
    if (write) settings_.gain_16ths = static_cast<std::uint16_t>(written);
    setting = {2, settings_.gain_16ths, 16, 256, 1, 16};
  }
  last_error_ = setting ? 0 : kWrongRequest;
  if (!setting) return std::nullopt;
  return write ? Bytes{} : answer(*setting, request);
}

}  // namespace hdrcam::hil

#include "hal/real/enumerate.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "hal/core/counted.h"
#include "hal/gpu/gpu_list.h"
#include "hal/real/camera_libcamera.h"
#include "hal/real/camera_v4l2.h"
#include "hal/real/device_node.h"
#include "hal/real/gpio_line.h"
#include "hal/real/media_graph.h"
#include "hal/real/v4l2_modes.h"

namespace hdrcam {
namespace {

constexpr const char* kLibcameraPrefix = "libcamera:";

std::string exposure_fact(const CameraCapabilities& camera) {
  if (!camera.sets_exposure) return "exposure: fixed by the device";
  const auto microseconds = [](auto d) { return std::chrono::duration<double, std::micro>(d).count(); };
  std::string fact = fmt::format("exposure {:.1f} to {:.1f} us in steps of {:.1f} us, gain {:.2f} to {:.2f}",
                                 microseconds(camera.exposure_min), microseconds(camera.exposure_max),
                                 microseconds(camera.exposure_step), camera.gain_min, camera.gain_max);
  if (camera.reports_exposure) fact += ", reported with each frame";
  return fact;
}

// One line per format: its sizes, largest frame rate of each.
std::vector<std::string> mode_facts(const CameraCapabilities& camera) {
  std::vector<std::string> facts;
  std::map<PixelFormat, std::string> sizes;
  for (const StreamMode& mode : camera.modes) {
    std::string& list = sizes[mode.format];
    list += fmt::format("{}{}x{}@{:.0f}", list.empty() ? "" : " ", mode.width, mode.height,
                        1 / to_seconds(mode.frame_duration));
  }
  facts.reserve(sizes.size());
  for (const auto& [format, list] : sizes) facts.push_back(fmt::format("{}: {}", name(format), list));
  if (facts.empty()) facts.emplace_back("no picture format that hdrcam supports");
  return facts;
}

FoundDevice described(const CameraCapabilities& camera, const std::string& id) {
  FoundDevice found{DeviceKind::Camera, id, fmt::format("{} ({})", camera.model, camera.driver), {}, {}};
  found.facts = mode_facts(camera);
  found.facts.insert(found.facts.begin(), exposure_fact(camera));
  return found;
}

void add_libcamera_cameras(std::vector<FoundDevice>& devices) {
  auto cameras = list_libcamera_cameras();
  if (!cameras) {
    devices.push_back({DeviceKind::Camera, "", "libcamera", {}, {cameras.error().message}});
    return;
  }
  for (const CameraCapabilities& camera : *cameras)
    devices.push_back(described(camera, kLibcameraPrefix + camera.id));
}

// Why the sensor of a camera that needs one is not found; nullopt: it is, or there is none.
std::optional<Error> sensor_not_reached(const std::string& node, const CameraCapabilities& camera) {
  const auto graph = media_graph_of(node);
  if (graph) return std::nullopt;
  if (auto video = DeviceNode::open(node); video.ok())
    if (auto identity = identify(*video); identity.ok() && !needs_sensor_node(*identity, camera))
      return std::nullopt;
  return graph.error();
}

void add_v4l2_cameras(std::vector<FoundDevice>& devices) {
  for (const std::string& node : device_nodes("video")) {
    auto camera = open_v4l2_camera(node);
    if (!camera && camera.error().code == ErrorCode::Unsupported) continue;  // a decoder, a metadata node
    if (!camera) {
      devices.push_back({DeviceKind::Camera, "", node, {}, {camera.error().message}});
      continue;
    }
    FoundDevice found = described((*camera)->capabilities(), node);
    if (const auto closed = sensor_not_reached(node, (*camera)->capabilities()))
      found.missing.push_back("its sensor's controls cannot be found: " + closed->message);
    if (const std::string holder = holder_of(node); !holder.empty())
      found.facts.push_back("open in " + holder);
    devices.push_back(std::move(found));
  }
}

std::vector<FoundDevice> list_cameras() {
  std::vector<FoundDevice> cameras;
  add_libcamera_cameras(cameras);
  add_v4l2_cameras(cameras);
  return cameras;
}

void add_gpio_chips(std::vector<FoundDevice>& devices) {
  for (const std::string& node : gpio_chip_nodes()) {
    auto chip = inspect_gpio_chip(node);
    if (!chip) {
      devices.push_back({DeviceKind::GpioChip, "", node, {}, {chip.error().message}});
      continue;
    }
    FoundDevice found{DeviceKind::GpioChip,
                      chip->name,
                      fmt::format("{} ({})", chip->label, counted(chip->lines.size(), "line")),
                      {},
                      {}};
    for (std::size_t i = 0; i < chip->lines.size(); ++i) {
      std::string line = describe(chip->lines[i], chip->name, i);
      if (!line.empty()) found.facts.push_back(std::move(line));
    }
    devices.push_back(std::move(found));
  }
}

void add_graphics(std::vector<FoundDevice>& devices) {
  const auto found = list_gpus();
  if (!found) {
    devices.push_back({DeviceKind::Graphics, "", "none through Vulkan", {}, {found.error().message}});
    return;
  }
  for (const GpuFacts& gpu : found.value()) {
    const bool usable = gpu.missing.empty();
    FoundDevice listed;
    listed.kind = DeviceKind::Graphics;
    listed.id = usable ? "vulkan:" + gpu.name : "";
    listed.title = fmt::format("{}{} device, Vulkan {}, {:.1f} GiB of its own", usable ? "" : gpu.name + ", ",
                               name(gpu.kind), gpu.api, gpu.memory_gib);
    if (gpu.kind == GpuKind::Software) listed.facts.emplace_back("computes on the processor: for tests");
    if (!usable) listed.missing = {gpu.missing};
    devices.push_back(std::move(listed));
  }
}

// A node of cameras that exists but may not be opened: libcamera lists no camera behind it.
std::optional<Error> closed_camera_node() {
  if (auto closed = closed_node(device_nodes("video"))) return closed;
  return closed_node(device_nodes("media"));
}

// Used when there is no camera.
std::string what_stands_in_the_way() {
  if (const auto closed = closed_camera_node()) return closed->message;
  return "connect one and see 'hdrcam list', or use --camera sim:SCENE";
}

Result<std::unique_ptr<Camera>> open_only_camera() {
  std::vector<std::string> usable;
  for (const FoundDevice& camera : list_cameras())
    if (!camera.id.empty()) usable.push_back(camera.id);
  if (usable.empty())
    return Error{ErrorCode::NotFound, fmt::format("there is no camera; {}", what_stands_in_the_way())};
  // The same camera may appear both in libcamera and as a node: libcamera's comes first and wins.
  const auto of_libcamera = std::count_if(
      usable.begin(), usable.end(), [](const std::string& id) { return id.starts_with(kLibcameraPrefix); });
  if (of_libcamera > 1 || (of_libcamera == 0 && usable.size() > 1))
    return Error{ErrorCode::Invalid, fmt::format("there are several cameras; choose one with --camera: {}",
                                                 fmt::join(usable, ", "))};
  return open_real_camera(usable.front());
}

}  // namespace

std::vector<FoundDevice> list_devices() {
  std::vector<FoundDevice> devices = list_cameras();
  add_gpio_chips(devices);
  add_graphics(devices);
  return devices;
}

Result<std::unique_ptr<Camera>> open_real_camera(const std::string& id) {
  if (id.empty()) return open_only_camera();
  if (id.starts_with("/dev/")) return open_v4l2_camera(id);
  const bool names_libcamera = id.starts_with(kLibcameraPrefix);
  auto camera = open_libcamera_camera(names_libcamera ? id.substr(std::string(kLibcameraPrefix).size()) : id);
  if (camera || camera.error().code != ErrorCode::NotFound) return camera;
  if (!names_libcamera && device_nodes("video").empty() && device_nodes("media").empty())
    return Error{ErrorCode::NotFound,
                 fmt::format("there is no camera '{}', nor any other; {}", id, what_stands_in_the_way())};
  if (const auto closed = closed_camera_node())
    return Error{ErrorCode::NotFound, fmt::format("{}; {}", camera.error().message, closed->message)};
  return camera;
}

}  // namespace hdrcam

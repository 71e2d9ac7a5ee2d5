#include "hal/real/media_graph.h"

#include <linux/media.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

namespace hdrcam {
namespace {

// linux/media.h has it as a shifted int
constexpr std::uint32_t kLinkType = 0xfu << 28;
static_assert(kLinkType == static_cast<std::uint32_t>(MEDIA_LNK_FL_LINK_TYPE));

namespace fs = std::filesystem;

struct Topology {
  std::vector<media_v2_entity> entities;
  std::vector<media_v2_interface> interfaces;
  std::vector<media_v2_pad> pads;
  std::vector<media_v2_link> links;
};

std::uint64_t pointer(auto& list) { return reinterpret_cast<std::uint64_t>(list.data()); }

Result<Topology> topology_of(const DeviceNode& media) {
  media_v2_topology sizes{};
  TRY(media.demand(MEDIA_IOC_G_TOPOLOGY, &sizes, "list its parts"));
  Topology found;
  found.entities.resize(sizes.num_entities), found.interfaces.resize(sizes.num_interfaces);
  found.pads.resize(sizes.num_pads), found.links.resize(sizes.num_links);
  sizes.ptr_entities = pointer(found.entities), sizes.ptr_interfaces = pointer(found.interfaces);
  sizes.ptr_pads = pointer(found.pads), sizes.ptr_links = pointer(found.links);
  TRY(media.demand(MEDIA_IOC_G_TOPOLOGY, &sizes, "list its parts"));
  return found;
}

bool carries_light(const media_v2_link& link) {
  return (link.flags & kLinkType) == MEDIA_LNK_FL_DATA_LINK && (link.flags & MEDIA_LNK_FL_ENABLED) != 0;
}

const media_v2_entity* entity_of(const Topology& graph, dev_t number) {
  for (const media_v2_interface& interface : graph.interfaces) {
    if (interface.devnode.major != major(number) || interface.devnode.minor != minor(number)) continue;
    for (const media_v2_link& link : graph.links)
      if ((link.flags & kLinkType) == MEDIA_LNK_FL_INTERFACE_LINK && link.source_id == interface.id)
        for (const media_v2_entity& entity : graph.entities)
          if (entity.id == link.sink_id) return &entity;
  }
  return nullptr;
}

// "/dev/v4l-subdev0"; empty for an entity without a node.
std::string node_of(const Topology& graph, std::uint32_t entity) {
  for (const media_v2_link& link : graph.links) {
    if ((link.flags & kLinkType) != MEDIA_LNK_FL_INTERFACE_LINK || link.sink_id != entity) continue;
    for (const media_v2_interface& interface : graph.interfaces) {
      if (interface.id != link.source_id) continue;
      std::error_code missing;
      const auto device = fs::canonical(
          fmt::format("/sys/dev/char/{}:{}", interface.devnode.major, interface.devnode.minor), missing);
      if (!missing) return "/dev/" + device.filename().string();
    }
  }
  return {};
}

// A source pad and everything that it feeds: a receiver starts only if all of these agree, unread branches
// included.
void note_pads(const Topology& graph, const media_v2_pad& source, std::vector<SubdevicePad>& path) {
  const auto note = [&](const media_v2_pad& pad) {
    const std::string node = node_of(graph, pad.entity_id);
    if (node.starts_with("/dev/v4l-subdev")) path.push_back({node, pad.index});
  };
  note(source);
  for (const media_v2_link& link : graph.links) {
    if (link.source_id != source.id || !carries_light(link)) continue;
    for (const media_v2_pad& sink : graph.pads)
      if (sink.id == link.sink_id) note(sink);
  }
}

// Walks upstream from an entity to a sensor and lists the pads in downstream order.
bool find_sensor(const Topology& graph, const media_v2_entity& from, MediaGraph& found, int depth = 0) {
  if (from.function == MEDIA_ENT_F_CAM_SENSOR) {
    found.sensor_name = from.name, found.sensor_node = node_of(graph, from.id);
    return !found.sensor_node.empty();
  }
  constexpr int kLongest = 16;
  if (depth > kLongest) return false;
  for (const media_v2_pad& sink : graph.pads) {
    if (sink.entity_id != from.id || (sink.flags & MEDIA_PAD_FL_SINK) == 0) continue;
    for (const media_v2_link& link : graph.links) {
      if (link.sink_id != sink.id || !carries_light(link)) continue;
      const auto source = std::find_if(graph.pads.begin(), graph.pads.end(),
                                       [&](const media_v2_pad& pad) { return pad.id == link.source_id; });
      if (source == graph.pads.end()) continue;
      const auto above = std::find_if(graph.entities.begin(), graph.entities.end(),
                                      [&](const media_v2_entity& e) { return e.id == source->entity_id; });
      if (above == graph.entities.end() || !find_sensor(graph, *above, found, depth + 1)) continue;
      note_pads(graph, *source, found.path);
      return true;
    }
  }
  return false;
}

}  // namespace

Result<std::optional<MediaGraph>> media_graph_of(const std::string& video_node,
                                                 const std::vector<std::string>& media_nodes) {
  struct stat status {};
  if (::stat(video_node.c_str(), &status) != 0) return device_error(errno, video_node, "find it");
  std::optional<Error> refused;
  for (const std::string& node : media_nodes) {
    auto media = DeviceNode::open(node);
    if (!media) {
      refused = media.error();
      continue;
    }
    const auto topology = topology_of(*media);
    if (!topology) continue;
    const Topology& graph = topology.value();
    const media_v2_entity* capture = entity_of(graph, status.st_rdev);
    if (capture == nullptr) continue;
    MediaGraph found;
    found.node = node;
    if (!find_sensor(graph, *capture, found)) found.path.clear();
    return std::optional<MediaGraph>(std::move(found));
  }
  if (refused) return *refused;
  return std::optional<MediaGraph>();
}

}  // namespace hdrcam

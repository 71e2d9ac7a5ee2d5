#ifdef HDRCAM_HAVE_VULKAN
#include "hal/gpu/vulkan/memory.h"

#include <fmt/format.h>

#include <algorithm>

namespace hdrcam::vulkan {
namespace {

constexpr VkDeviceSize kBlock = VkDeviceSize{16} << 20;
constexpr VkDeviceSize kAlignment = 256;  // the most that Vulkan lets a device ask for

}  // namespace

struct Memory::Block {
  const DeviceFunctions& vk;
  VkDevice device;
  MemoryUse use;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkBuffer buffer = VK_NULL_HANDLE;
  std::byte* mapped = nullptr;
  std::map<VkDeviceSize, VkDeviceSize> free;  // offset, bytes

  Block(const DeviceFunctions& functions, VkDevice of_device, MemoryUse used_for)
      : vk(functions), device(of_device), use(used_for) {}
  ~Block() {
    if (buffer != VK_NULL_HANDLE) vk.DestroyBuffer(device, buffer, nullptr);
    if (memory != VK_NULL_HANDLE) vk.FreeMemory(device, memory, nullptr);
  }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;

  void give_back(VkDeviceSize offset, VkDeviceSize bytes) {
    auto after = free.lower_bound(offset);
    if (after != free.end() && after->first == offset + bytes)
      bytes += after->second, after = free.erase(after);
    if (after != free.begin()) {
      const auto before = std::prev(after);
      if (before->first + before->second == offset) {
        before->second += bytes;
        return;
      }
    }
    free.emplace(offset, bytes);
  }
};

Memory::Range::~Range() { block_.give_back(offset_, room_); }
VkBuffer Memory::Range::handle() const { return block_.buffer; }
std::byte* Memory::Range::mapped() const { return block_.mapped + offset_; }

Memory::Memory(const DeviceFunctions& functions, VkDevice device,
               const VkPhysicalDeviceMemoryProperties& types, VkDeviceSize largest_range)
    : vk_(functions), device_(device), types_(types), largest_range_(largest_range) {}

Memory::~Memory() = default;

Result<std::unique_ptr<Memory::Range>> Memory::take(std::size_t bytes, MemoryUse use) {
  const VkDeviceSize room = (std::max<VkDeviceSize>(bytes, 1) + kAlignment - 1) / kAlignment * kAlignment;
  if (room > largest_range_)
    return Error{ErrorCode::Unsupported,
                 fmt::format("the graphics device lets a kernel see {} MiB at once, {} are needed",
                             largest_range_ >> 20, room >> 20)};
  const auto carve = [&](Block& block) -> std::unique_ptr<Range> {
    for (auto hole = block.free.begin(); hole != block.free.end(); ++hole) {
      const auto [offset, size] = *hole;
      if (size < room) continue;
      block.free.erase(hole);
      if (size > room) block.free.emplace(offset + room, size - room);
      return std::make_unique<Range>(block, offset, room, bytes);
    }
    return nullptr;
  };
  for (const auto& block : blocks_)
    if (block->use == use)
      if (auto range = carve(*block)) return range;
  return carve(*TRY(add_block(std::max(room, kBlock), use)));
}

Result<Memory::Block*> Memory::add_block(VkDeviceSize bytes, MemoryUse use) {
  const std::string doing = fmt::format("taking {} MiB of graphics memory", bytes >> 20);
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = bytes;
  info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  if (use == MemoryUse::Compute)
    info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
  info.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  auto block = std::make_unique<Block>(vk_, device_, use);
  if (const VkResult made = vk_.CreateBuffer(device_, &info, nullptr, &block->buffer); made != VK_SUCCESS)
    return failed(made, doing);
  VkMemoryRequirements needs{};
  vk_.GetBufferMemoryRequirements(device_, block->buffer, &needs);
  VkMemoryAllocateInfo allocation{};
  allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  allocation.allocationSize = needs.size;
  const int type = type_for(needs.memoryTypeBits, use);
  VkResult done = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  if (type >= 0) {
    allocation.memoryTypeIndex = static_cast<std::uint32_t>(type);
    done = vk_.AllocateMemory(device_, &allocation, nullptr, &block->memory);
  }
  if (done == VK_SUCCESS) done = vk_.BindBufferMemory(device_, block->buffer, block->memory, 0);
  if (done == VK_SUCCESS && use == MemoryUse::Staging)
    done =
        vk_.MapMemory(device_, block->memory, 0, VK_WHOLE_SIZE, 0, reinterpret_cast<void**>(&block->mapped));
  if (done != VK_SUCCESS) return failed(done, doing);
  block->free.emplace(0, bytes);
  blocks_.push_back(std::move(block));
  return blocks_.back().get();
}

// The first type that has what is needed and, if any does, what is wanted beside it.
int Memory::type_for(std::uint32_t allowed, MemoryUse use) const {
  constexpr VkMemoryPropertyFlags kSeen =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const bool staging = use == MemoryUse::Staging;
  const VkMemoryPropertyFlags needed = staging ? kSeen : VkMemoryPropertyFlags{0};
  const VkMemoryPropertyFlags wanted =
      needed | (staging ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  for (const VkMemoryPropertyFlags flags : {wanted, needed})
    for (std::uint32_t i = 0; i < types_.memoryTypeCount; ++i)
      if ((allowed >> i & 1) != 0 && (types_.memoryTypes[i].propertyFlags & flags) == flags)
        return static_cast<int>(i);
  return -1;
}

}  // namespace hdrcam::vulkan
#endif

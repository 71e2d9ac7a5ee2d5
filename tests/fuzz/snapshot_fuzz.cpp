// A snapshot of a scene of anybody, as it is and with its checksums put right: what is loaded can be filmed.
#include <zlib.h>

#include <cstring>
#include <vector>

#include "firmware_host/film/virtual_camera.h"
#include "tests/fuzz/memory_storage.h"

using namespace hdrcam;

namespace {

void load_and_film(std::span<const std::uint8_t> bytes) {
  fuzz::MemoryStorage storage(bytes);
  auto scene = load_scene(storage, "s.hdrscene");
  if (!scene) return;
  HDRCAM_CHECK(check_scene(storage, "s.hdrscene").ok());
  FilmOptions options;
  options.view = "0.1,0,0,5,0,0";
  options.size = "32x24";
  auto plan = plan_film(storage, options, {}, filmed(*scene));
  if (!plan) return;
  plan->frames = 1;
  WorkerPool pool(1);
  VirtualCamera camera(*plan, std::nullopt, pool);
  camera.take(*scene);
  HDRCAM_CHECK(
      camera.finish([](HdrFrame&, const ExposedFrame&, const FrameRecord&) { return Result<void>(); }).ok());
}

// Behind checksums that are wrong no value would ever be read.
void mend(std::vector<std::uint8_t>& bytes) {
  constexpr std::size_t kFirst = 12, kHead = 32, kLength = 16, kContentCrc = 24, kHeadCrc = 28;
  for (std::size_t at = kFirst; at + kHead <= bytes.size();) {
    std::uint8_t* const head = bytes.data() + at;
    std::uint64_t length = 0;
    std::memcpy(&length, head + kLength, sizeof length);
    if (length > bytes.size() - at - kHead) return;
    const auto set = [](std::uint8_t* to, const std::uint8_t* from, std::size_t size) {
      const auto crc = static_cast<std::uint32_t>(crc32_z(0, from, size));
      std::memcpy(to, &crc, sizeof crc);
    };
    set(head + kContentCrc, head + kHead, static_cast<std::size_t>(length));
    set(head + kHeadCrc, head, kHeadCrc);
    at += kHead + static_cast<std::size_t>(length);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  load_and_film(std::span(data, size));
  std::vector<std::uint8_t> mended(data, data + size);
  mend(mended);
  load_and_film(mended);
  return 0;
}

// A snapshot of a scene of anybody: what is loaded can be filmed.
#include "firmware_host/film/virtual_camera.h"
#include "tests/fuzz/memory_storage.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::MemoryStorage storage(std::span(data, size));
  auto scene = load_scene(storage, "s.hdrscene");
  if (!scene) return 0;
  CHECK(check_scene(storage, "s.hdrscene").ok());
  FilmOptions options;
  options.view = "0.1,0,0,5,0,0";
  options.size = "32x24";
  auto plan = plan_film(storage, options, {}, filmed(*scene));
  if (!plan) return 0;
  plan->frames = 1;
  WorkerPool pool(1);
  VirtualCamera camera(*plan, std::nullopt, pool);
  camera.take(*scene);
  CHECK(
      camera.finish([](HdrFrame&, const ExposedFrame&, const FrameRecord&) { return Result<void>(); }).ok());
  return 0;
}

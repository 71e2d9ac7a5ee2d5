// A PNG of whatever size its header says, up to 256 pixels a side.
#include "hal/recording/png_image.h"
#include "tests/fuzz/memory_storage.h"

using namespace hdrcam;

namespace {

// A big-endian number of the header, 0 where there is none.
int side_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  constexpr int kMost = 256;
  if (bytes.size() < at + 4 || bytes[at] != 0 || bytes[at + 1] != 0) return 1;
  return std::min(kMost, bytes[at + 2] << 8 | bytes[at + 3]);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::MemoryStorage storage({data, size});
  const int cols = side_at({data, size}, 16), rows = side_at({data, size}, 20);
  const auto image = read_png(storage, "x.png", cols, rows);
  if (image)
    HDRCAM_CHECK_EQ(image.value().samples.plane_size(),
                    static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows));
  return 0;
}

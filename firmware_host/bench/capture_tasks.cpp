#include "firmware_host/bench/kernel_task_groups.h"

#include <memory>

#include "capture/demosaic.h"

namespace hdrcam {

void add_capture(KernelTasks& tasks, int rows, int cols) {
  struct Room {
    Image<std::uint16_t> mosaic;
    Image<float> rgb;
  };
  const auto room = std::make_shared<Room>(Room{{1, rows, cols}, {3, rows, cols}});
  Pcg32 random(1);
  for (std::uint16_t& code : room->mosaic.samples()) code = static_cast<std::uint16_t>(random.next() & 0xfff);
  // green 20 on each line of which half are kept, a colour 5 in its own row and 14 in the other, the end 2
  // each
  constexpr PixelWork kDemosaicing{.flops = 20 + 5 + 14 + 3 * 2, .bytes = 2 + 3 * 4};
  add_picture_kernel(tasks, "demosaicing", static_cast<double>(rows) * cols, kDemosaicing, [room] {
    demosaic(room->mosaic, PixelLayout::BayerRggb, 4095, room->rgb, 255.f / 4095);
  });
}

}  // namespace hdrcam

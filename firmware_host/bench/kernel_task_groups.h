// The groups that kernel_tasks() joins, and what they are made with. Thread-bound.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "firmware_host/bench/kernel_tasks.h"
#include "hal/core/image.h"
#include "online/scene/hash_grid/field/random.h"

namespace hdrcam {

// Planes of one size with numbers in a range.
class RandomPlanes {
 public:
  RandomPlanes(int count, int rows, int cols, float low, float high, std::uint64_t seed)
      : values_(count, rows, cols) {
    Pcg32 random(seed);
    for (float& v : values_.samples()) v = random.uniform(low, high);
  }
  float* row(int plane, int y) { return values_.row(plane, y); }
  float* plane(int plane) { return values_.plane(plane); }
  void fill(int plane, float value) { std::fill_n(values_.plane(plane), values_.plane_size(), value); }

 private:
  Image<float> values_;
};

using KernelTasks = std::vector<KernelTask>;

// What a kernel does for one pixel, counted as in kernel_tasks.h.
struct PixelWork {
  double flops = 0, bytes = 0, look_ups = 0;
};

// Adds a kernel over a picture; memory is touched once a run.
template <class Run>
void add_picture_kernel(KernelTasks& tasks, std::string name, double pixels, const PixelWork& each,
                        Run&& run) {
  KernelTask task;
  task.name = std::move(name), task.item = "px", task.items = pixels;
  task.flops = each.flops, task.bytes = each.bytes, task.look_ups = each.look_ups;
  task.footprint = pixels * each.bytes;
  task.run = std::forward<Run>(run);
  tasks.push_back(std::move(task));
}

// The same of a kernel that takes planes of floats. planes: read or written.
struct PlaneWork {
  double flops = 0;
  int planes = 0;
};

// Adds a kernel that takes a picture row by row: row(y).
template <class Row>
void add_rows(KernelTasks& tasks, std::string name, int rows, int cols, const PlaneWork& each, Row&& row) {
  add_picture_kernel(tasks, std::move(name), static_cast<double>(rows) * cols,
                     {.flops = each.flops, .bytes = static_cast<double>(sizeof(float)) * each.planes},
                     [rows, row = std::forward<Row>(row)] {
                       for (int y = 0; y < rows; ++y) row(y);
                     });
}

// rows, cols: of the pictures. Each appends its kernels.
void add_capture(KernelTasks& tasks, int rows, int cols);    // raw codes become colours
void add_pictures(KernelTasks& tasks, int rows, int cols);   // warps, windows, blur
void add_state(KernelTasks& tasks, int rows, int cols);      // the steps of the fusion
void add_shrinkage(KernelTasks& tasks, int rows, int cols);  // of what is emitted
void add_motion(KernelTasks& tasks, int rows, int cols);     // flow, and what bridges a clipped frame
void add_window(KernelTasks& tasks, int rows, int cols);     // what the field is given of a frame
void add_field(KernelTasks& tasks);                          // one evaluation and one step of the fit

}  // namespace hdrcam

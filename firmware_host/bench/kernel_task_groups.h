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

// Adds a kernel that takes a picture row by row: row(y). planes: read or written.
template <class Row>
void add_rows(KernelTasks& tasks, std::string name, int rows, int cols, double flops, int planes, Row&& row) {
  KernelTask task;
  task.name = std::move(name), task.item = "px";
  task.items = static_cast<double>(rows) * cols;
  task.flops = flops, task.bytes = 4.0 * planes;
  task.footprint = task.items * task.bytes;
  task.run = [rows, row = std::forward<Row>(row)] {
    for (int y = 0; y < rows; ++y) row(y);
  };
  tasks.push_back(std::move(task));
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

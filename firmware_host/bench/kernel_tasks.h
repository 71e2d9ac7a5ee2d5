// Every kernel of the method on one thread, on pictures and networks of the usual sizes: what it works on,
// and how much that is. Flops and bytes are counted in the source: a multiplication, an addition, a division
// and a root are one each; a plane that is read or written once counts once. Thread-bound.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace hdrcam {

struct KernelTask {
  std::string name;
  std::string item;      // what is counted: px, look-ups, flop, parameters, patches
  double items = 0;      // of one run
  double flops = 0;      // of one item; 0: not counted, because it depends on the picture
  double bytes = 0;      // of one item
  double look_ups = 0;   // of one item
  double footprint = 0;  // bytes that one run touches
  std::function<void()> run;
};

// rows, cols: of the pictures.
std::vector<KernelTask> kernel_tasks(int rows, int cols);

}  // namespace hdrcam

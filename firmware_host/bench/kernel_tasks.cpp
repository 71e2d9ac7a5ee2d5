#include "firmware_host/bench/kernel_tasks.h"

#include "firmware_host/bench/kernel_task_groups.h"

namespace hdrcam {

std::vector<KernelTask> kernel_tasks(int rows, int cols) {
  KernelTasks tasks;
  add_capture(tasks, rows, cols);
  add_motion(tasks, rows, cols);
  add_state(tasks, rows, cols);
  add_pictures(tasks, rows, cols);
  add_shrinkage(tasks, rows, cols);
  add_window(tasks, rows, cols);
  add_field(tasks);
  return tasks;
}

}  // namespace hdrcam

// A graphics device that fails when it is told to: its memory is full, its compiler refuses a kernel, it is
// lost in the middle of work, or it says that it is of another kind. All else is the wrapped device's. For
// tests of what goes on without it. Thread-bound; the wrapped device outlives it.
#pragma once

#include <limits>
#include <optional>

#include "hal/gpu/gpu_device.h"

namespace hdrcam {

struct GpuFaults {
  static constexpr int kNever = std::numeric_limits<int>::max();
  int buffers_until_full = kNever;     // that can be made before NoSpace
  int kernels_until_refused = kNever;  // that can be had before NoSpace
  int finishes_until_lost = kNever;    // that succeed before Unplugged, which it then is for good
  std::optional<GpuKind> kind = {};    // default: the wrapped device's
};

class FaultyGpu final : public GpuDevice {
 public:
  FaultyGpu(GpuDevice& device, const GpuFaults& faults)
      : device_(device), facts_(device.facts()), left_(faults), work_(*this) {
    if (faults.kind) facts_.kind = *faults.kind;
  }

  const GpuFacts& facts() const override { return facts_; }
  Result<std::unique_ptr<GpuBuffer>> buffer(std::size_t bytes) override {
    if (left_.buffers_until_full-- <= 0)
      return Error{ErrorCode::NoSpace, "graphics memory is full, as it was told to be"};
    return device_.buffer(bytes);
  }
  Result<const GpuKernel*> kernel(const GpuShader& shader) override {
    if (left_.kernels_until_refused-- <= 0)
      return Error{ErrorCode::NoSpace, "the compiler has no memory, as it was told"};
    return device_.kernel(shader);
  }
  GpuWork& work() override { return work_; }

 private:
  class Work final : public GpuWork {
   public:
    explicit Work(FaultyGpu& owner) : owner_(owner) {}
    using GpuWork::download, GpuWork::run, GpuWork::upload;
    void upload(std::span<const std::byte> from, const GpuBuffer& to, std::size_t at) override {
      inner().upload(from, to, at);
    }
    void copy(const GpuBuffer& from, const GpuBuffer& to) override { inner().copy(from, to); }
    void clear(const GpuBuffer& buffer) override { inner().clear(buffer); }
    void run(const GpuKernel& kernel, std::span<const GpuBuffer* const> buffers,
             std::span<const std::byte> constants, const GpuGrid& grid) override {
      inner().run(kernel, buffers, constants, grid);
    }
    void download(const GpuBuffer& from, std::size_t at, std::span<std::byte> to) override {
      // what a lost device would have sent never arrives
      if (owner_.left_.finishes_until_lost > 0) inner().download(from, at, to);
    }
    void carry_with(WorkerPool* pool) override { inner().carry_with(pool); }
    void measure(GpuStepTimes* times) override { inner().measure(times); }
    Result<void> finish() override {
      const Result<void> done = inner().finish();
      if (owner_.left_.finishes_until_lost <= 0)
        return Error{ErrorCode::Unplugged, "the graphics device was lost, as it was told to be"};
      --owner_.left_.finishes_until_lost;
      return done;
    }

   private:
    GpuWork& inner() { return owner_.device_.work(); }
    FaultyGpu& owner_;
  };

  GpuDevice& device_;
  GpuFacts facts_;
  GpuFaults left_;
  Work work_;
};

}  // namespace hdrcam

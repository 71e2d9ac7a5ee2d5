// A graphics device as a place to compute: memory of its own, kernels that were compiled with the program
// (compute shaders in SPIR-V), and work that is recorded, handed over and waited for. Nothing here names the
// library behind it; hal/gpu/vulkan/ is the only implementation, hal/fault/faulty_gpu.h wraps one that fails.
// A device outlives its buffers and kernels. Thread-bound, but for users that take turns (GpuTurn).
//
// Errors of all calls: NotFound (no driver, no such device), Unsupported (a missing feature, a build without
// Vulkan), NoSpace (graphics memory is full), Unplugged (the device was lost), Timeout (it does not answer),
// Io (any other failure of the driver).
// After Unplugged or Timeout a device gives no more answers: who uses it goes on with the processor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "hal/core/result.h"

namespace hdrcam {

class WorkerPool;

inline constexpr int kMostKernelBuffers = 9;  // of a GpuShader; devices that allow fewer are not used

// A compute shader as the build made it. It reads and writes `buffers` storage buffers, bound from 0 on, and
// may read up to 128 bytes of constants. Work group sizes are a specialization constant (id 0), set by the
// device to suit its subgroups, but for kernels whose invocations work together.
struct GpuShader {
  const char* name;
  std::span<const std::uint32_t> code;
  int buffers;
  int group = 0;  // invocations that work together, at most 128 (its GROUP); 0: the device chooses
};

// The best first. A software device computes on the processor.
enum class GpuKind { Discrete, Integrated, Virtual, Software, Other };
const char* name(GpuKind kind);

struct GpuFacts {
  std::string name;  // as the driver says: "llvmpipe (LLVM 15.0.6, 256 bits)"
  GpuKind kind = GpuKind::Other;
  std::string api;        // "1.3.230"
  double memory_gib = 0;  // of its own heaps
  int subgroup = 0;       // lanes that run together; 0 where nobody said
  int group = 0;          // invocations of a work group of ours; 0 while it is only listed
  std::string missing;    // what keeps it from being used; "" where nothing does
};

// Elements of one run of a kernel: innermost first. The kernel leaves out what lies beyond.
struct GpuGrid {
  int columns = 1, rows = 1, planes = 1;
};

class GpuBuffer {
 public:
  virtual ~GpuBuffer() = default;
  virtual std::size_t bytes() const = 0;
};

class GpuKernel {
 public:
  virtual ~GpuKernel() = default;
};

// How long the device took for all runs of a kernel, or for all transfers of a kind: "upload", "download",
// "copy", "clear". What else the device did meanwhile counts, too.
struct GpuStepTime {
  double ms = 0;
  int times = 0;
};
using GpuStepTimes = std::map<std::string, GpuStepTime>;

// What GpuWork::upload() takes of numbers that lie one after the other: a vector, an array, a span.
template <class Numbers>
std::span<const std::byte> bytes_of_numbers(const Numbers& numbers) {
  return std::as_bytes(std::span(numbers));
}

// A list of steps, each of which sees what those before it have done. Nothing happens before finish().
class GpuWork {
 public:
  virtual ~GpuWork() = default;

  // The bytes are taken at once. at: of the buffer's bytes, the first that is written
  virtual void upload(std::span<const std::byte> from, const GpuBuffer& to, std::size_t at) = 0;
  virtual void copy(const GpuBuffer& from, const GpuBuffer& to) = 0;  // as many bytes as both have
  virtual void clear(const GpuBuffer& buffer) = 0;                    // to zeros
  virtual void run(const GpuKernel& kernel, std::span<const GpuBuffer* const> buffers,
                   std::span<const std::byte> constants, const GpuGrid& grid) = 0;
  // The bytes are there when finish() returns. at: of the buffer's bytes, the first that is read
  virtual void download(const GpuBuffer& from, std::size_t at, std::span<std::byte> to) = 0;
  // Hands everything over and waits for it. Whatever went wrong since the last call is said here; nothing
  // was downloaded then.
  virtual Result<void> finish() = 0;
  // From now on finish() adds the steps' times to `times`, until it is told null. Steps beyond a thousand
  // between two finish() are left out; a device without a clock leaves out all. Not between steps.
  virtual void measure(GpuStepTimes* times) = 0;
  // Whose threads carry what goes up and comes back: at 1920x1080 that takes longer than the kernels. Null:
  // the calling thread alone.
  virtual void carry_with(WorkerPool* pool) = 0;

  void upload(std::span<const std::byte> from, const GpuBuffer& to) { upload(from, to, 0); }
  void download(const GpuBuffer& from, std::span<std::byte> to) { download(from, 0, to); }
  // constants: a plain struct laid out as the shader's.
  template <class Constants>
  void run(const GpuKernel& kernel, std::initializer_list<const GpuBuffer*> buffers,
           const Constants& constants, const GpuGrid& grid) {
    static_assert(std::is_trivially_copyable_v<Constants> && sizeof(Constants) <= 128);
    run(kernel, std::span<const GpuBuffer* const>(buffers.begin(), buffers.size()),
        std::as_bytes(std::span(&constants, 1)), grid);
  }
};

class GpuDevice {
 public:
  virtual ~GpuDevice() = default;

  virtual const GpuFacts& facts() const = 0;
  virtual Result<std::unique_ptr<GpuBuffer>> buffer(std::size_t bytes) = 0;
  // Made once per shader and kept; later calls find it.
  virtual Result<const GpuKernel*> kernel(const GpuShader& shader) = 0;
  // The one list of steps, empty after finish().
  virtual GpuWork& work() = 0;

 private:
  friend class GpuTurn;
  std::mutex turn_;
};

// The kernels of a part in its order, or the first error. The calling thread has the turn.
template <std::size_t N>
Result<std::array<const GpuKernel*, N>> kernels_of(GpuDevice& device,
                                                   const std::array<GpuShader, N>& shaders) {
  std::array<const GpuKernel*, N> kernels{};
  for (std::size_t i = 0; i < N; ++i) kernels[i] = TRY(device.kernel(shaders[i]));
  return kernels;
}

// Held while a device is used where several threads do: from the first step, or the first buffer, to
// finish(). pool: of the calling thread, for what is carried meanwhile (GpuWork::carry_with).
class GpuTurn {
 public:
  explicit GpuTurn(GpuDevice& device, WorkerPool* pool = nullptr)
      : turn_(device.turn_), work_(device.work()) {
    work_.carry_with(pool);
  }
  ~GpuTurn() { work_.carry_with(nullptr); }
  GpuTurn(const GpuTurn&) = delete;
  GpuTurn& operator=(const GpuTurn&) = delete;

 private:
  std::lock_guard<std::mutex> turn_;
  GpuWork& work_;
};

struct GpuOptions {
  std::string name = {};          // "": the best there is; or a device's name or part of it, in any case
  std::string cache_folder = {};  // where compiled kernels are kept for the next start; "": nowhere
  // The library's own checks are asked for, and what they say is kept in `complaints`, which outlives the
  // device. Unsupported where they are not installed.
  std::vector<std::string>* complaints = nullptr;
};

// The best kind comes first; devices that cannot be used are passed over (find_gpu() of gpu_list.h).
Result<std::unique_ptr<GpuDevice>> open_gpu(const GpuOptions& options);

}  // namespace hdrcam

// The state's passes over pictures on a graphics device: one method per kernel, each with a twin on the
// processor (named beside it) and a test that compares the two. Pictures as state.glsl lays them out. A pass
// is recorded into the device's work; nothing runs before its finish(). Thread-bound; the device outlives it.
#pragma once

#include <array>
#include <vector>

#include "hal/gpu/gpu_picture.h"
#include "online/state/exposure_tables.h"
#include "online/state/state_filter.h"

namespace hdrcam {

// Planes of the pictures that passes share.
constexpr int kStatePlanes = 6;     // radiance rgb, variance rgb
constexpr int kSamplePlanes = 12;   // radiance, weight, comparable, blur; rgb each
constexpr int kMotionPlanes = 3;    // dx, dy, confidence
constexpr int kFoundPlanes = 2;     // chi^2, compared
constexpr int kResidualPlanes = 9;  // residual, variance, bin; rgb each

// What a code means and how noisy it is, in the device's memory.
struct GpuTables {
  std::unique_ptr<GpuBuffer> curves, excess;
  float exposure = 1, texture_error = 0, ringing = 0;
  bool doubts_textures = false;
  std::vector<float> staged;  // what curves becomes: its memory is used again

  static Result<GpuTables> make(GpuDevice& device);
  void take(const ExposureTables& tables, GpuWork& work);
};

// As Seen.
struct GpuSeen {
  const GpuPicture& state;    // RadianceState
  const GpuPicture& samples;  // Samples
  const GpuTables& tables;    // at the samples' exposure
  float unseen_variance;
};

// As Moved.
struct GpuMoved {
  const GpuPicture& contrast;
  const GpuPicture& motion;
  int intervals = 1;
  bool shorter = false;
};

// What the kernels of one pass leave to each other; nothing in it outlives the pass.
struct PassRoom {
  GpuPicture mean, guess, detail;  // rgb; detail: the local contrast of the guess
  GpuPicture logs;                 // [kStatePlanes] of a state whose radiance is its logarithm
  GpuPicture found, found_mean;    // [kFoundPlanes]

  static Result<PassRoom> make(GpuDevice& device, int rows, int cols);
};

class StatePasses {
 public:
  StatePasses() = default;  // none yet
  static Result<StatePasses> make(GpuDevice& device, const StateOptions& options);

  // warp_cubic, of rgb
  void warp(const GpuPicture& in, const GpuPicture& motion, const GpuPicture& out) const;
  // warp_radiance of a state's radiance, warp_linear of its variance
  void warp_state(const GpuPicture& in, const GpuPicture& motion, const PassRoom& room,
                  const GpuPicture& out) const;
  void box_mean(const GpuPicture& in, int radius, const GpuPicture& out) const;
  void local_contrast(const GpuPicture& in, const GpuPicture& mean, const GpuPicture& contrast) const;
  // Fusion::sample
  void sample(const GpuPicture& codes, const GpuPicture& brightest, const GpuTables& tables,
              const GpuPicture& samples) const;
  // Fusion::model_blur
  void model_blur(const GpuPicture& state, const GpuPicture& motion, float fraction,
                  const GpuPicture& samples) const;
  // Fusion::gate; motion: for its confidence; contrast: becomes the local contrast of the state
  void gate(const GpuSeen& seen, const GpuPicture& motion, const PassRoom& room, const GpuPicture& gate,
            const GpuPicture& contrast) const;
  // StateFilter's growth of the variance, Fusion::warp_variance in it
  void age(const GpuSeen& seen, const GpuMoved& moved, const GpuPicture& gate) const;
  // SampleResiduals::observe: what it looks at; found: [kResidualPlanes, lines, pixels of a line] of
  // kResidualSampling
  void residuals(const GpuSeen& seen, const GpuPicture& motion, const GpuPicture& found) const;
  // Fusion::update with a frame's own samples
  void update(const GpuSeen& seen, const PassRoom& room, const GpuPicture& share,
              SampleOrder order = SampleOrder::AfterFirst) const;
  // Fusion::update with a later frame's samples, whose gate and local contrast count; share is joined to
  void join(const GpuSeen& seen, const GpuPicture& gate, const GpuMoved& moved, const PassRoom& room,
            const GpuPicture& share) const;
  // The largest value around each place, as warp_cubic finds it; LookAhead: a path made longer
  void largest_around(const GpuPicture& in, const GpuPicture& motion, const GpuPicture& out) const;
  void follow(const GpuPicture& motion, const GpuPicture& path, const GpuPicture& longer) const;

 private:
  enum Pass : std::size_t {
    kLogRadiance,
    kWarp,
    kBoxMean,
    kLocalContrast,
    kSample,
    kBlur,
    kDisagreement,
    kGate,
    kAge,
    kResiduals,
    kGuess,
    kUpdate,
    kLargestAround,
    kFollow,
    kPasses
  };
  StatePasses(GpuDevice& device, const StateOptions& options) : device_(&device), options_(options) {}
  template <class Constants>
  void run(Pass pass, std::initializer_list<const GpuBuffer*> buffers, const Constants& constants,
           const GpuGrid& grid) const {
    device_->work().run(*kernels_[pass], buffers, constants, grid);
  }
  enum class Taking { First, Own, Later };  // samples: of the first frame, of a frame itself, of a later one
  void fuse(Taking taking, const GpuSeen& seen, const GpuPicture& gate, const GpuMoved& moved,
            const PassRoom& room, const GpuPicture& share) const;

  GpuDevice* device_ = nullptr;
  StateOptions options_;
  std::array<const GpuKernel*, kPasses> kernels_{};
};

}  // namespace hdrcam

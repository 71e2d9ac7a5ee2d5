// One HDR frame out of a moment: a copy of the state is joined by the look-ahead frames' samples (never fed
// back), what nobody saw stays a lower bound, and the result is shrunk with its known variance. Thread-bound.
#pragma once

#include "online/online_stage.h"
#include "render/hdr_frame.h"
#include "render/shrinkage.h"

namespace hdrcam {

enum class ShrinkageMode { Off, On };

struct EmissionOptions {
  ShrinkageMode shrinkage = ShrinkageMode::On;
};

class Emission {
 public:
  Emission(EmissionOptions options, WorkerPool& pool) : options_(options), pool_(pool), shrinkage_(pool) {}

  void render(const Moment& moment, HdrFrame& frame);
  // of the frame rendered last, before shrinkage: [rgb, rows, cols]
  const Image<float>& variance() const { return merged_.variance; }

 private:
  void join(const Moment& moment);
  void conclude(const Moment& moment, HdrFrame& frame);

  EmissionOptions options_;
  WorkerPool& pool_;
  Shrinkage shrinkage_;
  RadianceState merged_;
  Samples samples_;
  FlowField path_;  // from the emitted frame to the look-ahead frame at hand
  Image<float> ahead_share_, share_, codes_, brightest_, dilated_, gate_, mean_, contrast_, extra_, flow_,
      warped_;
};

}  // namespace hdrcam

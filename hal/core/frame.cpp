#include "hal/core/frame.h"

namespace hdrcam {

std::string called(const CameraFacts& camera) {
  return camera.name.empty() ? "the clip" : "'" + camera.name + "'";
}

const char* name(ExposureSource source) {
  switch (source) {
    case ExposureSource::Embedded:
      return "embedded";
    case ExposureSource::Reported:
      return "reported";
    case ExposureSource::Declared:
      return "declared";
    case ExposureSource::Predicted:
      return "predicted";
    case ExposureSource::Photometric:
      return "photometric";
    case ExposureSource::Estimated:
      return "estimated";
    case ExposureSource::Unknown:
      break;
  }
  return "unknown";
}

const char* name(Verdict verdict) {
  switch (verdict) {
    case Verdict::Proved:
      return "proved";
    case Verdict::Plausible:
      return "plausible";
    case Verdict::Estimated:
      return "estimated";
    case Verdict::Contradicted:
      return "contradicted";
    case Verdict::Unknown:
      break;
  }
  return "unknown";
}

const char* name(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::Rgb:
      return "rgb";
    case PixelLayout::Mono:
      return "mono";
    case PixelLayout::BayerRggb:
      return "rggb";
    case PixelLayout::BayerGrbg:
      return "grbg";
    case PixelLayout::BayerGbrg:
      return "gbrg";
    case PixelLayout::BayerBggr:
      return "bggr";
  }
  return "unknown";
}

}  // namespace hdrcam

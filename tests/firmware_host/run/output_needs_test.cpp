#include "firmware_host/run/output_needs.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("EXR files beside a camera are not compressed, others are, and the setting overrules both") {
  Settings::Output output;
  CHECK(compression_of(output, RunPace::Camera) == ExrCompression::None);
  CHECK(compression_of(output, RunPace::Clip) == ExrCompression::Piz);
  for (const auto& [asked, used] : {std::pair(FrameCompression::None, ExrCompression::None),
                                    {FrameCompression::Rle, ExrCompression::Rle},
                                    {FrameCompression::Zip, ExrCompression::Zip},
                                    {FrameCompression::Piz, ExrCompression::Piz}})
    for (const RunPace pace : {RunPace::Camera, RunPace::Clip}) {
      output.compression = asked;
      CHECK(compression_of(output, pace) == used);
    }
}

}  // namespace
}  // namespace hdrcam

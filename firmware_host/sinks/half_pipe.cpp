#include "firmware_host/sinks/half_pipe.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "render/half.h"

namespace hdrcam {
namespace {

class HalfPipe : public FrameSink {
 public:
  explicit HalfPipe(std::unique_ptr<StorageFile> pipe) : pipe_(std::move(pipe)) {}

  Result<void> emit(const EmittedFrame& frame) override {
    static_assert(std::endian::native == std::endian::little);
    const Image<float>& radiance = frame.hdr.radiance;
    if (written_ == 0) rows_ = radiance.rows(), cols_ = radiance.cols();
    if (radiance.rows() != rows_ || radiance.cols() != cols_)
      return Error{ErrorCode::SizeChanged,
                   fmt::format("frame {} has {}x{} pixels, and the stream {}x{}; give frames of one size",
                               frame.hdr.facts.sequence, radiance.cols(), radiance.rows(), cols_, rows_)};
    const std::size_t n = radiance.plane_size();
    samples_.resize(3 * n);
    for (int c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < n; ++i)
        samples_[3 * i + static_cast<std::size_t>(c)] = as_half(radiance.plane(c)[i]).bits();
    const auto bytes = std::as_bytes(std::span(samples_));
    TRY(pipe_->write_at(written_, bytes));
    written_ += bytes.size();
    return {};
  }

 private:
  std::unique_ptr<StorageFile> pipe_;
  std::uint64_t written_ = 0;
  int rows_ = 0, cols_ = 0;  // of all frames: nothing in the stream tells another size
  std::vector<std::uint16_t> samples_;
};

}  // namespace

std::unique_ptr<FrameSink> create_half_pipe(std::unique_ptr<StorageFile> pipe) {
  return std::make_unique<HalfPipe>(std::move(pipe));
}

}  // namespace hdrcam

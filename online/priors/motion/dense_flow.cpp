#include "online/priors/motion/dense_flow.h"

#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>

namespace hdrcam {

struct DenseFlow::Engine {
  cv::Ptr<cv::DISOpticalFlow> dis;
  cv::Mat interleaved;

  explicit Engine(FlowQuality quality) {
    dis = cv::DISOpticalFlow::create(quality == FlowQuality::Fast ? cv::DISOpticalFlow::PRESET_FAST
                                                                  : cv::DISOpticalFlow::PRESET_MEDIUM);
    if (quality == FlowQuality::Fine) {
      // the finest scale helps where motion changes; from a good start half the steps suffice
      constexpr int kDescentSteps = 12;
      dis->setFinestScale(0);
      dis->setGradientDescentIterations(kDescentSteps);
    }
  }

  void compute(const FlowRequest& request) {
    const int rows = request.from->rows(), cols = request.from->cols();
    request.flow->reshape(2, rows, cols);
    if (rows < kMinSize || cols < kMinSize) {
      request.flow->fill(0);
      return;
    }
    const auto view = [&](const Image<std::uint8_t>& image) {
      return cv::Mat(rows, cols, CV_8U, const_cast<std::uint8_t*>(image.plane(0)));
    };
    // Its content is the start of DIS. It is always given, because without it DIS starts from the previous
    // estimate.
    interleaved.create(rows, cols, CV_32FC2);
    interleaved.setTo(0);
    if (request.start != nullptr) {
      for (int y = 0; y < rows; ++y) {
        auto* out = interleaved.ptr<cv::Vec2f>(y);
        const float *dx = request.start->row(0, y), *dy = request.start->row(1, y);
        for (int x = 0; x < cols; ++x) out[x] = {dx[x], dy[x]};
      }
    }
    dis->calc(view(*request.from), view(*request.to), interleaved);
    for (int y = 0; y < rows; ++y) {
      const auto* in = interleaved.ptr<cv::Vec2f>(y);
      float *dx = request.flow->row(0, y), *dy = request.flow->row(1, y);
      for (int x = 0; x < cols; ++x) dx[x] = in[x][0], dy[x] = in[x][1];
    }
  }
};

DenseFlow::DenseFlow(WorkerPool& pool) : pool_(pool) {
  cv::setNumThreads(1);  // OpenCV's partition of the work would depend on the number of threads
}

DenseFlow::~DenseFlow() = default;

void DenseFlow::compute(FlowQuality quality, std::initializer_list<FlowRequest> requests) {
  auto& engines = engines_[static_cast<std::size_t>(quality)];
  while (engines.size() < requests.size()) engines.push_back(std::make_unique<Engine>(quality));
  pool_.for_each(static_cast<int>(requests.size()),
                 [&](int i) { engines[static_cast<std::size_t>(i)]->compute(requests.begin()[i]); });
}

}  // namespace hdrcam

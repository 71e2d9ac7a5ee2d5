#include "online/priors/motion/dense_flow.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a search that starts from a guess stays with it where the picture repeats itself") {
  constexpr int kRows = 64, kCols = 96, kPeriod = 12, kShift = 3;
  const auto stripes = [](int shift) {
    Image<std::uint8_t> picture(1, kRows, kCols);
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x)
        picture.at(0, y, x) =
            static_cast<std::uint8_t>(128 + 90 * std::sin(2 * 3.14159265 * (x - shift) / kPeriod));
    return picture;
  };
  WorkerPool pool(1);
  DenseFlow flow(pool);
  const Image<std::uint8_t> from = stripes(0), to = stripes(kShift);
  Image<float> found, start(2, kRows, kCols);
  flow.compute(FlowQuality::Fine, {{&from, &to, &found}});
  const float unguided = found.at(0, 32, 48);  // one of many shifts that fit
  std::fill_n(start.plane(0), start.plane_size(), static_cast<float>(kShift + kPeriod));
  flow.compute(FlowQuality::Fine, {{&from, &to, &found, &start}});
  CHECK(found.at(0, 32, 48) == Approx(kShift + kPeriod).margin(0.5));
  // a guess is not remembered
  flow.compute(FlowQuality::Fine, {{&from, &to, &found}});
  CHECK(found.at(0, 32, 48) == unguided);
}

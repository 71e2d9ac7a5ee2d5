#include "render/emission.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a lamp that every frame clips is emitted at its bound at least, however dark it is around it") {
  constexpr int kSize = 24;
  constexpr float kBound = 4, kUnseenFrom = 10;
  const int y = GENERATE(0, 11), x = 10;
  WorkerPool pool(2);
  ExposedFrame input;
  RadianceEstimate state{Image<float>(3, kSize, kSize), Image<float>(3, kSize, kSize)};
  Image<float> own_share(1, kSize, kSize);
  state.radiance.fill(1e-3f), state.variance.fill(1e-6f);
  own_share.fill(1);
  for (int c = 0; c < 2; ++c)
    state.radiance.at(c, y, x) = kBound, state.variance.at(c, y, x) = kUnseenVariance;
  const FrameEstimate estimate{.frame = input,
                               .state = state,
                               .own_share = own_share,
                               .to_previous = nullptr,
                               .field = {},
                               .view = {},
                               .fit = nullptr,
                               .budget = {},
                               .white = kBound,
                               .unseen_variance = kUnseenFrom,
                               .reference_exposure = 1};
  HdrFrame frame;
  Emission(pool).render(estimate, frame);
  CHECK(frame.provenance.at(0, y, x) == static_cast<std::uint8_t>(Provenance::Bound));
  for (int c = 0; c < 2; ++c) CHECK(frame.radiance.at(c, y, x) >= kBound);
  CHECK(frame.radiance.at(2, y, x) < kBound / 2);  // what was seen is shrunk as ever
  CHECK(frame.radiance.at(0, y, x + 2) < kBound / 2);
}

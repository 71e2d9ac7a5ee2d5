// What the fit does with a step that went wrong, seen in the parameters that it leaves behind.
#include <limits>

#include "tests/online/scene/hash_grid/fit/fit_stream.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// Every parameter of both branches, in a row.
std::vector<float> parameters(const FieldFit& fit) {
  std::vector<float> all;
  const FieldNetworks<float>& networks = fit.field().networks;
  for (const Branch<float>* branch : {&networks.static_, &networks.dynamic}) {
    const auto tables = branch->grid.tables().samples();
    const auto network = branch->mlp.parameters();
    all.insert(all.end(), tables.begin(), tables.end());
    all.insert(all.end(), network.begin(), network.end());
  }
  return all;
}

float largest_change(const std::vector<float>& before, const std::vector<float>& after) {
  float most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) most = std::max(most, std::abs(after[i] - before[i]));
  return most;
}

struct Stream {
  WorkerPool pool{1};
  FitStream scene;
  FieldFit fit;
  explicit Stream(const FieldOptions& options) : fit(options, {}, scene.rows, scene.cols, pool) {
    fit.prepare(FitStream::small_budget());
  }
};

}  // namespace

TEST_CASE("a step moves parameters of both branches", "[isa][field]") {
  Stream stream(FitStream::small_options());
  for (int i = 0; i < 3; ++i) REQUIRE(stream.fit.observe(stream.scene.frame(i), stream.scene.response).ok());
  const FieldNetworks<float>& networks = stream.fit.field().networks;
  const auto network_of = [](const Branch<float>& branch) {
    return std::vector<float>(branch.mlp.parameters().begin(), branch.mlp.parameters().end());
  };
  const auto static_before = network_of(networks.static_), dynamic_before = network_of(networks.dynamic);
  REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
  CHECK(network_of(networks.static_) != static_before);
  CHECK(network_of(networks.dynamic) != dynamic_before);
}

TEST_CASE("a step that is not a number changes no parameter, and is counted", "[isa][field][stability]") {
  FieldOptions options = FitStream::small_options();
  // the loss of every ray, and every gradient with it
  options.losses[static_cast<std::size_t>(LossTerm::Combined)] = std::numeric_limits<float>::quiet_NaN();
  Stream stream(options);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(stream.fit.observe(stream.scene.frame(i), stream.scene.response).ok());
    const std::vector<float> before = parameters(stream.fit);
    for (int s = 0; s < 5; ++s) REQUIRE(stream.fit.step().verdict == StepVerdict::Skipped);
    CHECK(parameters(stream.fit) == before);
  }
  CHECK(stream.fit.counts().skipped == 15);
}

TEST_CASE("a step whose loss explodes takes the parameters back to where the frame began",
          "[isa][field][stability]") {
  FieldOptions options = FitStream::small_options();
  options.losses[static_cast<std::size_t>(LossTerm::TemporalSmoothness)] = 0.1f;
  Stream stream(options);
  // In a small patch of one frame both flows lead 300 pixels to the right: a ray there, and only there, finds
  // motion that is as far from uniform as it can be.
  constexpr int kWild = 4, kPatch = 6;
  const auto spoil = [](Image<float>& flow) {
    for (int y = 20; y < 20 + kPatch; ++y)
      for (int x = 2; x < 2 + kPatch; ++x) flow.at(0, y, x) = 300;
  };
  for (int i = 0; i <= kWild + 1; ++i) {
    const FieldObservation seen = stream.scene.frame(i);
    if (i == kWild) spoil(stream.scene.to_previous.vectors);
    if (i == kWild + 1) spoil(stream.scene.from_previous.vectors);
    REQUIRE(stream.fit.observe(seen, stream.scene.response).ok());
    if (i < kWild)
      for (int s = 0; s < 20; ++s) REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
  }
  const std::vector<float> kept = parameters(stream.fit);
  int taken = 0;
  for (; taken < 500; ++taken)
    if (stream.fit.step().verdict != StepVerdict::Taken) break;
  INFO(taken << " steps taken before the loss exploded");
  REQUIRE(stream.fit.counts().rolled_back == 1);
  REQUIRE(taken > 0);  // so that there was something to take back
  CHECK(parameters(stream.fit) == kept);
}

TEST_CASE("a fit whose good copy explodes again and again starts its networks anew, and goes on",
          "[isa][field][stability]") {
  FieldOptions options = FitStream::small_options();
  options.losses[static_cast<std::size_t>(LossTerm::TemporalSmoothness)] = 0.1f;
  Stream stream(options);
  for (int i = 0; i < 7; ++i) {
    const FieldObservation seen = stream.scene.frame(i);
    // two frames whose flow leads 300 pixels away, everywhere
    if (i == 4) std::fill_n(stream.scene.to_previous.vectors.plane(0), 32 * 48, 300.f);
    if (i == 5) std::fill_n(stream.scene.from_previous.vectors.plane(0), 32 * 48, 300.f);
    REQUIRE(stream.fit.observe(seen, stream.scene.response).ok());
    if (i < 4)
      for (int s = 0; s < 20; ++s) REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
  }
  const std::vector<float> learned = parameters(stream.fit);
  for (int s = 0; s < FitHealth::kPatience; ++s)
    REQUIRE(stream.fit.step().verdict == StepVerdict::RolledBack);
  CHECK(stream.fit.counts().restarted == 1);
  CHECK(parameters(stream.fit) != learned);
  // what was usual is forgotten: steps are taken again, small ones first, and stay numbers
  for (int i = 7; i < 16; ++i) {
    REQUIRE(stream.fit.observe(stream.scene.frame(i), stream.scene.response).ok());
    if (i == 7) {
      constexpr float kWarmUp = 20;  // steps
      const std::vector<float> before = parameters(stream.fit);
      REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
      CHECK(largest_change(before, parameters(stream.fit)) < 1.01f * options.table_rate / kWarmUp);
    }
    for (int s = 0; s < 10; ++s) REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
  }
  for (const float p : parameters(stream.fit)) REQUIRE(std::isfinite(p));
  CHECK(stream.fit.counts().restarted == 1);
}

TEST_CASE("a fit that starts anew refines its response as in a first step", "[isa][field]") {
  FieldOptions options = FitStream::small_options();
  options.fits_response = true;
  Stream stream(options);
  for (int i = 0; i < 4; ++i) {
    REQUIRE(stream.fit.observe(stream.scene.frame(i), stream.scene.response).ok());
    for (int s = 0; s < 10; ++s) REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
  }
  stream.fit.restart();
  REQUIRE(stream.fit.observe(stream.scene.frame(4), stream.scene.response).ok());
  LearnedResponse<float> before = stream.fit.response();
  REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
  LearnedResponse<float> after = stream.fit.response();
  int moved = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < LearnedResponse<float>::kSegments; ++j) {
      const float change = std::abs(after.increments()[c][j] - before.increments()[c][j]);
      if (change == 0) continue;
      CHECK(change ==
            Approx(options.response_rate).epsilon(0.02));  // Adam's first step, whatever the gradient
      ++moved;
    }
  CHECK(moved > 100);
}

TEST_CASE("a fit that refines its response takes the estimate again where that is learned anew",
          "[isa][field]") {
  FieldOptions options = FitStream::small_options();
  options.fits_response = true;
  Stream stream(options);
  const auto points_of = [](const LearnedResponse<float>& response) {
    std::vector<float> points;
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < LearnedResponse<float>::kPoints; ++j) points.push_back(response.point(c, j));
    return points;
  };
  for (int i = 0; i < 4; ++i) {
    REQUIRE(stream.fit.observe(stream.scene.frame(i), stream.scene.response).ok());
    for (int s = 0; s < 10; ++s) REQUIRE(stream.fit.step().verdict == StepVerdict::Taken);
  }
  const std::vector<float> refined = points_of(stream.fit.response());
  CHECK(refined != points_of(LearnedResponse<float>(stream.scene.response)));
  stream.fit.restart();
  REQUIRE(stream.fit.observe(stream.scene.frame(4), stream.scene.response).ok());
  CHECK(points_of(stream.fit.response()) == refined);
  const Response other = Response::gamma(1.4f);
  REQUIRE(stream.fit.observe(stream.scene.frame(5), other).ok());
  CHECK(points_of(stream.fit.response()) == points_of(LearnedResponse<float>(other)));
}

TEST_CASE("the response stays monotone, from 0 to 1, after every refinement", "[isa][field][stability]") {
  FieldOptions options = FitStream::small_options();
  options.fits_response = true;
  options.response_rate = 1e-2f;  // as quick as it may be set
  Stream stream(options);
  const LearnedResponse<float>& learned = stream.fit.response();
  float moved = 0;
  for (int i = 0; i < 12; ++i) {
    // codes that no monotone curve explains: every other frame is labelled with a wrong exposure
    FieldObservation seen = stream.scene.frame(i);
    if (i % 2 == 1) seen.exposure *= 6;
    REQUIRE(stream.fit.observe(seen, stream.scene.response).ok());
    for (int s = 0; s < 10; ++s) {
      const float before = learned.point(1, 128);
      stream.fit.step();
      moved += std::abs(learned.point(1, 128) - before);
      for (int c = 0; c < 3; ++c) {
        REQUIRE(learned.point(c, 0) == 0);
        REQUIRE(learned.point(c, LearnedResponse<float>::kSegments) == Approx(1));
        for (int j = 1; j < LearnedResponse<float>::kPoints; ++j)
          REQUIRE(learned.point(c, j) >= learned.point(c, j - 1));
      }
    }
  }
  CHECK(moved > 1e-3f);  // it was refined at all
}

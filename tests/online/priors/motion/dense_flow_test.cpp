#include "online/priors/motion/cpu_flow.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

struct Vector {
  float u, v;
};

// A texture without a period, as a function of the place: waves of random direction and length.
class Texture {
 public:
  explicit Texture(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> share(0, 1);
    for (auto& wave : waves_) {
      const float angle = 6.2832f * share(random), length = 6 + 34 * share(random);
      wave = {6.2832f / length * std::cos(angle), 6.2832f / length * std::sin(angle),
              6.2832f * share(random)};
    }
  }
  float at(float x, float y) const {
    float sum = 128;
    for (const auto& wave : waves_) sum += 14 * std::sin(wave.x * x + wave.y * y + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    float x, y, phase;
  };
  std::array<Wave, 10> waves_;
};

template <class Place>
Image<float> picture(int rows, int cols, Place&& code_at) {
  Image<float> out(1, rows, cols);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) out.at(0, y, x) = code_at(static_cast<float>(x), static_cast<float>(y));
  return out;
}

struct Flows {
  Image<float> there, back;
};
Flows flows(const Image<float>& a, const Image<float>& b, FlowQuality quality = FlowQuality::Fine,
            int threads = 1) {
  WorkerPool pool(threads);
  Flows found;
  CpuFlow(pool).compute(quality, {&a, &b, &found.there, &found.back});
  return found;
}

// Mean distance from the truth, over the pixels that `counts` names.
template <class Truth, class Counts>
double endpoint_error(const Image<float>& flow, Truth&& truth, Counts&& counts) {
  double sum = 0;
  int n = 0;
  for (int y = 0; y < flow.rows(); ++y)
    for (int x = 0; x < flow.cols(); ++x) {
      if (!counts(x, y)) continue;
      const Vector t = truth(static_cast<float>(x), static_cast<float>(y));
      sum += std::hypot(flow.at(0, y, x) - t.u, flow.at(1, y, x) - t.v);
      ++n;
    }
  return sum / n;
}

constexpr int kRows = 120, kCols = 160;
bool inside(int x, int y) { return x >= 12 && y >= 12 && x < kCols - 12 && y < kRows - 12; }

}  // namespace

TEST_CASE("dense flow finds a shift to a thirtieth of a pixel, both ways", "[isa]") {
  const Texture texture(1);
  const Vector shift =
      GENERATE(Vector{0, 0}, Vector{0.37f, -0.21f}, Vector{5.3f, 2.6f}, Vector{-11.4f, 7.8f});
  const auto a = picture(kRows, kCols, [&](float x, float y) { return texture.at(x, y); });
  const auto b =
      picture(kRows, kCols, [&](float x, float y) { return texture.at(x - shift.u, y - shift.v); });
  const Flows found = flows(a, b);
  CAPTURE(shift.u, shift.v);
  CHECK(endpoint_error(
            found.there, [&](float, float) { return shift; }, inside) < 0.035);
  CHECK(endpoint_error(
            found.back,
            [&](float, float) {
              return Vector{-shift.u, -shift.v};
            },
            inside) < 0.035);
}

TEST_CASE("where pictures show only their noise, the flow stays where it starts", "[isa]") {
  std::mt19937 random(4);
  std::normal_distribution<float> noise(2, 0.7f);  // codes, of a nearly black frame
  const auto dark = [&](float, float) { return std::max(0.f, noise(random)); };
  const auto a = picture(kRows, kCols, dark), b = picture(kRows, kCols, dark);
  Image<float> start(2, kRows, kCols), there, back;
  std::fill_n(start.plane(0), start.plane_size(), 3.f), std::fill_n(start.plane(1), start.plane_size(), -2.f);
  WorkerPool pool(1);
  FlowRequest request{&a, &b, &there, &back};
  request.start_a_to_b = {&start, 1}, request.start_b_to_a = {&start, -1};
  CpuFlow(pool).compute(FlowQuality::Fine, request);
  CHECK(endpoint_error(
            there,
            [](float, float) {
              return Vector{3, -2};
            },
            inside) < 0.5);
  CHECK(endpoint_error(
            back,
            [](float, float) {
              return Vector{-3, 2};
            },
            inside) < 0.5);
}

TEST_CASE("an object that moves farther than its own size is found, both ways", "[isa]") {
  constexpr int kSize = 48;  // pixels
  const Texture wall(5), box(6);
  const Vector step = GENERATE(Vector{78, 0}, Vector{-64, 40});
  const auto with_box = [&](float left, float top) {
    return picture(240, 320, [&](float x, float y) {
      const float u = x - left, v = y - top;
      return u >= 0 && v >= 0 && u < kSize && v < kSize ? box.at(u, v) : wall.at(x, y);
    });
  };
  const auto a = with_box(136, 96), b = with_box(136 + step.u, 96 + step.v);
  const FlowQuality quality = GENERATE(FlowQuality::Fast, FlowQuality::Medium, FlowQuality::Fine);
  const Flows found = flows(a, b, quality);
  CAPTURE(step.u, static_cast<int>(quality));
  const auto in_box = [](float left, float top) {
    return [left, top](int x, int y) {
      const float u = static_cast<float>(x) - left, v = static_cast<float>(y) - top;
      return u >= 12 && v >= 12 && u < kSize - 12 && v < kSize - 12;
    };
  };
  const auto ahead = [&](float, float) { return step; };
  const auto back = [&](float, float) { return Vector{-step.u, -step.v}; };
  CHECK(endpoint_error(found.there, ahead, in_box(136, 96)) < 0.6);
  CHECK(endpoint_error(found.back, back, in_box(136 + step.u, 96 + step.v)) < 0.6);
  // and the wall stays, where it is seen in both
  const auto rest = [](float, float) { return Vector{0, 0}; };
  CHECK(endpoint_error(found.there, rest, [](int x, int y) { return x < 60 && y > 160; }) < 0.1);
}

TEST_CASE("dense flow follows a turn and a zoom", "[isa]") {
  const Texture texture(2);
  constexpr float kTurn = 0.03f, kZoom = 1.04f;
  const auto moved = [](float x, float y) {
    const float px = x - kCols / 2.f, py = y - kRows / 2.f;
    return Vector{kZoom * (px - kTurn * py) - px, kZoom * (py + kTurn * px) - py};
  };
  const auto b = picture(kRows, kCols, [&](float x, float y) { return texture.at(x, y); });
  const auto a = picture(kRows, kCols, [&](float x, float y) {
    const Vector by = moved(x, y);
    return texture.at(x + by.u, y + by.v);
  });
  CHECK(endpoint_error(flows(a, b).there, moved, inside) < 0.06);
}

TEST_CASE("an offset between the pictures, as a wrong response leaves it, is not taken for motion", "[isa]") {
  const Texture texture(3);
  const auto a = picture(kRows, kCols, [&](float x, float y) { return texture.at(x, y); });
  const auto b = picture(kRows, kCols, [&](float x, float y) { return texture.at(x - 2, y) + 6; });
  CHECK(endpoint_error(
            flows(a, b).there,
            [](float, float) {
              return Vector{2, 0};
            },
            inside) < 0.2);
}

TEST_CASE("dense flow keeps an object apart from the background that it moves over", "[isa]") {
  const Texture far(4), near(5);
  constexpr float kShift = 6;
  const auto on_object = [](float x, float y, float by) {
    return std::abs(x - 80 - by) <= 25 && std::abs(y - 60) <= 25;
  };
  const auto seen = [&](float by) {
    return picture(kRows, kCols,
                   [&](float x, float y) { return on_object(x, y, by) ? near.at(x - by, y) : far.at(x, y); });
  };
  const auto a = seen(0), b = seen(kShift);
  const Flows found = flows(a, b);
  const auto truth = [&](float x, float y) { return Vector{on_object(x, y, 0) ? kShift : 0, 0}; };
  const double object = endpoint_error(
      found.there, truth, [](int x, int y) { return std::abs(x - 80) <= 21 && std::abs(y - 60) <= 21; });
  // what the object comes to hide is not in the second picture
  const double background = endpoint_error(found.there, truth, [](int x, int y) {
    return inside(x, y) && (x < 80 - 32 || x > 80 + 25 + 14 || std::abs(y - 60) > 32);
  });
  CHECK(object < 0.25);
  CHECK(background < 0.1);
}

TEST_CASE("dense flow is the same for any number of threads, and for a flat picture it is nothing", "[isa]") {
  const Texture texture(6);
  const auto a = picture(kRows, kCols, [&](float x, float y) { return texture.at(x, y); });
  const auto b =
      picture(kRows, kCols, [&](float x, float y) { return texture.at(1.03f * x, 0.98f * y - 1); });
  const Flows one = flows(a, b), three = flows(a, b, FlowQuality::Fine, 3);
  CHECK(std::equal(one.there.samples().begin(), one.there.samples().end(), three.there.samples().begin()));
  CHECK(std::equal(one.back.samples().begin(), one.back.samples().end(), three.back.samples().begin()));
  const auto flat = picture(kRows, kCols, [](float, float) { return 255.f; });
  const Flows nothing = flows(flat, flat);
  for (const float v : nothing.there.samples()) REQUIRE(v == 0);
}

TEST_CASE("each quality of dense flow is nearer the truth than the one below it", "[isa]") {
  const Texture texture(7);
  const auto moved = [](float x, float y) {
    return Vector{3 * std::sin(x / 17), 2 * std::sin(y / 13)};  // bends within few patches
  };
  const auto b = picture(kRows, kCols, [&](float x, float y) { return texture.at(x, y); });
  const auto a = picture(kRows, kCols, [&](float x, float y) {
    const Vector by = moved(x, y);
    return texture.at(x + by.u, y + by.v);
  });
  const auto error = [&](FlowQuality quality) {
    return endpoint_error(flows(a, b, quality).there, moved, inside);
  };
  const double coarse = error(FlowQuality::Coarse), fast = error(FlowQuality::Fast),
               medium = error(FlowQuality::Medium), fine = error(FlowQuality::Fine);
  CAPTURE(coarse, fast, medium, fine);
  CHECK(fast < coarse);
  CHECK(coarse < 1.2);  // pixels
  CHECK(medium < 0.9 * fast);
  CHECK(fine < medium);
  CHECK(fine < 0.105);  // pixels; .197 without the refinement
}

TEST_CASE("a search that starts from a guess stays with it where the picture repeats itself", "[isa]") {
  constexpr int kPeriod = 12, kShift = 3;
  const auto stripes = [](int shift) {
    return picture(64, 96, [&](float x, float) {
      return 128 + 90 * std::sin(6.2831853f * (x - static_cast<float>(shift)) / kPeriod);
    });
  };
  WorkerPool pool(1);
  CpuFlow flow(pool);
  const Image<float> from = stripes(0), to = stripes(kShift);
  Image<float> found, back, start(2, 64, 96), start_back(2, 64, 96);
  flow.compute(FlowQuality::Fine, {&from, &to, &found, &back});
  const float unguided = found.at(0, 32, 48);  // one of many shifts that fit
  CHECK(unguided == Approx(kShift).margin(0.5));
  std::fill_n(start.plane(0), start.plane_size(), static_cast<float>(kShift + kPeriod));
  std::fill_n(start_back.plane(0), start_back.plane_size(), -static_cast<float>(kShift + kPeriod));
  flow.compute(FlowQuality::Fine, {&from, &to, &found, &back, {&start}, {&start_back}});
  CHECK(found.at(0, 32, 48) == Approx(kShift + kPeriod).margin(0.5));
  CHECK(back.at(0, 32, 48) == Approx(-kShift - kPeriod).margin(0.5));
  // a guess is not remembered
  flow.compute(FlowQuality::Fine, {&from, &to, &found, &back});
  CHECK(found.at(0, 32, 48) == unguided);
}

TEST_CASE("a picture too small to match has no flow") {
  const Image<float> tiny(1, 15, 40);
  const Flows found = flows(tiny, tiny);
  REQUIRE(found.there.rows() == 15);
  for (const float v : found.there.samples()) REQUIRE(v == 0);
}

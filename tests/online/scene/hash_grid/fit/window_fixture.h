// A small window with all kinds of input of the field: poses, moving base flow, gates between 0 and 1,
// clipped and missing values. Deterministic.
#pragma once

#include <cmath>

#include "online/scene/hash_grid/field/random.h"
#include "online/scene/hash_grid/field/window.h"
#include "online/scene/hash_grid/fit/objective.h"

namespace hdrcam {

struct WindowFixture {
  int rows, cols, frames;
  Image<float> codes, radiance, variance;
  FlowField to_previous, from_previous;
  Window window;
  Response response = Response::gamma(2.2f);

  WindowFixture(int rows_, int cols_, int frames_, bool poses)
      : rows(rows_),
        cols(cols_),
        frames(frames_),
        window(frustum(rows_, cols_), WindowOptions{.frames = frames_}) {
    Pcg32 random(11);
    WorkerPool pool(1);
    for (int i = 0; i < frames; ++i) HDRCAM_CHECK_OK(window.advance(observe(i, poses, random), pool));
  }

  static WindowFrustum frustum(int rows, int cols) {
    const double focal = cols;
    return {{focal, focal, 0.5 * cols, 0.5 * rows}, rows, cols, 1.25f, 1};
  }

  FieldObservation observe(int i, bool poses, Pcg32& random) {
    for (Image<float>* picture : {&codes, &radiance, &variance}) *picture = Image<float>(3, rows, cols);
    for (FlowField* flow : {&to_previous, &from_previous}) {
      flow->vectors = Image<float>(2, rows, cols);
      flow->confidence = Image<float>(1, rows, cols);
      for (float& v : flow->vectors.samples()) v = random.uniform(-2, 2);
      for (float& v : flow->confidence.samples()) v = random.uniform(0.3f, 1);
    }
    const float exposure = std::exp2(static_cast<float>(2 * (i % 3) - 2));
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x) {
          const float light = std::exp2(2 * std::sin(0.7f * static_cast<float>(x + i)) *
                                            std::cos(0.5f * static_cast<float>(y + c)) -
                                        1.5f);
          radiance.at(c, y, x) = light * random.uniform(0.8f, 1.2f);
          variance.at(c, y, x) = random.below(5) == 0 ? 2e9f : light * light * random.uniform(0.001f, 0.2f);
          codes.at(c, y, x) = 255 * std::min(1.f, std::pow(light * exposure, 1 / 2.2f));
        }
    FieldObservation seen;
    seen.index = i;
    seen.time_s = i / 30.0;
    seen.exposure = exposure;
    seen.blur_fraction = 0.2f;
    seen.codes = &codes, seen.radiance = &radiance, seen.variance = &variance;
    if (i > 0) seen.to_previous = &to_previous, seen.from_previous = &from_previous;
    if (poses) {
      const double turn = 0.02 * i;
      seen.T_world_camera = {rotation({0, turn, 0}), {0.05 * i, -0.02 * i, 0.03 * i}};
    }
    return seen;
  }

  // Rays with every kind of target.
  std::vector<TrainingRay> rays(int count) const {
    Pcg32 random(5);
    std::vector<TrainingRay> all;
    for (int r = 0; r < count; ++r) {
      TrainingRay ray;
      ray.frame = random.below(window.size());
      for (int a = 0; a < 2; ++a)
        ray.pixel[a] = random.uniform(1.f, static_cast<float>(a == 0 ? cols : rows) - 1);
      ray.toward = ray.frame == 0 || (ray.frame + 1 < window.size() && random.below(2) == 0)
                       ? Neighbour::Next
                       : Neighbour::Previous;
      ray.warps = random.below(8) != 0;
      ray.guide = random.uniform(0.1f, 0.8f);
      ray.sharpness = random.uniform(0.5f, 1);
      for (int a = 0; a < 2; ++a) ray.flow_prior[a] = ray.pixel[a] + random.uniform(-3, 3);
      ray.flow_confidence = random.uniform();
      ray.depth_prior = random.uniform(), ray.depth_confidence = random.uniform();
      for (int c = 0; c < 3; ++c) {
        const int kind = random.below(8);
        ray.values[c] = kind == 0 ? kNoValue : kind == 1 ? 1.f : kind == 2 ? 0.f : random.uniform(0.1f, 0.9f);
        ray.state_log_radiance[c] = random.uniform(-3, 1), ray.state_trust[c] = random.uniform();
      }
      all.push_back(ray);
    }
    return all;
  }
};

}  // namespace hdrcam

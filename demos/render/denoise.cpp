// SPDX-License-Identifier: MIT
#include "demos/render/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "demos/render/parallel.h"

namespace granular_demo {
namespace {

struct Light {
  Color ambient, sun;
};

/// Weight that falls smoothly from 1 at no difference to 0 at a difference of 1 (Tukey's biweight).
float nearness(float difference) {
  const float rest = std::max(0.0f, 1.0f - difference * difference);
  return rest * rest;
}

/// Light at a pixel, averaged over the 25 pixels at multiples of `step` that show about the same plane.
Light smoothedAt(const LightBuffer& buffer, int x, int y, int step) {
  constexpr std::array<float, 3> kSpline = {3.0f / 8, 1.0f / 4, 1.0f / 16};  // B3 spline, by distance
  constexpr float kPlaneTolerance = 2.0f;   // footprints off the plane from which a pixel no longer counts
  constexpr float kShadowTolerance = 0.6f;  // likewise, share of the sun
  const auto center = static_cast<std::size_t>(y) * buffer.width + x;
  const float scale = 1.0f / (kPlaneTolerance * buffer.footprint[center]);
  Light sum{Color::Zero(), Color::Zero()};
  float ambientWeight = 0.0f, sunWeight = 0.0f;
  for (int dy = -2; dy <= 2; ++dy) {
    const int v = y + dy * step;
    if (v < 0 || v >= buffer.height) continue;
    for (int dx = -2; dx <= 2; ++dx) {
      const int u = x + dx * step;
      if (u < 0 || u >= buffer.width) continue;
      const auto other = static_cast<std::size_t>(v) * buffer.width + u;
      const float alike = buffer.normal[center].dot(buffer.normal[other]);
      if (buffer.footprint[other] <= 0.0f || alike <= 0.0f) continue;
      const float off = scale * buffer.normal[center].dot(buffer.position[other] - buffer.position[center]);
      const float alike4 = (alike * alike) * (alike * alike);
      const float spline =
          kSpline[static_cast<std::size_t>(std::abs(dx))] * kSpline[static_cast<std::size_t>(std::abs(dy))];
      const float weight = spline * alike4 * alike4 * nearness(off);
      sum.ambient += weight * buffer.ambient[other];
      ambientWeight += weight;
      // The sun's shadow has true edges: only pixels about equally lit are mixed.
      const float change =
          (buffer.sunVisibility[other].y() - buffer.sunVisibility[center].y()) / kShadowTolerance;
      const float lit = weight * nearness(change);
      sum.sun += lit * buffer.sunVisibility[other];
      sunWeight += lit;
    }
  }
  return {sum.ambient / ambientWeight, sum.sun / sunWeight};
}

}  // namespace

LightBuffer::LightBuffer(int w, int h) : width(w), height(h) {
  const std::size_t count = static_cast<std::size_t>(w) * h;
  for (auto* layer : {&rest, &ambientReflectance, &ambient, &sunReflectance, &sunVisibility})
    layer->assign(count, Color::Zero());
  normal.assign(count, Vector3f::Zero());
  position.assign(count, Vector3f::Zero());
  footprint.assign(count, 0.0f);
}

void denoise(LightBuffer& buffer, int passes, int threads) {
  std::vector<Color> ambient = buffer.ambient, sun = buffer.sunVisibility;
  for (int pass = 0; pass < passes; ++pass) {
    const int step = 1 << pass;
    parallelFor(threads, buffer.height, [&](int y) {
      for (int x = 0; x < buffer.width; ++x) {
        const auto pixel = static_cast<std::size_t>(y) * buffer.width + x;
        if (buffer.footprint[pixel] <= 0.0f) continue;
        const Light light = smoothedAt(buffer, x, y, step);
        ambient[pixel] = light.ambient;
        sun[pixel] = light.sun;
      }
    });
    buffer.ambient.swap(ambient);
    buffer.sunVisibility.swap(sun);
  }
}

}  // namespace granular_demo

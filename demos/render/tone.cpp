// SPDX-License-Identifier: MIT
#include "demos/render/tone.h"

#include <algorithm>
#include <cmath>

namespace granular_demo {
namespace {

float linearFromSrgb(float v) {
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

float srgbFromLinear(float v) {
  return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
}

float filmic(float x) {
  constexpr float kLinearStart = 0.22f;   // m: below is the toe
  constexpr float kLinearLength = 0.38f;  // l: share of the range above m that stays straight
  constexpr float kSlope = 1.0f;          // a: contrast of the straight part
  constexpr float kToe = 1.2f;            // c: 1 is no toe, more is darker shadows
  const float straight = (1.0f - kLinearStart) * kLinearLength / kSlope;
  const float shoulderStart = kLinearStart + straight;
  const float shoulderValue = kLinearStart + kSlope * straight;
  const float s = std::clamp(x / kLinearStart, 0.0f, 1.0f);
  const float aboveToe = s * s * (3.0f - 2.0f * s);
  const float toe = kLinearStart * std::pow(std::max(x, 0.0f) / kLinearStart, kToe);
  const float middle = kLinearStart + kSlope * (x - kLinearStart);
  if (x > shoulderStart) {
    const float room = 1.0f - shoulderValue;
    return 1.0f - room * std::exp(-kSlope / room * (x - shoulderStart));
  }
  return (1.0f - aboveToe) * toe + aboveToe * middle;
}

}  // namespace

Color linearFromSrgb(const Color& srgb) {
  return {linearFromSrgb(srgb.x()), linearFromSrgb(srgb.y()), linearFromSrgb(srgb.z())};
}

Color srgbFromLinear(const Color& linear) {
  return {srgbFromLinear(linear.x()), srgbFromLinear(linear.y()), srgbFromLinear(linear.z())};
}

Color filmic(const Color& radiance) {
  return {filmic(radiance.x()), filmic(radiance.y()), filmic(radiance.z())};
}

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
#include "demos/render/environment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "demos/render/tone.h"
#include "granular/base/require.h"

namespace granular_demo {
namespace {

float smoothstep(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

float latticeValue(int i, int j) {
  const auto key = static_cast<std::uint32_t>(i) * 0x9e3779b1u ^ detail::hash(static_cast<std::uint32_t>(j));
  return 2.0f * detail::unitFloat(detail::hash(key)) - 1.0f;
}

/// Smooth noise in [-1, 1] with one random value for each unit square's corner.
float valueNoise(float u, float v) {
  const float fu = std::floor(u), fv = std::floor(v);
  const int i = static_cast<int>(fu), j = static_cast<int>(fv);
  const float s = smoothstep(0.0f, 1.0f, u - fu), t = smoothstep(0.0f, 1.0f, v - fv);
  return std::lerp(std::lerp(latticeValue(i, j), latticeValue(i + 1, j), s),
                   std::lerp(latticeValue(i, j + 1), latticeValue(i + 1, j + 1), s), t);
}

Vector3f unitDirection(const Vector3& v, const char* field) {
  granular::require(v.allFinite() && v.norm() > 0.0, field, v.transpose(), "", "finite and not zero");
  return v.normalized().cast<float>();
}

}  // namespace

Environment::Environment(const RenderScene& scene, const Camera& camera)
    : zenith_(linearFromSrgb(scene.sky.zenith)),
      horizon_(linearFromSrgb(scene.sky.horizon)),
      up_(unitDirection(scene.up, "RenderScene.up")),
      towardsSun_(unitDirection(scene.sun.towards, "Sun.towards")) {
  granular::requireNotNegative(scene.sun.irradiance, "Sun.irradiance", "");
  const double sunRadius = scene.sun.angularRadiusDegrees;
  granular::require(sunRadius >= 0.0 && sunRadius <= 45.0, "Sun.angularRadiusDegrees", sunRadius, "degrees",
                    "in [0, 45]");
  sunIrradiance_ = linearFromSrgb(scene.sun.color) * static_cast<float>(scene.sun.irradiance);
  sunTangent_ = static_cast<float>(std::tan(sunRadius * std::numbers::pi / 180.0));
  if (!scene.ground) return;
  const Ground& ground = *scene.ground;
  granular::requireNotNegative(ground.gridSpacing, "Ground.gridSpacing", "m");
  granular::requireNotNegative(ground.textureLength, "Ground.textureLength", "m");
  granular::requireNotNegative(ground.fadeDistance, "Ground.fadeDistance", "m");
  hasGround_ = true;
  const Vector3 up = scene.up.normalized();
  const Vector3 across = up.unitOrthogonal();
  const Vector3 along = up.cross(across);
  const Vector3 view = camera.target - camera.eye;
  const double pictureHeight = 2.0 * view.norm() * CameraFrame(camera, 1, 1).halfHeight;
  across_ = across.cast<float>();
  along_ = along.cast<float>();
  groundHeight_ = static_cast<float>(ground.height - up.dot(camera.eye));
  target_ = view.cast<float>();
  groundColor_ = linearFromSrgb(ground.color);
  groundRoughness_ = static_cast<float>(ground.roughness);
  gridSpacing_ = static_cast<float>(ground.gridSpacing);
  textureLength_ =
      static_cast<float>(ground.textureLength > 0.0 ? ground.textureLength : pictureHeight / 4.0);
  fadeDistance_ = static_cast<float>(ground.fadeDistance > 0.0 ? ground.fadeDistance : 6.0 * pictureHeight);
  textureOrigin_ = {static_cast<float>(across.dot(camera.eye)), static_cast<float>(along.dot(camera.eye))};
}

Color Environment::sky(const Vector3f& direction) const {
  const float height = direction.dot(up_);
  if (height < 0.0f) return horizon_ * (1.0f - 0.55f * std::min(1.0f, -1.5f * height));
  const float t = 1.0f - (1.0f - height) * (1.0f - height);
  return horizon_ + (zenith_ - horizon_) * t;
}

Color Environment::openSkyAverage(const Vector3f& normal) const {
  const float upward = 0.5f + 0.5f * normal.dot(up_);
  return (0.5f * (zenith_ + horizon_)) * upward + 0.35f * horizon_ * (1.0f - upward);
}

float Environment::groundDistance(const Vector3f& origin, const Vector3f& direction) const {
  constexpr float kNever = std::numeric_limits<float>::infinity();
  const float fall = direction.dot(up_);
  const float above = origin.dot(up_) - groundHeight_;
  if (!hasGround_ || fall >= 0.0f || above <= 0.0f) return kNever;
  return -above / fall;
}

float Environment::groundHaze(const Vector3f& position) const {
  const Vector3f arm = position - target_;
  const float distance = (arm - arm.dot(up_) * up_).norm();
  return smoothstep(0.15f, 1.0f, distance / fadeDistance_);
}

Color Environment::groundColor(const Vector3f& position, float footprint) const {
  const float u = position.dot(across_) + textureOrigin_.x();
  const float v = position.dot(along_) + textureOrigin_.y();
  Color color = groundColor_ * (1.0f + 0.11f * texture(u, v, footprint));
  if (gridSpacing_ > 0.0f) {
    const float lines = std::max(gridCover(u, footprint), gridCover(v, footprint));
    color *= 1.0f - 0.45f * lines;
  }
  return color;
}

float Environment::texture(float u, float v, float footprint) const {
  float sum = 0.0f, amplitude = 0.3f, length = textureLength_;
  for (int octave = 0; octave < 7; ++octave) {
    // An octave whose waves a pixel cannot show is faded out before it would shimmer.
    const float visible = 1.0f - smoothstep(0.25f, 0.6f, footprint / length);
    if (visible <= 0.0f) break;
    sum += amplitude * visible * valueNoise(u / length + 17.3f * static_cast<float>(octave), v / length);
    amplitude *= 0.8f;
    length *= 0.43f;
  }
  return sum;
}

float Environment::gridCover(float coordinate, float footprint) const {
  const float halfLine = 0.006f * gridSpacing_;
  const float toLine = std::abs(coordinate - gridSpacing_ * std::round(coordinate / gridSpacing_));
  const float halfPixel = 0.5f * std::max(footprint, 1e-12f);
  const float cover = std::min(toLine + halfPixel, halfLine) - std::max(toLine - halfPixel, -halfLine);
  return std::clamp(cover / (2.0f * halfPixel), 0.0f, 1.0f);
}

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
// What surrounds the things in a scene: sky, sun, ground and the haze in which the ground ends. Linear light.
#pragma once

#include "demos/render/camera.h"
#include "demos/render/render_scene.h"
#include "demos/render/shading.h"

namespace granular_demo {

class Environment {
 public:
  /// The camera's eye becomes (0, 0, 0): single precision is best near it.
  Environment(const RenderScene& scene, const Camera& camera);

  Color sky(const Vector3f& direction) const;

  /// Radiance that reaches a face turned to `normal` from an open sky, averaged over its hemisphere.
  Color openSkyAverage(const Vector3f& normal) const;

  Vector3f sampleSun(Sample2 sample) const { return sampleCone(towardsSun_, sunTangent_, sample); }
  const Color& sunIrradiance() const { return sunIrradiance_; }
  float sunTangent() const { return sunTangent_; }

  bool hasGround() const { return hasGround_; }
  const Vector3f& up() const { return up_; }
  float groundRoughness() const { return groundRoughness_; }

  /// Way to the ground from above it, infinity if the ray misses.
  float groundDistance(const Vector3f& origin, const Vector3f& direction) const;

  /// Reflectance at a point of the ground. `footprint` is the width of a pixel there: finer detail is left
  /// out.
  Color groundColor(const Vector3f& position, float footprint) const;

  /// 0: ground as it is, 1: lost in the colour of the horizon.
  float groundHaze(const Vector3f& position) const;

 private:
  float texture(float u, float v, float footprint) const;
  float gridCover(float coordinate, float footprint) const;

  Color zenith_, horizon_, sunIrradiance_, groundColor_;
  Vector3f up_, towardsSun_, across_, along_;
  Vector3f target_;  // of the camera
  Eigen::Vector2f
      textureOrigin_;  // keeps texture and lines where they are in the world when the camera moves
  float sunTangent_ = 0, groundHeight_ = 0, groundRoughness_ = 1;
  float gridSpacing_ = 0, textureLength_ = 1, fadeDistance_ = 1;
  bool hasGround_ = false;
};

}  // namespace granular_demo

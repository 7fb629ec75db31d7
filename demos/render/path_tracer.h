// SPDX-License-Identifier: MIT
// Light along one line of sight: sun with a soft shadow, sky with what blocks it and one bounce, mirrors,
// glass.
//
// The noisy parts, how much of the sun and what of the sky arrives at the first opaque surface, are kept
// apart from what the surface does with them, so that they can be smoothed without blurring the picture:
//   radiance = rest + ambientReflectance * ambient + sunReflectance * sunVisibility
#pragma once

#include "demos/render/environment.h"
#include "demos/render/ray_scene.h"

namespace granular_demo {

/// Dimension of the sample sequence that places a sample within its pixel; the tracer uses those above it.
inline constexpr std::uint32_t kPixelDimension = 0;

struct LightSample {
  Color rest = Color::Zero();
  Color ambientReflectance = Color::Zero(),
        ambient = Color::Zero();  ///< ambient: mean radiance over the hemisphere
  Color sunReflectance = Color::Zero(),
        sunVisibility = Color::Zero();  ///< visibility: share of the sun's light
  Vector3f normal = Vector3f::Zero();   ///< of the first opaque surface
  float depth = 0.0f;                   ///< m of way to it; 0: the sky

  Color radiance() const { return rest + ambientReflectance * ambient + sunReflectance * sunVisibility; }
};

struct TraceSettings {
  int ambientRays = 2;      ///< rays into the hemisphere for each sample of the picture
  int reflectionDepth = 2;  ///< mirror images within mirror images
  float pixelAngle = 0.0f;  ///< width of a pixel at distance 1
};

class PathTracer {
 public:
  PathTracer(const RayScene& scene, const Environment& environment, const TraceSettings& settings)
      : scene_(scene), environment_(environment), settings_(settings) {}

  /// @param index  rank of the sample in the picture's sequence (see sampling.h)
  LightSample trace(const Ray& ray, std::uint32_t index) const { return follow(ray, 0, index); }

 private:
  struct Path;

  LightSample follow(Ray ray, int depth, std::uint32_t index) const;
  bool closestOpaque(const Ray& ray, float farthest, float wayBefore, Hit& hit) const;
  void crossGlass(const Hit& hit, Path& path, LightSample& light) const;
  void shade(const Hit& hit, const Path& path, LightSample& light) const;
  void addAmbient(const Hit& hit, const Path& path, LightSample& light) const;
  void addSun(const Hit& hit, const Path& path, const Color& albedo, const Color& f0,
              LightSample& light) const;
  Color bouncedLight(const Ray& ray, std::uint32_t dimension, std::uint32_t index) const;
  Color glossyReflection(const Hit& hit, const Path& path) const;
  Color mirrored(const Ray& ray, int depth, std::uint32_t index) const;

  const RayScene& scene_;
  const Environment& environment_;
  TraceSettings settings_;
};

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
// The things of a scene made ready for rays (Embree 3): what a ray meets first, and how much light gets
// through. Opaque and glass things are kept apart, so that most rays are answered by one query.
#pragma once

#include <memory>

#include "demos/render/render_scene.h"
#include "demos/render/shading.h"

namespace granular_demo {

/// A surface with its colour linear and its glass as extinction.
struct Material {
  Color color = Color::Ones();
  float roughness = 1, alpha = 1, metallic = 0;
  bool isGlass = false;
  Glass glass = Glass::thin;
  Color extinction = Color::Zero();  ///< thin: per straight crossing of a face; solid: per m of way inside
};

struct Ray {
  Vector3f origin, direction;  ///< direction is a unit vector
};

struct Hit {
  float distance = 0;
  Vector3f position;
  Vector3f normal;        ///< for shading, on the side of the ray's origin
  bool entering = true;   ///< the ray came from outside the surface
  bool isGround = false;  ///< the endless plane, not a thing
  Color color;            ///< linear
  Material material;
  float offset = 0;  ///< start the next ray this far off the surface, m
};

class RayScene {
 public:
  /// @param origin  point of the world that becomes (0, 0, 0): single precision is best near it
  /// @throws std::invalid_argument for what cannot be drawn, std::runtime_error when Embree fails
  RayScene(const RenderScene& scene, const Vector3& origin);
  ~RayScene();

  bool closestOpaque(const Ray& ray, float farthest, Hit& hit) const;
  bool closestGlass(const Ray& ray, float farthest, Hit& hit) const;

  /// Share of light that comes along the ray from as far as `farthest`, past opaque things and through glass.
  Color transmittance(const Ray& ray, float farthest) const;

  /// Share of light that glass alone lets through.
  Color glassTransmittance(Ray ray, float farthest) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Share of light left after a straight crossing of a thin pane, without its reflection.
Color thinTransmission(const Material& material, float cosine);

/// Share of light left after `distance` inside solid glass.
Color solidTransmission(const Material& material, float distance);

}  // namespace granular_demo

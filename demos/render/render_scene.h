// SPDX-License-Identifier: MIT
// What a picture shows, as plain data: spheres, placed meshes, ground, sky and sun. World frame, m.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "demos/render/color.h"
#include "granular/base/pose.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular_demo {

using granular::Box;
using granular::Pose;
using granular::Vector3;

/// How light passes a surface whose opacity is below 1.
enum class Glass {
  thin,   ///< every face is a thin pane: light goes straight on. For containers that are a shell of triangles
  solid,  ///< closed mesh or sphere filled with glass of index 1.5: light is bent. For panes, blocks, marbles
};

/// How a surface takes light.
struct Surface {
  Color color =
      Color(0.72f, 0.72f, 0.70f);  ///< sRGB; metals: colour of the reflection; glass: colour of the tint
  double roughness = 0.6;          ///< 0 mirror to 1 chalk (GGX alpha = roughness squared)
  double metallic = 0.0;           ///< 0 stone, plastic, wood; 1 bare metal
  double opacity =
      1.0;  ///< 1: opaque. Below 1 glass, and the fraction of light one straight crossing takes away
  Glass glass = Glass::thin;
};

/// A round particle, or a ball.
struct RenderSphere {
  Vector3 position = Vector3::Zero();  ///< m
  double radius = 0.0;                 ///< m, > 0
  Color color = Color::Ones();         ///< sRGB; multiplies the colour of the surface
  std::int32_t surface = 0;            ///< index into RenderScene::sphereSurfaces
};

/// A mesh at a pose. Instances that share the pointer share the memory of the triangles.
struct MeshInstance {
  std::shared_ptr<const granular::TriangleMesh> mesh = nullptr;
  Pose pose = {};
  Surface surface = {};
};

/// An endless plane across `RenderScene::up`.
struct Ground {
  double height = 0.0;                       ///< m, along `up`
  Color color = Color(0.66f, 0.64f, 0.61f);  ///< sRGB
  double roughness = 0.75;
  double gridSpacing = 0.0;  ///< m between thin lines that show the scale; 0: no lines
  double textureLength =
      0.0;  ///< m, largest blotch of the faint texture; 0: a quarter of the picture's height
  double fadeDistance =
      0.0;  ///< m from the camera's target to where it is lost in haze; 0: 6 picture heights
  // The picture's height is what the camera sees at its target. Set both where the camera moves.
};

/// Light from above, even around the horizon.
struct Sky {
  Color zenith = Color(0.50f, 0.62f, 0.77f);   ///< sRGB
  Color horizon = Color(0.88f, 0.90f, 0.92f);  ///< sRGB
};

/// A distant round lamp.
struct Sun {
  Vector3 towards = Vector3(-0.65, 0.62, 0.2);  ///< direction to the sun, any length > 0
  Color color = Color(1.0f, 0.95f, 0.88f);      ///< sRGB
  double irradiance = 4.8;            ///< on a face turned to it; a white wall under it is this / pi bright
  double angularRadiusDegrees = 1.6;  ///< the real one has 0.27; wider makes softer shadows
};

struct RenderScene {
  std::vector<RenderSphere> spheres = {};
  std::vector<Surface> sphereSurfaces = {Surface{.color = Color::Ones(), .roughness = 0.65}};
  std::vector<MeshInstance> meshes = {};
  std::optional<Ground> ground = Ground{};
  Sky sky = {};
  Sun sun = {};
  Vector3 up = Vector3::UnitY();  ///< any length > 0
};

/// Smallest box round the spheres and meshes (not the ground); a unit box when there are none.
Box boundsOf(const RenderScene& scene);

}  // namespace granular_demo

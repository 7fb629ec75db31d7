// SPDX-License-Identifier: MIT
// A scene as plain data: what a scene file says, after its scale has been applied and every value checked.
// demos/scenes/README.md documents the file; members carry the names of its keys. SI units.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "demos/render/camera.h"
#include "demos/render/render_scene.h"
#include "granular/base/pose.h"
#include "granular/contact/material.h"
#include "granular/dynamics/integrator.h"
#include "granular/system/fill.h"
#include "granular/system/grain_shape.h"

namespace granular_demo {

using granular::Box;
using granular::Pose;
using granular::Quaternion;
using granular::Vector3;

/// Overrides the rule for where two materials touch.
struct PairDef {
  std::string materials[2];
  granular::MaterialPairDef law;
};

/// How grains and coverings are coloured in pictures.
enum class Coloring {
  sand,   ///< each grain its own tint of quartz
  owner,  ///< each grain its own hue
  speed,  ///< from dark (at rest) to bright (GrainLook::fastest)
  fixed,  ///< GrainLook::color
};

struct GrainLook {
  Coloring coloring = Coloring::sand;
  Color color = Color(0.76f, 0.66f, 0.48f);
  double fastest = 2.0;  ///< m/s shown brightest
};

/// Many grains of one shape in one region.
struct FillPart {
  std::string name;
  granular::FillRegion region;
  std::string shape;
  std::string material;
  granular::FillDef fill;
  Vector3 velocity = Vector3::Zero();
  Vector3 spin = Vector3::Zero();
  GrainLook look;
};

/// One grain placed by hand.
struct GrainPart {
  std::string name;
  std::string shape;
  std::string material;
  Pose pose;
  Vector3 velocity = Vector3::Zero();
  Vector3 spin = Vector3::Zero();
  double scale = 1.0;
  GrainLook look;
};

// ---- shapes of bodies: long axes along y, as Bullet has them
struct MeshShape {
  std::filesystem::path file;
  double scale = 1.0;
  std::optional<double> boundingSize;  ///< diagonal of the bounding box, m; comes instead of scale
  std::optional<Vector3>
      center;  ///< where the middle of the bounding box is put, m; none: the file's origin stays
};
struct BoxShape {
  Vector3 size = Vector3::Zero();
};
struct SphereShape {
  double radius = 0.0;
};
struct CapsuleShape {
  double radius = 0.0;
  double height = 0.0;  ///< of the cylinder between the two half spheres
};
struct CylinderShape {
  double radius = 0.0;
  double height = 0.0;
};
struct ConeShape {
  double radius = 0.0;
  double height = 0.0;  ///< origin halfway up
};
/// Flat rectangle facing +y; for bodies that do not move.
struct PlanePatchShape {
  double sizeX = 0.0;
  double sizeZ = 0.0;
};
/// Endless, solid where normal . x < height; for bodies that do not move or move by a script.
struct HalfSpaceShape {
  Vector3 normal = Vector3::UnitY();  ///< of length 1
  double height = 0.0;                ///< m
  double shownSize = 1.0;             ///< edge of the square that pictures show, m
};
struct ShapeChild;
struct CompoundShape {
  std::vector<ShapeChild> children;
};
using BodyShapeDef = std::variant<MeshShape, BoxShape, SphereShape, CapsuleShape, CylinderShape, ConeShape,
                                  PlanePatchShape, HalfSpaceShape, CompoundShape>;
struct ShapeChild {
  BodyShapeDef shape;
  Pose pose;
};

enum class BodyKind { fixed, kinematic, dynamic };

/// One layer of particles on a body.
struct LayerDef {
  double particleRadius = 0.0;
  std::optional<double>
      density;  ///< D, discs over area (Bell 2005, sec. 3.3); none: just enough to leave no hole
  std::optional<double> offset;  ///< m, outwards, of the particles' centres; none: see CoveringPart
};

struct CoveringPart {
  LayerDef layer;                     ///< default offset: one radius inwards, so that the body keeps its size
  std::optional<LayerDef> roughness;  ///< a second layer of smaller particles; default offset: on the surface
  std::uint64_t seed = 1;
};

/// What of a body meets grains.
enum class BodyContact {
  particles,  ///< its covering; none: nothing
  exact,      ///< its surface as it is; of a mesh or cone, its sampled distance
};

/// How a body looks.
struct BodyLook {
  Surface surface;
  bool visible = true;
  bool showParticles = false;  ///< the covering is drawn too
  Color particleColor = Color(0.55f, 0.52f, 0.48f);
};

/// One point on the way of a kinematic body.
struct ScriptPoint {
  double time = 0.0;                 ///< s
  Vector3 offset = Vector3::Zero();  ///< m, from where the body was placed
};

struct ScriptShake {
  Vector3 amplitude = Vector3::Zero();  ///< m
  double frequency = 0.0;               ///< Hz
  double phase = 0.0;                   ///< rad
  double from = 0.0;                    ///< s
  double to = 0.0;                      ///< s
};

struct ScriptTurn {
  Vector3 axis = Vector3::UnitY();
  double rate = 0.0;  ///< rad/s
  double from = 0.0;  ///< s
  double to = 0.0;    ///< s
};

/// How a kinematic body moves from where it was placed: the sum of what is given.
struct ScriptDef {
  std::vector<ScriptPoint> path;  ///< straight between points, at rest before the first and after the last
  std::optional<ScriptShake> shake;
  std::optional<ScriptTurn> turn;
};

struct BodyPart {
  std::string name;
  BodyShapeDef shape;
  BodyKind motion = BodyKind::fixed;
  std::optional<double> mass;     ///< kg; dynamic bodies have this or the density
  std::optional<double> density;  ///< kg/m^3
  /// Moments about the axes the shape is drawn in, through its centre of mass, kg m^2; none: of the shape.
  std::optional<Vector3> inertia;
  std::string material;
  BodyContact contact = BodyContact::particles;
  std::optional<CoveringPart> covering;
  Pose pose;
  Vector3 velocity = Vector3::Zero();
  Vector3 spin = Vector3::Zero();
  std::string script;  ///< name of a ScriptDef; empty: none
  bool replaceableByMesh = false;
  BodyLook look;

  /// Else Bullet alone moves it, and grains do not see it.
  bool meetsGrains() const { return covering || contact == BodyContact::exact; }
};

/// Beyond `box` a grain counts as escaped. In a closed scene that is a failure.
struct ContainerDef {
  Box box;
  bool closed = false;
};

struct CameraPart {
  std::string name;
  Camera camera;
};

struct SceneLook {
  std::optional<Ground> ground;
  Sky sky;
  Sun sun;
  double ballRoughness = 0.65;  ///< of grains' surfaces
};

enum class Quality { preview, normal, best };

struct OutputsDef {
  bool pictures = true;
  bool film = true;
  int width = 640;
  int height = 360;
  Quality quality = Quality::preview;
  bool vtp = false;
  int vtpEvery = 1;                           ///< frames
  std::vector<std::string> trajectoryBodies;  ///< names of bodies
  std::vector<std::string> trajectoryGrains;  ///< names of grains placed by hand
};

struct SceneDef {
  std::filesystem::path file;
  std::string name;
  std::string description;
  std::string scale;  ///< the one that was applied
  Vector3 gravity = {0.0, -9.81, 0.0};
  double duration = 1.0;    ///< s
  double frameRate = 30.0;  ///< frames per second
  int ticksPerFrame = 4;    ///< Bullet steps a frame
  std::uint64_t seed = 1;
  granular::IntegratorDef integrator;
  std::vector<granular::MaterialDef> materials;
  std::vector<PairDef> pairs;
  std::vector<granular::GrainShapeDef> shapes;
  std::vector<FillPart> fills;
  std::vector<GrainPart> grains;
  std::map<std::string, ScriptDef> scripts;
  std::vector<BodyPart> bodies;
  std::optional<ContainerDef> container;
  std::optional<double>
      groundHeight;  ///< m, along -gravity through the origin: no particle centre may be below
  std::vector<CameraPart> cameras;
  SceneLook look;
  OutputsDef outputs;

  double frameDuration() const { return 1.0 / frameRate; }
  int frameCount() const;
};

}  // namespace granular_demo

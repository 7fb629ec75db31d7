// SPDX-License-Identifier: MIT
// A scene as plain data: what a scene file says, after its scale has been applied and every value checked.
// demos/scenes/README.md documents the file; members carry the names of its keys. SI units.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
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
#include "granular/system/emitter.h"
#include "granular/system/fill.h"
#include "granular/system/grain_shape.h"
#include "granular/system/sleep.h"

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

/// Grains of one shape poured from a region at a rate.
struct EmitterPart {
  std::string name;
  granular::FillRegion region;
  std::string shape;
  std::string material;
  granular::EmitterDef emitter;
  double from = 0.0;                                    ///< s
  double to = std::numeric_limits<double>::infinity();  ///< s
  Vector3 velocity = Vector3::Zero();
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

/// Many bodies like one, in a grid that begins where the one is placed.
struct CopiesDef {
  std::array<int, 3> counts = {1, 1, 1};  ///< along x, y, z, world
  Vector3 step = Vector3::Zero();         ///< m from one to the next along each axis
  Vector3 stagger = Vector3::Zero();      ///< m, of every second layer, upwards: bricks in bond
  double jitter = 0.0;                    ///< m, largest random shift along each axis
  bool randomOrientations = false;
  std::uint64_t seed = 1;

  int total() const { return counts[0] * counts[1] * counts[2]; }
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
  std::optional<CopiesDef> copies;
  std::string group;              ///< name of the body this is a copy of; empty: it is none
  std::array<int, 3> place = {};  ///< of a copy in its grid

  /// Else Bullet alone moves it, and grains do not see it.
  bool meetsGrains() const { return covering || contact == BodyContact::exact; }
};

enum class JointKind { fixed, hinge, point };

/// A constraint of Bullet between two bodies, or between all neighbours among the copies of a body.
struct JointPart {
  std::string name;
  JointKind kind = JointKind::fixed;
  std::string bodies[2];                ///< names; of copies "brick[3]"
  std::string copiesOf;                 ///< comes instead of `bodies`
  int along = 1;                        ///< axis of the grid of copies: 0, 1, 2
  std::optional<Vector3> at;            ///< m, world, at the start; none: halfway between the bodies
  Vector3 axis = Vector3::UnitY();      ///< of a hinge, world, at the start
  std::optional<double> breakingForce;  ///< N, and N m of torque; none: never breaks
  bool touching = true;                 ///< while joined; where it breaks they do in any case
};

// ---- meters: what a run measures of the outcome
/// Mass of grains that has passed a plane.
struct FlowMeterDef {
  Vector3 point = Vector3::Zero();
  Vector3 direction = -Vector3::UnitY();  ///< of length 1
  double from = 0.15, to = 0.75;          ///< fractions of all mass between which the rate is taken
};
/// How many rings are threaded on poles, and where the others lie.
struct RingMeterDef {
  std::string rings;        ///< body with copies: rings round the z axis they are drawn with
  std::string poles;        ///< body with or without copies: cylinders
  double holeRadius = 0.0;  ///< m
  double nearPole = 0.0;    ///< m, horizontal distance to an axis that counts as "at a pole"
  Box walls;                ///< inner faces of the box, m
  double nearWall = 0.0;    ///< m
};
/// How many bodies have moved from where they were.
struct DisplacementMeterDef {
  std::vector<std::string> bodies;  ///< names, with all their copies
  double distance = 0.0;            ///< m
};
/// What a moved body pushes along.
struct PushMeterDef {
  std::string body;
  Vector3 direction = Vector3::UnitX();  ///< of length 1
  double distance = 0.0;                 ///< m along `direction` from which on something counts as pushed
};
struct MeterPart {
  std::string name;
  std::variant<FlowMeterDef, RingMeterDef, DisplacementMeterDef, PushMeterDef> def;
};

/// A bound on a result of a meter at the end of a whole run.
struct ExpectedPart {
  std::string meter;
  std::string value;
  std::optional<double> atLeast, atMost;
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
  bool state = true;                          ///< the state at the end, to go on from
};

struct SceneDef {
  std::filesystem::path file;
  std::string name;
  std::string description;
  std::string scale;      ///< the one that was applied
  std::string document;   ///< the file's JSON after its scale, as text: goes into state files
  std::string continues;  ///< name of the scene whose end this one begins with; empty: none
  Vector3 gravity = {0.0, -9.81, 0.0};
  double duration = 1.0;    ///< s
  double frameRate = 30.0;  ///< frames per second
  int ticksPerFrame = 4;    ///< Bullet steps a frame
  std::uint64_t seed = 1;
  granular::IntegratorDef integrator;
  granular::SleepDef sleep;
  std::vector<granular::MaterialDef> materials;
  std::vector<PairDef> pairs;
  std::vector<granular::GrainShapeDef> shapes;
  std::vector<FillPart> fills;
  std::vector<GrainPart> grains;
  std::vector<EmitterPart> emitters;
  std::map<std::string, ScriptDef> scripts;
  std::vector<BodyPart> bodies;
  std::vector<JointPart> joints;
  std::vector<MeterPart> meters;
  std::vector<ExpectedPart> expected;
  double largestStartOverlap = 0.25;  ///< between bodies, in smaller particle radii, before the first step
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

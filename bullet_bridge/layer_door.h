// SPDX-License-Identifier: MIT
// What a program says to the sand in its world, the same through either door: GranularDynamicsWorld, which
// takes the place of a btDiscreteDynamicsWorld, and GranularLayer, which joins one that is there.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bullet_bridge/precision.h"
#include "bullet_bridge/shape_surface.h"
#include "granular/geometry/cover.h"
#include "granular/granular.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

namespace detail {
class Layer;
}

struct LayerDef {
  granular::IntegratorDef integrator = {};
  granular::SleepDef sleep = {};  ///< of grains and covered bodies in the core, besides Bullet's own sleeping
  int threads = 1;                ///< of the core, > 0; results are the same bits for every number
  /// Runs the core's loops in place of its own threads, with the same bits; must outlive the world or layer.
  /// For Bullet's task schedulers: TaskSchedulerExecutor.
  granular::HostExecutor* executor = nullptr;
  /// For each stepSimulation of a GranularDynamicsWorld, each tick of a GranularLayer. Used up, grains and
  /// covered bodies simulate less time than asked: they move in slow motion, while the rest of the world goes
  /// on. One sub-step is made at least. lastStep() has StepFlag::BudgetExhausted and the dropped time.
  granular::WorkBudget budget = {};

  /// How far a cube that stands on its like sinks into it under its own weight, in edges, > 0: this, with
  /// mass, size and gravity at the time of coverBody, decides how stiff bodies are against each other, so
  /// that stacks behave alike at every size (rounded to a power of two; not for bodies with a material of
  /// their own; jointed bodies are soft enough that an impact lasts a tick, as joints act once a tick).
  /// Columns of more than (0.65 / restingDepth)^(1/3) cubes buckle: 40 at the default. A sub-step's length
  /// goes with its root.
  double restingDepth = 1e-5;

  /// A kinematic body that a frame moves faster than this is taken as put there: it jumps, without velocity.
  /// m/s for its centre, and for its outermost particle. Frames that Bullet cuts short (too few sub-steps)
  /// inflate the speed of what moves in them; a jump into grains throws them, so set this well above what the
  /// scene means by motion.
  double kinematicSpeedLimit = 100.0;

  int drawnParticleLimit = 20000;  ///< debug drawing shows evenly chosen particles up to this number, >= 0
};

/// What of a covered body meets grains and the particles of other bodies.
enum class SurfaceContact : std::uint8_t {
  Particles,  ///< particles on its surface, as in the paper
  /// The shape itself, smooth and without particles: boxes, spheres, capsules, cylinders, planes (static or
  /// kinematic; solid on the far side of the normal, endless), and any other shape of one closed part by its
  /// sampled distance. Meets particles only: who handles which pair is listed in bullet_bridge/README.md.
  Exact,
};

/// What of a covered body meets particles of other covered bodies.
enum class MeetBodies : std::uint8_t {
  /// Surface where the shape has a formula (box, sphere, capsule, cylinder, plane) or is one closed part;
  /// Particles elsewhere, and where CoverBodyDef::covering is given.
  Automatic,
  /// Its surface, smooth: faces lie flat on each other and do not lock. Grains meet the particles.
  Surface,
  Particles,  ///< its particles: two such faces sink into each other's dips, and lock
};

/// Where a dynamic body has its mass. The amount is the btRigidBody's own.
enum class MassSource : std::uint8_t {
  /// Centre of mass and inertia of the solid within the surface, exact (shapeMass). The btRigidBody's
  /// transform,
  /// velocity and joint frames keep meaning the frame that its owner drew it in. Where the surface is unknown
  /// (CoverBodyDef::covering) the btRigidBody's own.
  Solid,
  Body,  ///< the btRigidBody's origin, axes and inertia: say so where a centre of mass was moved on purpose
};

/// How a body gets its particles. Whatever is left out follows from the btRigidBody.
struct CoverBodyDef {
  /// Exact: nothing below but `exactSpacing`, `surface`, `shapeSurface`, `mass` and `material` may be set.
  SurfaceContact contact = SurfaceContact::Particles;
  /// Beside particles; of no meaning where `contact` is Exact: particles of other bodies meet such a body's
  /// surface in any case.
  MeetBodies meetBodies = MeetBodies::Automatic;
  /// Of a surface that is met by its sampled distance: between samples, m, >= 0; edges are rounded by about
  /// half of it. 0: a 64th of the shape's size, or where grains meet it and are there, half the radius of
  /// their smallest particle.
  double exactSpacing = 0.0;

  /// m, >= 0. 0: the radius of the smallest particle of any grain in the world, or without grains the radius
  /// of which 500 discs have the body's surface (40 that of a box whose surface bodies meet), but at most a
  /// quarter of its least extent.
  double particleRadius = 0.0;
  /// m, as granular::CoverDef::offset; default: the covering keeps the body's size.
  std::optional<double> offset = std::nullopt;
  /// As granular::CoverDef::density; default: no hole that lets a grain through.
  std::optional<double> density = std::nullopt;
  /// Of open surfaces of static and kinematic bodies, m, > 0: covered on both sides, as a sheet this thick.
  /// None: small gaps are closed, and what then is no solid is refused.
  std::optional<double> sheetThickness = std::nullopt;
  std::uint64_t seed = 1;

  MassSource mass = MassSource::Solid;

  /// Ready particles, btRigidBody's frame.
  std::optional<granular::Covering> covering = std::nullopt;
  /// Covered, or met exactly, in place of the collision shape, body frame.
  std::optional<granular::TriangleMesh> surface = std::nullopt;
  SurfaceDef shapeSurface = {};  ///< how the collision shape becomes a mesh; planes need a patch

  /// None: made from the body's friction and restitution. Between two such bodies friction is the product of
  /// the two (Bullet's rule) and static (law 19), and restitution is the product too, but not below 0.1:
  /// Bullet's default 0 has no finite dashpot; stiffness: LayerDef::restingDepth. Changes of the body's
  /// friction or restitution are followed. A material given here stays.
  std::optional<granular::MaterialId> material = std::nullopt;
};

enum class PileShape : std::uint8_t { Sphere, Tetrahedron, Cube };

/// Grains to fill a box with.
struct PileDef {
  granular::Box region = {};    ///< m, world frame; particles lie wholly inside
  double particleRadius = 0.0;  ///< m, > 0
  PileShape shape = PileShape::Tetrahedron;
  std::optional<granular::MaterialId> material = std::nullopt;  ///< none: granular::MaterialDef{} (stone)
  std::uint64_t seed = 1;
  granular::ContactFilter filter = {};  ///< groups and masks as in Bullet; 1 is Bullet's default group
};

/// Who handles the contact of two bodies.
enum class PairOwner : std::uint8_t {
  Automatic,  ///< the particles if both bodies are covered, else Bullet
  Bullet,     ///< Bullet's solver, also if both are covered
};

/// A contact of a covered body, as it stands after a tick.
struct BodyContact {
  const btRigidBody* body = nullptr;
  const btRigidBody* other = nullptr;                   ///< null: a grain
  granular::GrainId grain;                              ///< index -1: a body
  granular::Vector3 point = granular::Vector3::Zero();  ///< m, world
  granular::Vector3 force = granular::Vector3::Zero();  ///< N, on `body`, world
  double overlap = 0.0;                                 ///< m
};

/// Told after each tick; the span lives as long as the call.
using ContactListener = std::function<void(std::span<const BodyContact>)>;

/// Where a ray first meets a grain.
struct GrainHit {
  granular::GrainId grain;
  double fraction = 1.0;  ///< of the way from `from` to `to`; 0 where the ray begins within a grain
  granular::Vector3 point = granular::Vector3::Zero();   ///< m, world
  granular::Vector3 normal = granular::Vector3::Zero();  ///< unit, out of the particle that was hit
};

class LayerDoor {
 public:
  /// Fills a box with grains that overlap nothing that is there, and returns their ids.
  std::vector<granular::GrainId> addPile(const PileDef& def);

  /// From the next tick on the body meets grains and other covered bodies through particles on its surface.
  /// The body's mass stays its own; where it has it: MassSource. Throws std::invalid_argument: covered
  /// already, not in this world, a dynamic body without mass, a transform or velocity that is not finite, a
  /// shape without a known surface, a shape that cannot be met exactly where that is asked for, a bad def.
  granular::BodyId coverBody(btRigidBody& body, const CoverBodyDef& def = {});
  /// Gives the body back to Bullet as it moves now. Taking a body out of the world does the same.
  void uncoverBody(btRigidBody& body);
  bool isCovered(const btRigidBody& body) const;
  /// The body's name in grains(), for impulses and contacts. Ask again after changing the body's mass to or
  /// from 0, its kinematic flag, collision filter, friction or restitution: such a change makes a new body in
  /// the core. Throws std::invalid_argument if the body is not covered.
  granular::BodyId bodyIdOf(const btRigidBody& body) const;
  /// Where the core's body of that name stands in the btRigidBody's frame: at the true centre of mass, along
  /// the principal axes; the identity where that is the btRigidBody's own frame. Angular impulses are about
  /// its origin. Throws std::invalid_argument if the body is not covered.
  granular::Pose massFrameOf(const btRigidBody& body) const;
  /// Both bodies must be covered. Holds until one of them is uncovered.
  void setPairOwner(const btRigidBody& a, const btRigidBody& b, PairOwner owner);

  /// The core: add, move and read grains, materials, shapes. Step it only through stepSimulation.
  granular::GranularSystem& grains();
  const granular::GranularSystem& grains() const;

  /// What the last stepSimulation did: counts and wall times summed over its ticks, overlaps and sub-step
  /// lengths at their extremes, the rest as it stood after the last tick.
  const granular::StepReport& lastStep() const;
  /// From the next tick on; see LayerDef::budget. Throws std::invalid_argument if a number is negative.
  void setBudget(const granular::WorkBudget& budget);

  // ---- reading
  /// Contacts that covered bodies have now, with grains and with each other's particles.
  void readContacts(std::vector<BodyContact>& contacts);
  /// Called after each tick in which there was sand, while bodies stand where the tick left them. It may read
  /// anything, apply forces and impulses, and must not add or remove. Empty: nobody.
  void setContactListener(ContactListener listener);
  /// Mean force and torque of the last tick from grains and covered bodies, N and N m, world, the torque
  /// about the origin of massFrameOf; of static bodies those of this moment. Throws std::invalid_argument if
  /// the body is not covered.
  granular::Wrench contactForce(const btRigidBody& body);

  /// The first grain on the way from `from` to `to`, m, world. Looks at every particle. Throws
  /// std::invalid_argument if an end is not finite.
  std::optional<GrainHit> castRay(const granular::Vector3& from, const granular::Vector3& to) const;

  /// Pose of every living grain, in the order of grains().grainAt, at the moment for which Bullet tells
  /// motion states: carried on by what stepSimulation left of its time.
  void readGrainPoses(std::vector<granular::Pose>& poses) const;

  // ---- grains in Bullet's own queries
  /// From now on rayTest, convexSweepTest, contactTest and btDefaultVehicleRaycaster meet grains: a static
  /// body joins the world whose compound shape has one sphere for each particle of a grain, moved after each
  /// tick. It collides with nothing. Costs about a microsecond a particle and tick. Group and mask as in
  /// addRigidBody.
  void showGrainsToQueries(int group = btBroadphaseProxy::StaticFilter,
                           int mask = btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter);
  void hideGrainsFromQueries();
  /// The grain that a query met, from the collision object and LocalShapeInfo::m_triangleIndex that Bullet
  /// tells (in contact tests btManifoldPoint::m_index0 or 1); none if the object is something else.
  std::optional<granular::GrainId> grainOf(const btCollisionObject* object, int childIndex) const;

 protected:
  explicit LayerDoor(std::unique_ptr<detail::Layer> layer);
  ~LayerDoor();
  LayerDoor(const LayerDoor&) = delete;
  LayerDoor& operator=(const LayerDoor&) = delete;

  std::unique_ptr<detail::Layer> layer_;
};

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge

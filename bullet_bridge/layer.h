// SPDX-License-Identifier: MIT
// What stands between a Bullet world and a GranularSystem: which bodies are covered, what of their state was
// last written, and the stages of a tick in the order the world calls them. Knows any btDiscreteDynamicsWorld
// from outside; the world's door decides when each stage runs.
//
// The scheme ("mean velocity"): the core carries covered bodies from (x0, v0) to (x1, v1) together with the
// grains. Bullet's solver is shown the mean velocity (x1 - x0) / dt, so joints and foreign contacts correct
// the motion the body really makes; what they change, dv, is added at the end: x = x1 + dv dt, v = v1 + dv. A
// body they do not touch has dv = 0 and lands on (x1, v1) exactly.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <set>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "bullet_bridge/bullet_state.h"
#include "bullet_bridge/exact_shape.h"
#include "bullet_bridge/grain_queries.h"
#include "bullet_bridge/joint_loads.h"
#include "bullet_bridge/layer_door.h"
#include "bullet_bridge/mass_frames.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

/// What a core body is made from besides its motion; a change of it makes a new core body.
struct BodyMake {
  granular::BodyMotion motion = granular::BodyMotion::Static;
  std::uint32_t group = 0;
  std::uint32_t mask = 0;
  granular::MaterialId material = {};
  friend bool operator==(const BodyMake&, const BodyMake&) = default;
};

/// Settings of a dynamic body that may change at any time.
struct BodySettings {
  double mass = 0.0;
  granular::Vector3 principalInertia = granular::Vector3::Zero();
  granular::Vector3 inverseInertia = granular::Vector3::Zero();  ///< 0 for a body that does not turn
  granular::Vector3 linearFactor = granular::Vector3::Zero();
  granular::Vector3 angularFactor = granular::Vector3::Zero();
  friend bool operator==(const BodySettings&, const BodySettings&) = default;
};

struct CoveredBody {
  btRigidBody* body = nullptr;
  granular::BodyId id;
  BodyMake make;
  BodySettings settings;
  bool followsBodyMaterial = false;  ///< material made from the btRigidBody's friction and restitution
  double boundingRadius = 0.0;       ///< of the covering about the core body's origin, m; 0 for a plane
  double largestSide = 0.0;          ///< of the box round its shape, m^2
  double gravity = 0.0;              ///< when it was covered, m/s^2, > 0
  double jointTick = 0.0;            ///< s; 0 for a body that no joint holds
  bool isShownMidway = false;        ///< to Bullet's joints: as it is in the middle of the tick
  std::optional<granular::ExactSurface> exact;
  granular::ExactUse exactUse = granular::ExactUse::Everything;  ///< Everything: met instead of particles
  granular::Pose exactFrame;                                     ///< of its frame in Bullet's body frame
  /// Of the core's body in Bullet's body frame: true centre of mass and principal axes; a plane's foot and
  /// normal, as the core's half-space ends at y = 0 of its own frame. The identity where the two agree.
  granular::Pose coreFrame;
  /// Principal moments for each kg, m^2, along coreFrame's axes; none: the btRigidBody's own.
  std::optional<granular::Vector3> momentsPerMass;

  int worldIndex = -1;  ///< where the world's array had it last
  int proxyId = -1;     ///< unique for each time a body is added to a world

  BulletState written;  ///< as last agreed with Bullet: a difference is the program's doing

  // Kinematic: the pose runs from where it was to frameEnd while frameTimeLeft counts down.
  granular::Pose frameEnd;
  granular::Vector3 frameVelocity = granular::Vector3::Zero();
  granular::Vector3 frameAngularVelocity = granular::Vector3::Zero();
  double frameTimeLeft = 0.0;
  bool isBehind = false;  ///< the core did not simulate the whole last tick: it is not where it should be

  bool hasParticles() const { return !exact || exactUse == granular::ExactUse::Bodies; }
  bool isPlane() const { return !hasParticles() && std::holds_alternative<granular::HalfSpace>(*exact); }

  // Dynamic, within one tick.
  bool held = false;            ///< asleep: stands still in the core
  bool sleepsInCore = false;    ///< held: because it sleeps there as well, and may be woken there
  btScalar sweepThreshold = 0;  ///< the program's continuous-collision threshold
  int flags = 0;                ///< the program's btRigidBodyFlags
  granular::Pose startPose;     ///< x0
  granular::Wrench jointLoad;   ///< what its joints bear through the tick, about its centre of mass, world
  btVector3 jointImpulse;       ///< what that adds to its velocity, as Bullet reckons it
  btVector3 jointTurn;          ///< and to its angular velocity
  granular::Vector3 meanAngularVelocity = granular::Vector3::Zero();
  BulletState offered;         ///< before the solver
  BulletState solved;          ///< after it, before actions
  btVector3 expectedVelocity;  ///< after the solver if nothing touches the body
  btVector3 expectedAngularVelocity;
  granular::Vector3 velocityCorrection = granular::Vector3::Zero();
  granular::Vector3 angularVelocityCorrection = granular::Vector3::Zero();
  granular::Pose push;  ///< the solver's position correction (split impulse): a shift and a turn
};

/// Bullet's solver changed what was offered to it: joints or foreign contacts touched the body in this tick.
bool isCorrected(const CoveredBody& covered);
/// Whether the core lets the two meet: it finds contacts of moving particles, never of two exact surfaces.
bool meetInCore(const CoveredBody& a, const CoveredBody& b);
/// Mass, inertia and factors as they stand; a held body has no freedom at all, a body without inertia does
/// not turn.
BodySettings settingsOf(const CoveredBody& covered, bool held);
/// The motion of Bullet's origin and axes of the body, and of the core's.
granular::RigidMotion bulletMotion(const CoveredBody& covered, const granular::RigidMotion& core);
granular::RigidMotion coreMotion(const CoveredBody& covered, const granular::RigidMotion& bullet);
/// From Bullet's origin of the body to the core's, along the core's body axes, m.
granular::Vector3 leverOf(const CoveredBody& covered);

class Layer {
 public:
  /// @param framesAreTold  beginKinematicFrame is called in every stepSimulation; else it is inferred
  Layer(btDiscreteDynamicsWorld& world, const LayerDef& def, bool framesAreTold);

  granular::GranularSystem& system() { return system_; }
  const granular::GranularSystem& system() const { return system_; }
  const granular::StepReport& report() const { return report_; }
  int drawnParticleLimit() const { return def_.drawnParticleLimit; }
  void setBudget(const granular::WorkBudget& budget);
  /// Nothing covered and no grains: the world runs as plain Bullet.
  bool isIdle() const { return bodies_.empty() && system_.grainCount() == 0; }

  std::vector<granular::GrainId> addPile(const PileDef& def);
  granular::BodyId cover(btRigidBody& body, const CoverBodyDef& def);
  void uncover(const btRigidBody& body);
  /// Uncovers bodies that are no longer in the world, without touching them: they may be gone.
  void forgetRemoved();
  bool isCovered(const btRigidBody& body) const { return slots_.contains(&body); }
  granular::BodyId idOf(const btRigidBody& body) const;
  granular::Pose massFrameOf(const btRigidBody& body) const;
  void setPairOwner(const btRigidBody& a, const btRigidBody& b, PairOwner owner);

  // ---- reading
  void readContacts(std::vector<BodyContact>& contacts);
  void setContactListener(ContactListener listener) { contactListener_ = std::move(listener); }
  granular::Wrench contactForce(const btRigidBody& body);
  std::optional<GrainHit> castRay(const granular::Vector3& from, const granular::Vector3& to) const;
  void readGrainPoses(std::vector<granular::Pose>& poses) const;
  void showGrainsToQueries(int group, int mask);
  void hideGrainsFromQueries();
  std::optional<granular::GrainId> grainOf(const btCollisionObject* object, int childIndex) const;

  // ---- stages of a stepSimulation
  void beginFrame();
  void beginKinematicFrame(btScalar frameTime);
  // ---- stages of a tick, in this order
  void takeChanges(btScalar dt);
  void keepAwake(btScalar dt);
  void switchSweepsOff();
  void step(btScalar dt);
  void offerMeanMotion(btScalar dt);
  void silenceOwnPairs();
  void unsilenceOwnPairs();
  void takeCorrections();
  void switchSweepsOn();
  void store(btScalar dt);
  void tellWhatCame();

 private:
  using Pair = std::pair<const btRigidBody*, const btRigidBody*>;  // smaller address first

  /// What the core is told of how bodies touch.
  struct BodyMaterial {
    btScalar friction = 0;
    btScalar restitution = 0;
    double stiffness =
        0.0;  ///< of its foundation against something rigid, N/m^3; infinite: it is that itself
    granular::MaterialId id;
  };

  static Pair makePair(const btRigidBody& a, const btRigidBody& b);
  const CoveredBody* find(const btCollisionObject* object) const;

  void drop(std::size_t slot);
  bool isInWorld(CoveredBody& covered) const;
  void checkCoverable(const btRigidBody& body) const;
  double exactSpacing(const btRigidBody& body, const CoverBodyDef& def) const;
  granular::Covering takeSurface(CoveredBody& covered, const CoverBodyDef& def) const;
  granular::Covering makeCovering(const btRigidBody& body, const CoverBodyDef& def) const;
  void takeMassFrame(CoveredBody& covered, const CoverBodyDef& def) const;
  double defaultParticleRadius(const std::vector<ShapePart>& parts, double discs) const;
  double stiffnessOf(const CoveredBody& covered) const;
  granular::MaterialId bodyMaterial(const CoveredBody& covered);
  void pairMaterials(const BodyMaterial& a, const BodyMaterial& b);
  granular::MaterialId pileMaterial();
  BodyMake makeOf(const CoveredBody& covered);
  void addToSystem(CoveredBody& covered, granular::Covering covering, const granular::RigidMotion& motion);
  void remakeIfChanged(CoveredBody& covered);
  void forgetPairsOf(const btRigidBody& body, std::set<Pair>& pairs);
  void noteFilteredPairs(const btRigidBody& body);
  std::set<Pair> wantedExclusions() const;
  void updateExclusions();

  void noteJoints(btScalar dt);
  void noteForeignJoints();
  bool movesOutside(const btRigidBody& body) const;
  void takeStaticPose(CoveredBody& covered);
  void takeKinematicPose(CoveredBody& covered, double dt);
  granular::Pose bulletPose(const CoveredBody& covered) const;
  void runKinematicTo(CoveredBody& covered, const granular::Pose& end, double duration);
  void takeDynamicState(CoveredBody& covered, btScalar dt);
  double kinematicTime(const CoveredBody& covered, const BulletState& now, double dt) const;
  void prepareDynamic(CoveredBody& covered);
  void integrate(double dt);
  void takeJointLoads();
  void applyLoad(CoveredBody& covered);
  void showMassFrames();
  granular::Pose midwayPose(const CoveredBody& covered) const;
  void noteSolved();
  bool addActions(const CoveredBody& covered, granular::RigidMotion& motion) const;
  granular::RigidMotion correctedMotion(const CoveredBody& covered, double dt) const;
  void write(CoveredBody& covered, const granular::RigidMotion& core);
  void wake(CoveredBody& covered);
  void wakeWithCore();
  bool isNearGrains(const CoveredBody& covered, double largestGrainRadius, double dt) const;
  bool isNearMovingBody(const CoveredBody& covered, double dt) const;
  double largestGrainRadius() const;

  btDiscreteDynamicsWorld& world_;
  LayerDef def_;
  bool framesAreTold_;
  granular::GranularSystem system_;
  granular::StepReport report_;
  std::vector<CoveredBody> bodies_;
  std::unordered_map<const btCollisionObject*, std::size_t> slots_;
  std::vector<BodyMaterial> bodyMaterials_;
  std::optional<granular::MaterialId> pileMaterial_;
  std::set<Pair> bulletOwned_;  // by setPairOwner
  std::set<Pair> filteredOut_;  // by the program's overlap filter, asked when a body is covered
  std::set<Pair> excluded_;     // as the core knows it now
  std::vector<std::pair<btPersistentManifold*, int>> silenced_;
  MassFrames massFrames_;
  JointLoads jointLoads_;
  ContactListener contactListener_;
  std::vector<BodyContact> contacts_;  // told to the listener
  double lastTick_ = 0.0;              // what of it was simulated, s
  double secondsSpent_ = 0.0;          // of wall time, of the budget
  std::unique_ptr<GrainQueries> queries_;
  bool wakeAll_ = false;  // something that may have held a body up has gone
};

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge

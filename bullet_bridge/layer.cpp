// SPDX-License-Identifier: MIT
// Who is covered, with what particles, masses and materials.
#include "bullet_bridge/layer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/pose_algebra.h"
#include "bullet_bridge/shape_covering.h"
#include "bullet_bridge/shape_mass.h"
#include "granular/base/require.h"
#include "granular/system/fill.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

using granular::Vector3;

/// Relative; Bullet's float boxes are this exact.
constexpr double kMassRounding = 1e-6;
/// Discs on a body's surface when neither the user nor any grain says how large its particles are.
constexpr double kDefaultDiscs = 500.0;
/// The same for a box whose surface bodies meet: nine or so on a face carry it flat and tilted, as exactly as
/// more would.
constexpr double kDiscsOfABox = 40.0;

void checkBudget(const granular::WorkBudget& budget) {
  granular::require(budget.evaluations >= 0, "WorkBudget.evaluations", budget.evaluations, "", ">= 0");
  granular::require(budget.seconds >= 0.0, "WorkBudget.seconds", budget.seconds, "s", ">= 0");
}

granular::SystemDef systemDef(const btDiscreteDynamicsWorld& world, const LayerDef& def) {
  granular::requirePositive(def.kinematicSpeedLimit, "LayerDef.kinematicSpeedLimit", "m/s");
  granular::requirePositive(def.restingDepth, "LayerDef.restingDepth", "");
  granular::require(def.drawnParticleLimit >= 0, "LayerDef.drawnParticleLimit", def.drawnParticleLimit, "",
                    ">= 0");
  checkBudget(def.budget);
  return {.gravity = fromBullet(world.getGravity()),
          .integrator = def.integrator,
          .sleep = def.sleep,
          .threads = def.threads,
          .executor = def.executor};
}

/// A plane that the program makes dynamic has no place in the core's integration: there it stands still
/// wherever Bullet puts it.
granular::BodyMotion motionOf(const btRigidBody& body, bool isPlane) {
  if (body.isKinematicObject()) return granular::BodyMotion::Kinematic;
  if (body.isStaticObject() || body.getInvMass() == btScalar(0)) return granular::BodyMotion::Static;
  return isPlane ? granular::BodyMotion::Static : granular::BodyMotion::Dynamic;
}

/// Of the solids among the parts: ground and sheets have no thickness that particles must fit into.
double leastExtent(const std::vector<ShapePart>& parts) {
  double least = std::numeric_limits<double>::infinity();
  for (const ShapePart& part : parts) {
    if (part.kind == PartKind::Solid)
      least = std::min(least, granular::boundingBox(part.mesh).size().minCoeff());
  }
  return least;
}

/// Edges of the box round the body's shape, m.
Vector3 sizeOf(const btRigidBody& body) {
  btVector3 low, high;
  body.getCollisionShape()->getAabb(btTransform::getIdentity(), low, high);
  return fromBullet(high) - fromBullet(low);
}

/// Of the box round the body's shape, m^2.
double largestSideOf(const btRigidBody& body) {
  const Vector3 size = sizeOf(body);
  return size.prod() / size.minCoeff();
}

/// m/s^2; that of the earth where there is none, or one that makes no sense.
double gravityOf(const btRigidBody& body) {
  constexpr double kEarthGravity = 9.81;
  const double own = fromBullet(body.getGravity()).norm();
  return own > 0.0 && std::isfinite(own) ? own : kEarthGravity;
}

/// Ground and sheets enclose no mass.
void requireSolidIfDynamic(const btRigidBody& body, const std::vector<ShapePart>& parts) {
  if (body.isStaticOrKinematicObject()) return;
  for (const ShapePart& part : parts) {
    if (part.kind == PartKind::Solid) continue;
    throw std::invalid_argument(std::string("coverBody: the surface of the body's shape ") +
                                body.getCollisionShape()->getName() +
                                " is open; the body must be static or kinematic");
  }
}

granular::Covering seenFrom(const granular::Pose& frame, granular::Covering covering) {
  for (Vector3& p : covering.positions) p = frame.toOwn(p);
  for (granular::SurfacePiece& piece : covering.pieces) {
    for (Vector3& corner : piece.corners) corner = frame.toOwn(corner);
  }
  return covering;
}

double boundingRadiusOf(const granular::Covering& covering) {
  double radius = 0.0;
  for (std::size_t i = 0; i < covering.positions.size(); ++i) {
    radius = std::max(radius, covering.positions[i].norm() + covering.radii[i]);
  }
  return radius;
}

granular::GrainShapeDef pileShape(const PileDef& def) {
  switch (def.shape) {
    case PileShape::Sphere:
      return granular::sphereShape(def.particleRadius);
    case PileShape::Cube:
      return granular::cubeShape(def.particleRadius);
    case PileShape::Tetrahedron:
      break;
  }
  return granular::tetrahedronShape(def.particleRadius);
}

/// Particles already in the world that reach into a box.
std::vector<granular::ShapeParticle> particlesIn(const granular::Box& box,
                                                 const granular::GranularSystem& system) {
  std::vector<granular::ParticleView> all;
  system.readParticles(all);
  std::vector<granular::ShapeParticle> inside;
  for (const granular::ParticleView& p : all) {
    const Vector3 nearest = p.position.cwiseMax(box.lower).cwiseMin(box.upper);
    if ((nearest - p.position).norm() < p.radius)
      inside.push_back({.position = p.position, .radius = p.radius});
  }
  return inside;
}

template <class Act>
void forEachGrain(const granular::GranularSystem& system, Act act) {
  const auto slots = static_cast<std::int32_t>(system.grainMotions().size());
  for (std::int32_t i = 0; i < slots; ++i) {
    const granular::GrainId id = system.grainAt(i);
    if (id.index >= 0) act(id);
  }
}

/// Radius of the smallest particle of any grain; infinite without grains.
double smallestGrainParticle(const granular::GranularSystem& system) {
  double smallest = std::numeric_limits<double>::infinity();
  forEachGrain(system, [&](granular::GrainId id) {
    for (const auto& p : system.grainShape(system.shapeOf(id)).particles) {
      smallest = std::min(smallest, p.radius * system.scaleOf(id));
    }
  });
  return smallest;
}

}  // namespace

Layer::Layer(btDiscreteDynamicsWorld& world, const LayerDef& def, bool framesAreTold)
    : world_(world), def_(def), framesAreTold_(framesAreTold), system_(systemDef(world, def)) {}

void Layer::setBudget(const granular::WorkBudget& budget) {
  checkBudget(budget);
  def_.budget = budget;
}

// ---- grains

std::vector<granular::GrainId> Layer::addPile(const PileDef& def) {
  granular::requirePositive(def.particleRadius, "PileDef.particleRadius", "m");
  granular::requireFinite(def.region.lower, "PileDef.region.lower", "m");
  granular::requireFinite(def.region.upper, "PileDef.region.upper", "m");
  granular::require((def.region.size().array() > 0.0).all(), "PileDef.region.size()",
                    def.region.size().transpose(), "m", "> 0 in all components");
  const granular::GrainShapeDef shapeDef = pileShape(def);
  const auto placed = granular::fillRegion(granular::boxRegion(def.region), shapeDef,
                                           {.seed = def.seed, .obstacles = particlesIn(def.region, system_)});
  const granular::GrainShapeId shape = system_.addGrainShape(shapeDef);
  const granular::MaterialId material = def.material ? *def.material : pileMaterial();
  std::vector<granular::GrainId> grains;
  for (const granular::PlacedGrain& grain : placed) {
    grains.push_back(system_.addGrain({.shape = shape,
                                       .material = material,
                                       .pose = grain.pose,
                                       .scale = grain.scale,
                                       .filter = def.filter}));
  }
  if (queries_) queries_->update(system_);
  return grains;
}

double Layer::largestGrainRadius() const {
  double largest = 0.0;
  forEachGrain(system_, [&](granular::GrainId id) {
    largest = std::max(largest, system_.grainShape(system_.shapeOf(id)).boundingRadius * system_.scaleOf(id));
  });
  return largest;
}

// ---- covering

void Layer::checkCoverable(const btRigidBody& body) const {
  if (isCovered(body))
    throw std::invalid_argument("coverBody: the body is covered already; uncover it first");
  const auto& objects = world_.getCollisionObjectArray();
  const int index = body.getWorldArrayIndex();
  if (index < 0 || index >= objects.size() || objects[index] != &body) {
    throw std::invalid_argument("coverBody: the body is not in this world; call addRigidBody first");
  }
  if (!isFinite(stateOf(body))) {
    throw std::invalid_argument("coverBody: the body's transform or velocity is not finite");
  }
  granular::require(std::isfinite(body.getFriction()) && std::isfinite(body.getRestitution()),
                    "coverBody: the body's friction and restitution",
                    Vector3(body.getFriction(), body.getRestitution(), 0.0).head<2>().transpose(), "",
                    "finite");
  if (!body.isStaticOrKinematicObject()) {
    granular::require(body.getInvMass() > 0, "coverBody: the body's inverse mass", body.getInvMass(), "1/kg",
                      "> 0 for a dynamic body");
    const Vector3 inverse = fromBullet(body.getInvInertiaDiagLocal());
    granular::require((inverse.array() > 0.0).all() || inverse.isZero(0.0),
                      "coverBody: the body's inverse inertia", inverse.transpose(), "1/(kg m^2)",
                      "> 0 in all components, or 0 in all for a body that does not turn");
  }
}

double Layer::defaultParticleRadius(const std::vector<ShapePart>& parts, double discs) const {
  const double fromGrains = smallestGrainParticle(system_);
  if (std::isfinite(fromGrains)) return fromGrains;
  double area = 0.0;
  for (const ShapePart& part : parts) area += granular::surfaceArea(part.mesh);
  return std::min(std::sqrt(area / (discs * std::numbers::pi)), 0.25 * leastExtent(parts));
}

granular::Covering Layer::makeCovering(const btRigidBody& body, const CoverBodyDef& def) const {
  if (def.covering) return *def.covering;
  granular::requireNotNegative(def.particleRadius, "CoverBodyDef.particleRadius", "m");
  const std::vector<ShapePart> parts = def.surface ? std::vector{partOf(*def.surface)}
                                                   : shapeParts(*body.getCollisionShape(), def.shapeSurface);
  requireSolidIfDynamic(body, parts);
  granular::CoverDef cover;
  cover.offset = def.offset;
  cover.density = def.density;
  cover.sheetThickness = def.sheetThickness;
  cover.seed = def.seed;
  const bool isBox = !def.surface && body.getCollisionShape()->getShapeType() == BOX_SHAPE_PROXYTYPE &&
                     meetsBodiesExactly(body, def);
  cover.particleRadius = def.particleRadius > 0.0
                             ? def.particleRadius
                             : defaultParticleRadius(parts, isBox ? kDiscsOfABox : kDefaultDiscs);
  const double grain = smallestGrainParticle(system_);
  if (std::isfinite(grain)) cover.smallestGrainRadius = grain;
  cover.threads = system_.threads();
  return coverParts(parts, cover);
}

/// Where the solid has its mass, for bodies that can move. A frame and moments that are the btRigidBody's own
/// but for rounding are left to it.
void Layer::takeMassFrame(CoveredBody& covered, const CoverBodyDef& def) const {
  const btRigidBody& body = *covered.body;
  if (def.mass == MassSource::Body || def.covering || body.isStaticOrKinematicObject()) return;
  const double mass = 1.0 / double(body.getInvMass());
  const granular::MassProperties solid =
      def.surface ? surfaceMass(*def.surface, mass) : shapeMass(*body.getCollisionShape(), mass);
  const double size = std::sqrt(solid.principalMoments.maxCoeff() / mass);
  const Vector3 own = fromBullet(body.getInvInertiaDiagLocal());
  const bool sameMoments =
      (own.cwiseProduct(solid.principalMoments) - Vector3::Ones()).cwiseAbs().maxCoeff() < kMassRounding;
  const bool sameFrame = solid.centerOfMass.norm() < kMassRounding * size &&
                         solid.principalFrame.orientation.vec().norm() < kMassRounding;
  if (sameMoments && sameFrame) return;
  covered.momentsPerMass = solid.principalMoments / mass;
  covered.coreFrame = solid.principalFrame;
}

/// What meets bodies may be coarser than what meets grains.
double Layer::exactSpacing(const btRigidBody& body, const CoverBodyDef& def) const {
  granular::requireNotNegative(def.exactSpacing, "CoverBodyDef.exactSpacing", "m");
  if (def.exactSpacing > 0.0) return def.exactSpacing;
  const double fromGrains = smallestGrainParticle(system_);
  if (def.contact == SurfaceContact::Exact && std::isfinite(fromGrains)) return 0.5 * fromGrains;
  return sizeOf(body).maxCoeff() / 64.0;
}

/// What of the body is met: its exact surface, or what is returned, or both.
granular::Covering Layer::takeSurface(CoveredBody& covered, const CoverBodyDef& def) const {
  const btRigidBody& body = *covered.body;
  const bool isExact = def.contact == SurfaceContact::Exact;
  granular::Covering covering;
  if (isExact) {
    checkExactDef(def);
  } else {
    covering = makeCovering(body, def);
  }
  if (isExact || meetsBodiesExactly(body, def)) {
    const ExactShape shape = exactShape(body, def, exactSpacing(body, def), system_.threads());
    covered.exact = shape.surface;
    covered.exactFrame = shape.frame;
    covered.exactUse = isExact ? granular::ExactUse::Everything : granular::ExactUse::Bodies;
    covered.boundingRadius = shape.boundingRadius;
  }
  if (covered.isPlane()) covered.coreFrame = covered.exactFrame;
  return covering;
}

granular::BodyId Layer::cover(btRigidBody& body, const CoverBodyDef& def) {
  checkCoverable(body);
  CoveredBody covered;
  covered.body = &body;
  covered.followsBodyMaterial = !def.material;
  if (def.material) covered.make.material = *def.material;
  granular::Covering covering = takeSurface(covered, def);
  takeMassFrame(covered, def);
  if (covered.hasParticles()) {
    covering = seenFrom(covered.coreFrame, std::move(covering));
    covered.boundingRadius = boundingRadiusOf(covering);
  } else {
    covered.boundingRadius += (covered.exactFrame.position - covered.coreFrame.position).norm();
  }
  covered.largestSide = largestSideOf(body);
  covered.gravity = gravityOf(body);
  covered.make = makeOf(covered);
  covered.worldIndex = body.getWorldArrayIndex();
  covered.proxyId = body.getBroadphaseHandle()->m_uniqueId;
  covered.written = stateOf(body);
  covered.frameEnd = fromBullet(body.getWorldTransform());
  addToSystem(covered, std::move(covering),
              coreMotion(covered, {.pose = covered.frameEnd,
                                   .velocity = fromBullet(body.getLinearVelocity()),
                                   .angularVelocity = fromBullet(body.getAngularVelocity())}));
  noteFilteredPairs(body);
  slots_[&body] = bodies_.size();
  bodies_.push_back(covered);
  return covered.id;
}

void Layer::uncover(const btRigidBody& body) {
  const auto found = slots_.find(&body);
  if (found == slots_.end()) throw std::invalid_argument("uncoverBody: the body is not covered");
  drop(found->second);
}

/// Touches the body's address only.
void Layer::drop(std::size_t slot) {
  system_.removeBody(bodies_[slot].id);
  for (std::set<Pair>* pairs : {&bulletOwned_, &filteredOut_, &excluded_})
    forgetPairsOf(*bodies_[slot].body, *pairs);
  bodies_.erase(bodies_.begin() + static_cast<std::ptrdiff_t>(slot));
  slots_.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i) slots_[bodies_[i].body] = i;
  wakeAll_ = true;
}

/// Bullet tells nobody that a body went, and another may have been given its address: the proxy's number
/// tells them apart.
bool Layer::isInWorld(CoveredBody& covered) const {
  const auto& objects = world_.getCollisionObjectArray();
  if (covered.worldIndex >= objects.size() || objects[covered.worldIndex] != covered.body) {
    covered.worldIndex = objects.findLinearSearch(covered.body);
  }
  return covered.worldIndex < objects.size() && covered.body->getBroadphaseHandle() &&
         covered.body->getBroadphaseHandle()->m_uniqueId == covered.proxyId;
}

void Layer::forgetRemoved() {
  for (std::size_t i = bodies_.size(); i-- > 0;) {
    if (!isInWorld(bodies_[i])) drop(i);
  }
}

granular::BodyId Layer::idOf(const btRigidBody& body) const {
  const CoveredBody* covered = find(&body);
  if (!covered) throw std::invalid_argument("bodyIdOf: the body is not covered");
  return covered->id;
}

granular::Pose Layer::massFrameOf(const btRigidBody& body) const {
  const CoveredBody* covered = find(&body);
  if (!covered) throw std::invalid_argument("massFrameOf: the body is not covered");
  return covered->coreFrame;
}

const CoveredBody* Layer::find(const btCollisionObject* object) const {
  const auto found = slots_.find(object);
  return found == slots_.end() ? nullptr : &bodies_[found->second];
}

BodyMake Layer::makeOf(const CoveredBody& covered) {
  const btRigidBody& body = *covered.body;
  const btBroadphaseProxy& proxy = *body.getBroadphaseHandle();
  BodyMake make{.motion = motionOf(body, covered.isPlane()), .material = covered.make.material};
  if (body.hasContactResponse()) {
    make.group = static_cast<std::uint32_t>(proxy.m_collisionFilterGroup);
    make.mask = static_cast<std::uint32_t>(proxy.m_collisionFilterMask);
  }
  const bool isUsable = std::isfinite(body.getFriction()) && std::isfinite(body.getRestitution()) &&
                        std::isfinite(body.getInvMass());
  if (covered.followsBodyMaterial && isUsable) make.material = bodyMaterial(covered);
  return make;
}

void Layer::addToSystem(CoveredBody& covered, granular::Covering covering,
                        const granular::RigidMotion& motion) {
  granular::BodyDef def;
  def.motion = covered.make.motion;
  def.covering = std::move(covering);
  def.exact = covered.exact;
  def.exactUse = covered.exactUse;
  def.exactPose = composed(inverse(covered.coreFrame), covered.exactFrame);
  def.material = covered.make.material;
  def.pose = motion.pose;
  def.filter = {.group = covered.make.group, .mask = covered.make.mask};
  if (def.motion == granular::BodyMotion::Dynamic) {
    def.velocity = motion.velocity;
    def.angularVelocity = motion.angularVelocity;
    covered.settings = settingsOf(covered, false);
    def.mass = covered.settings.mass;
    def.principalInertia = covered.settings.principalInertia;
    def.linearFactor = covered.settings.linearFactor;
    def.angularFactor = covered.settings.angularFactor;
  }
  covered.id = system_.addBody(def);
}

void Layer::remakeIfChanged(CoveredBody& covered) {
  const BodyMake make = makeOf(covered);
  if (make == covered.make) return;
  granular::Covering covering = system_.covering(covered.id);
  const granular::RigidMotion motion = system_.bodyMotion(covered.id);
  covered.frameEnd = bulletPose(covered);
  system_.removeBody(covered.id);
  forgetPairsOf(*covered.body, excluded_);
  covered.make = make;
  covered.frameTimeLeft = 0.0;
  addToSystem(covered, std::move(covering), motion);
  wakeAll_ = true;
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge

// SPDX-License-Identifier: MIT
// Materials of the core for bodies and piles: Bullet's friction and restitution, and how stiff bodies are
// against each other.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "bullet_bridge/layer.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

/// Lowest restitution between bodies: the dashpot of a fully plastic impact is infinite.
constexpr double kLeastRestitution = 0.1;
/// Of the spring of static friction, as a fraction of critical damping: a body pushed aside and held by
/// friction must not swing on. Half of it stops within two swings and asks for no shorter a sub-step.
constexpr double kFrictionDamping = 0.5;

/// Least duration of an impact of a jointed body, in ticks.
constexpr double kTicksOfAnImpact = 2.0;

constexpr double kRigid = std::numeric_limits<double>::infinity();

}  // namespace

granular::MaterialId Layer::pileMaterial() {
  if (!pileMaterial_) pileMaterial_ = system_.addMaterial({});
  return *pileMaterial_;
}

/// N/m^3. Two alike are springs one behind the other: twice as stiff each as what carries the weight. A body
/// that joints hold: Bullet puts it right once a tick, by up to g dt^2, into whatever it touches; a contact
/// that lasts a tick at least bears that, a stiffer one throws the body. Rounded up to a power of two, so
/// that bodies of many masses and sizes have few materials.
double Layer::stiffnessOf(const CoveredBody& covered) const {
  if (covered.body->isStaticOrKinematicObject()) return kRigid;
  const double mass = 1.0 / double(covered.body->getInvMass());
  const double area = covered.largestSide;
  double stiffness = 2.0 * mass * covered.gravity / (def_.restingDepth * area * std::sqrt(area));
  if (covered.jointTick > 0.0) {
    const double frequency = std::numbers::pi / (kTicksOfAnImpact * covered.jointTick);
    stiffness = std::min(stiffness, mass * frequency * frequency / area);
  }
  const bool isUsable = std::isfinite(stiffness) && stiffness > 0.0;
  return isUsable ? std::exp2(std::ceil(std::log2(stiffness))) : kRigid;
}

/// One core material for each kind of body seen, paired with all others.
granular::MaterialId Layer::bodyMaterial(const CoveredBody& covered) {
  const btRigidBody& body = *covered.body;
  BodyMaterial material{.friction = std::max(body.getFriction(), btScalar(0)),
                        .restitution = std::clamp(body.getRestitution(), btScalar(0), btScalar(1)),
                        .stiffness = stiffnessOf(covered),
                        .id = {}};
  for (const BodyMaterial& known : bodyMaterials_) {
    if (known.friction == material.friction && known.restitution == material.restitution &&
        known.stiffness == material.stiffness)
      return known.id;
  }
  material.id = system_.addMaterial({.name = "body with friction " + std::to_string(material.friction) +
                                             " and restitution " + std::to_string(material.restitution),
                                     .restitution = std::max(kLeastRestitution, double(material.restitution)),
                                     .friction = double(material.friction)});
  bodyMaterials_.push_back(material);
  for (const BodyMaterial& other : bodyMaterials_) pairMaterials(material, other);
  return material.id;
}

/// Friction and restitution by Bullet's product rule, friction held by a spring, foundations one behind the
/// other. What is rigid never meets its like.
void Layer::pairMaterials(const BodyMaterial& a, const BodyMaterial& b) {
  if (a.stiffness == kRigid && b.stiffness == kRigid) return;
  granular::MaterialPairDef pair;
  pair.restitution = std::max(kLeastRestitution, double(a.restitution) * double(b.restitution));
  pair.friction = double(a.friction) * double(b.friction);
  pair.bodyNormal.stiffness = 1.0 / (1.0 / a.stiffness + 1.0 / b.stiffness);
  pair.shear = {.law = granular::ShearLaw::StaticFriction, .dampingRatio = kFrictionDamping};
  system_.setMaterialPair(a.id, b.id, pair);
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge

// SPDX-License-Identifier: MIT
// One impact of a ball, simulated through GranularSystem as a user would: against the exact half-space below
// y = 0, another ball below it, or a heavy body that carries one particle. No gravity.
#pragma once

#include <optional>
#include <vector>

#include "granular/granular.h"

namespace granular::verification {

/// A round solid and what it is made of.
struct Ball {
  double radius = 0.01;        ///< m
  double youngsModulus = 1e7;  ///< Pa
  double poissonRatio = 0.3;
  double density = 2500.0;  ///< kg/m^3
  double friction = 0.0;
};

double massOf(const Ball& ball);  ///< kg
MaterialDef materialOf(const Ball& ball);

/// Young's modulus of a partner that does not yield, Pa: E* is that of the ball alone, to 1e-8 and better.
inline constexpr double kRigid = 1e22;

enum class Partner { Plane, Ball, CoveredBody };

struct ImpactDef {
  Ball ball = {};
  Partner partner = Partner::Plane;
  Ball other = {};  ///< the partner; of a plane the material alone counts, of a covered body its one particle
  double bodyMass = 0.0;                ///< of Partner::CoveredBody, kg
  MaterialPairDef pair = {};            ///< what holds between the two
  Vector3 velocity = {0.0, -1.0, 0.0};  ///< of the ball against the partner, m/s; towards it is -y
  Vector3 spin = Vector3::Zero();       ///< of the ball, rad/s
  Vector3 otherSpin = Vector3::Zero();  ///< of the partner, unless it is a plane
  double gap = 0.1;                     ///< before the impact, in radii of the ball
  IntegratorDef integrator = {};
  double step = 0.0;         ///< of GranularSystem::step, s; > 0
  bool keepHistory = false;  ///< read overlap and force after each step
};

struct ImpactSample {
  double time = 0.0;                ///< since the surfaces met, s
  double overlap = 0.0;             ///< m
  Vector3 force = Vector3::Zero();  ///< on the ball, N
};

struct ImpactResult {
  Vector3 velocity, spin;  ///< of the ball against the frame in which the partner was at rest, afterwards
  Vector3 otherVelocity, otherSpin;
  double restitution = 0.0;
  double contactTime = 0.0;  ///< s, between the meeting and the parting of the undeformed surfaces
  double energyBefore = 0.0, energyAfter = 0.0;  ///< J
  std::vector<ImpactSample> history;             ///< of the steps with an overlap

  /// Largest overlap (m) and normal force (N), by a parabola through the three largest samples.
  double largestOverlap() const;
  double largestForce() const;
};

/// Throws std::runtime_error if they never part.
ImpactResult simulateImpact(const ImpactDef& def);

/// kr (eq. 15) and m_eff (eq. 11) of the impact; of a covered body, its mass counts.
double hertzStiffness(const ImpactDef& def);
double effectiveMass(const ImpactDef& def);
/// Of the elastic Hertz impact with the normal speed of `def`: duration, s, and depth, m (Landau & Lifshitz,
/// Theory of Elasticity, sec. 9).
double hertzDuration(const ImpactDef& def);
double hertzDepth(const ImpactDef& def);

/// Integrator settings of the cases that ask what the law does, not what the integrator does. The tolerance
/// is in radii, so it follows the depth of the impact, in radii.
IntegratorDef convergedIntegrator(double depth);
IntegratorDef convergedIntegrator(const ImpactDef& def);

/// A static body that is the exact half-space below the plane through `point` with the normal `up`.
BodyId addPlane(GranularSystem& system, MaterialId material, const Vector3& point = Vector3::Zero(),
                const Vector3& up = Vector3::UnitY());

}  // namespace granular::verification

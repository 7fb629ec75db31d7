// SPDX-License-Identifier: MIT
// The force of one contact, put together at compile time from a normal law and a shear law (Bell 2005, sec.
// 2).
#pragma once

#include <algorithm>
#include <cmath>

#include "granular/base/pose.h"
#include "granular/contact/law_constants.h"

namespace granular {

/// Where two particles meet and how they move there; or several pairs of them.
template <class Real>
struct ContactGeometryOf {
  Real xi = 0.0;                                ///< overlap, m, > 0 (eq. 1)
  Vector3Of<Real> N = Vector3Of<Real>::Zero();  ///< line of centres, from 1 to 2 (eq. 2)
  Vector3Of<Real> point =
      Vector3Of<Real>::Zero();  ///< p = x1 + (R1 - xi/2) N, on a plane: the plane, m, world
  Vector3Of<Real> V =
      Vector3Of<Real>::Zero();  ///< relative velocity of 1 against 2 at the point, m/s (eq. 3)
  Vector3Of<Real> turning =
      Vector3Of<Real>::Zero();  ///< angular velocity of the contact's own frame, rad/s; laws with memory only
  MaskOf<Real> slides = MaskOf<Real>(false);  ///< when the last sub-step was accepted; laws with memory only
  MaskOf<Real> isNew = MaskOf<Real>(false);   ///< begun within the present trial; laws with memory only
  Real memoryStep = 0.0;       ///< by how much D moves on, at the rate found here, before it pulls, s
  Real stiffnessBefore = 0.0;  ///< of the spring when the last sub-step was accepted, N/m; 0: not known
  Real share = 1.0;        ///< times the law: area, m^2, for laws by area; else 1, or the slope of a distance
  Real shareGrowth = 0.0;  ///< how fast that grows with the overlap, of itself, 1/m
  Real meanSquareOverlap = 0.0;  ///< over the area, m^2; laws by area only
};
using ContactGeometry = ContactGeometryOf<double>;

/// Memory of a contact (eq. 19) before and after the law has seen it.
template <class Real>
struct ContactMemoryOf {
  Vector3Of<Real> rate = Vector3Of<Real>::Zero();          ///< of what the trial integrates for D, m/s
  Vector3Of<Real> displacement = Vector3Of<Real>::Zero();  ///< D once the sub-step is accepted, m
  Vector3Of<Real> nextRate = Vector3Of<Real>::Zero();      ///< the rate with which the next trial begins, m/s
  Real stiffness = 0.0;                                    ///< of the spring, N/m
  MaskOf<Real> slides = MaskOf<Real>(false);               ///< from then on
  Real loss = 0.0;     ///< energy given up when the sub-step is accepted, J
  Real heating = 0.0;  ///< what that adds to the dissipation at this moment, W
};
using ContactMemory = ContactMemoryOf<double>;

/// What a contact does.
template <class Real>
struct ContactResultOf {
  Vector3Of<Real> force;  ///< on particle 1, N
  Real dissipation;       ///< power turned into heat, W
  Real normalForce;       ///< its magnitude, N, > 0 pushes apart
  /// How much of the force goes with the relative velocity, in any direction, N s/m; laws without memory
  /// only.
  Real damping = 0.0;
};
using ContactResult = ContactResultOf<double>;

/// Exponent p of kt ~ xi^p.
template <class Normal, class Real>
Real stiffnessPower(const ShearConstantsOf<Real>& shear) {
  return select(shear.stiffness > 0.0, Real(0.0), Real(Normal::kStiffnessPower));
}

/// A contact under laws without memory (eqs. 16 and 18), or several at a time.
template <class Normal, class Shear, class Real>
ContactResultOf<Real> resultWithoutMemory(const NormalConstantsOf<Real>& normal,
                                          const ShearConstantsOf<Real>& shear,
                                          const ContactGeometryOf<Real>& g) {
  const Real xiDot = g.V.dot(g.N);                     // eq. 4
  const Vector3Of<Real> Vt = g.V - xiDot * g.N;        // eq. 5
  const Real fn = Normal::force(normal, g.xi, xiDot);  // eqs. 6-7; by area: a pressure
  const Real friction = max(Real(0.0), fn);
  const Vector3Of<Real> Ft = Shear::force(shear, friction, Vt);
  const Real heat = (fn - Normal::elasticForce(normal, g.xi)) * xiDot - Ft.dot(Vt);
  const Real damping = Normal::damping(normal, g.xi) + Shear::viscosity(shear, friction, Vt);
  return {.force = g.share * (Ft - fn * g.N),
          .dissipation = g.share * heat,
          .normalForce = g.share * fn,
          .damping = g.share * damping};
}

/// Energy of a spring that remembers, J.
template <class Real>
Real memoryEnergy(const Real& stiffness, const Vector3Of<Real>& displacement) {
  return 0.5 * stiffness * displacement.squaredNorm();
}

/// A contact under laws with memory (eqs. 17 and 19), or several at a time. D, m: displacement that the
/// contact remembers, times how much stiffer its spring has become since the last sub-step was accepted.
template <class Normal, class Shear, class Real>
ContactResultOf<Real> resultWithMemory(const NormalConstantsOf<Real>& normal,
                                       const ShearConstantsOf<Real>& shear, const ContactGeometryOf<Real>& g,
                                       const Vector3Of<Real>& D, ContactMemoryOf<Real>& memory) {
  using Vector = Vector3Of<Real>;
  const Real zero = 0.0;
  const Real xiDot = g.V.dot(g.N);                     // eq. 4
  const Vector Vt = g.V - xiDot * g.N;                 // eq. 5
  const Real fn = Normal::force(normal, g.xi, xiDot);  // eqs. 6-7; by area: a pressure
  const Real kn = Normal::tangentStiffness(normal, g.xi);
  const Real kt = select(shear.stiffness > 0.0, shear.stiffness, Real(shear.stiffnessRatio * kn));
  const Real growth = (stiffnessPower<Normal>(shear) / g.xi + g.shareGrowth) * xiDot;  // kt' / kt
  const Real friction = max(zero, fn);
  // Differs from the paper, whose kt is constant: where kt grows with the overlap, a contact pressed deeper
  // keeps its force, not its displacement, else it would give back more energy than it took (Elata &
  // Berryman 1996). Test: Verification 4.spring-makes-no-energy-when-pressed-deeper. So D' = Vt - D kt'/kt
  // while kt grows, which has no bound as a contact begins. Integrated is D kt/kt(before) instead, whose
  // rate has one. Tests: ContactMemory.*.
  memory.stiffness = g.share * kt;
  const Real stiffer =
      select(g.stiffnessBefore > 0.0, max(Real(1.0), Real(memory.stiffness / g.stiffnessBefore)), Real(1.0));
  const auto rateOf = [&](const Vector& d) -> Vector { return stiffer * Vt + g.turning.cross(d); };
  const auto acrossN = [&](const Vector& d) -> Vector { return d - d.dot(g.N) * g.N; };
  Vector Dt = acrossN(D);
  memory.rate = rateOf(Dt);
  memory.rate = rateOf(Dt + g.memoryStep * memory.rate);
  const Real softer = 1.0 / stiffer;
  Dt = softer * acrossN(Dt + g.memoryStep * memory.rate);
  memory.nextRate = softer * memory.rate;
  const MaskOf<Real> slid = g.slides || g.isNew;
  const Vector Ft = Shear::force(shear, friction, kt, Vt, Dt, slid);
  memory.slides = Shear::slides(shear, friction, kt, Vt, Dt, slid);
  memory.displacement = Shear::settled(shear, friction, kt, Vt, Dt, memory.slides);
  memory.loss = memoryEnergy(memory.stiffness, Dt) - memoryEnergy(memory.stiffness, memory.displacement);
  const auto heating =
      [&](const Vector& d) -> Real {  // what the spring at d takes from the power of friction
    return kt * d.dot(Vt) - 0.5 * max(growth, Real(-growth)) * kt * d.squaredNorm();
  };
  memory.heating = g.share * (heating(Dt) - heating(memory.displacement));
  const Real heat = (fn - Normal::elasticForce(normal, g.xi)) * xiDot - Ft.dot(Vt) - heating(Dt);
  return {.force = g.share * (Ft - fn * g.N), .dissipation = g.share * heat, .normalForce = g.share * fn};
}

/// One contact; D as above. memory: filled for laws that have one, may be null for others.
template <class Normal, class Shear>
ContactResult contactResult(const NormalConstants& normal, const ShearConstants& shear,
                            const ContactGeometry& g, const Vector3& D, ContactMemory* memory) {
  if constexpr (Shear::kHasMemory) {
    return resultWithMemory<Normal, Shear, double>(normal, shear, g, D, *memory);
  } else {
    return resultWithoutMemory<Normal, Shear, double>(normal, shear, g);
  }
}

}  // namespace granular

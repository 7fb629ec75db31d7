// SPDX-License-Identifier: MIT
// The force of one contact, put together at compile time from a normal law and a shear law (Bell 2005, sec.
// 2).
#pragma once

#include <algorithm>
#include <cmath>

#include "granular/base/pose.h"
#include "granular/contact/law_constants.h"

namespace granular {

/// Where two particles meet and how they move there.
struct ContactGeometry {
  double xi = 0.0;                  ///< overlap, m, > 0 (eq. 1)
  Vector3 N = Vector3::Zero();      ///< line of centres, from 1 to 2 (eq. 2)
  Vector3 point = Vector3::Zero();  ///< p = x1 + (R1 - xi/2) N, on a plane: the plane, m, world
  Vector3 V = Vector3::Zero();      ///< relative velocity of 1 against 2 at the point, m/s (eq. 3)
  Vector3 turning =
      Vector3::Zero();      ///< angular velocity of the contact's own frame, rad/s; laws with memory only
  bool slides = false;      ///< when the last sub-step was accepted; laws with memory only
  bool isNew = false;       ///< begun within the present trial; laws with memory only
  double memoryStep = 0.0;  ///< by how much D moves on, at the rate found here, before it pulls, s
  double stiffnessBefore = 0.0;  ///< of the spring when the last sub-step was accepted, N/m; 0: not known
  double share = 1.0;  ///< times the law: area, m^2, for laws by area; else 1, or the slope of a distance
  double shareGrowth = 0.0;        ///< how fast that grows with the overlap, of itself, 1/m
  double meanSquareOverlap = 0.0;  ///< over the area, m^2; laws by area only
};

/// Memory of a contact (eq. 19) before and after the law has seen it.
struct ContactMemory {
  Vector3 rate = Vector3::Zero();          ///< of what the trial integrates for D, m/s
  Vector3 displacement = Vector3::Zero();  ///< D once the sub-step is accepted, m
  Vector3 nextRate = Vector3::Zero();      ///< the rate with which the next trial begins, m/s
  double stiffness = 0.0;                  ///< of the spring, N/m
  bool slides = false;                     ///< from then on
  double loss = 0.0;                       ///< energy given up when the sub-step is accepted, J
  double heating = 0.0;                    ///< what that adds to the dissipation at this moment, W
};

/// What a contact does.
template <class Real>
struct ContactResultOf {
  Vector3Of<Real> force;  ///< on particle 1, N
  Real dissipation;       ///< power turned into heat, W
  Real normalForce;       ///< its magnitude, N, > 0 pushes apart
};
using ContactResult = ContactResultOf<double>;

/// Exponent p of kt ~ xi^p.
template <class Normal>
double stiffnessPower(const ShearConstants& shear) {
  return shear.stiffness > 0.0 ? 0.0 : Normal::kStiffnessPower;
}

/// A contact under laws without memory (eqs. 16 and 18), or several at a time.
template <class Normal, class Shear, class Real>
ContactResultOf<Real> resultWithoutMemory(const NormalConstantsOf<Real>& normal,
                                          const ShearConstantsOf<Real>& shear, const Real& xi,
                                          const Vector3Of<Real>& N, const Vector3Of<Real>& V) {
  const Real xiDot = V.dot(N);                       // eq. 4
  const Vector3Of<Real> Vt = V - xiDot * N;          // eq. 5
  const Real fn = Normal::force(normal, xi, xiDot);  // eqs. 6-7; by area: a pressure
  const Vector3Of<Real> Ft = Shear::force(shear, Real(max(Real(0.0), fn)), Vt);
  return {.force = Ft - fn * N,
          .dissipation = (fn - Normal::elasticForce(normal, xi)) * xiDot - Ft.dot(Vt),
          .normalForce = fn};
}

/// Energy of a spring that remembers, J.
inline double memoryEnergy(double stiffness, const Vector3& displacement) {
  return 0.5 * stiffness * displacement.squaredNorm();
}

/// D, m: displacement that the contact remembers, times how much stiffer its spring has become since the last
/// sub-step was accepted. memory: filled for laws that have one, may be null for others.
template <class Normal, class Shear>
ContactResult contactResult(const NormalConstants& normal, const ShearConstants& shear,
                            const ContactGeometry& g, const Vector3& D, ContactMemory* memory) {
  if constexpr (!Shear::kHasMemory) {
    const ContactResult one = resultWithoutMemory<Normal, Shear, double>(normal, shear, g.xi, g.N, g.V);
    return {g.share * one.force, g.share * one.dissipation, g.share * one.normalForce};
  } else {                                                 // eqs. 17, 19
    const double xiDot = g.V.dot(g.N);                     // eq. 4
    const Vector3 Vt = g.V - xiDot * g.N;                  // eq. 5
    const double fn = Normal::force(normal, g.xi, xiDot);  // eqs. 6-7; by area: a pressure
    const double kn = Normal::tangentStiffness(normal, g.xi);
    const double kt = shear.stiffness > 0.0 ? shear.stiffness : shear.stiffnessRatio * kn;
    const double growth = (stiffnessPower<Normal>(shear) / g.xi + g.shareGrowth) * xiDot;  // kt' / kt
    const double friction = std::max(0.0, fn);
    // Differs from the paper, whose kt is constant: where kt grows with the overlap, a contact pressed deeper
    // keeps its force, not its displacement, else it would give back more energy than it took (Elata &
    // Berryman 1996). Test: Verification 4.spring-makes-no-energy-when-pressed-deeper. So D' = Vt - D kt'/kt
    // while kt grows, which has no bound as a contact begins. Integrated is D kt/kt(before) instead, whose
    // rate has one. Tests: ContactMemory.*.
    memory->stiffness = g.share * kt;
    const double stiffer =
        g.stiffnessBefore > 0.0 ? std::max(1.0, memory->stiffness / g.stiffnessBefore) : 1.0;
    const auto rateOf = [&](const Vector3& d) -> Vector3 { return stiffer * Vt + g.turning.cross(d); };
    Vector3 Dt = D - D.dot(g.N) * g.N;
    memory->rate = rateOf(Dt);
    if (g.memoryStep > 0.0) {
      memory->rate = rateOf(Dt + g.memoryStep * memory->rate);
      Dt += g.memoryStep * memory->rate;
      Dt -= Dt.dot(g.N) * g.N;
    }
    Dt /= stiffer;
    memory->nextRate = memory->rate / stiffer;
    const Vector3 Ft = Shear::force(shear, friction, kt, Vt, Dt, g.slides || g.isNew);
    memory->slides = Shear::slides(shear, friction, kt, Vt, Dt, g.slides || g.isNew);
    memory->displacement = Shear::settled(shear, friction, kt, Vt, Dt, memory->slides);
    memory->loss =
        memoryEnergy(memory->stiffness, Dt) - memoryEnergy(memory->stiffness, memory->displacement);
    const auto heating = [&](const Vector3& d) {  // what the spring at d takes from the power of friction
      return kt * d.dot(Vt) - 0.5 * std::abs(growth) * kt * d.squaredNorm();
    };
    memory->heating = g.share * (heating(Dt) - heating(memory->displacement));
    const double heat = (fn - Normal::elasticForce(normal, g.xi)) * xiDot - Ft.dot(Vt) - heating(Dt);
    return {g.share * (Ft - fn * g.N), g.share * heat, g.share * fn};
  }
}

}  // namespace granular

// SPDX-License-Identifier: MIT
// The numbers a law works with for one kind of pair, and what they are worked out from. Every law reads them
// its own way (see its file); none is virtual, none is looked up per contact.
#pragma once

#include <cmath>
#include <limits>

#include "granular/base/pack.h"
#include "granular/contact/elasticity.h"
#include "granular/contact/material.h"

namespace granular {

/// Constants of a normal law.
template <class Real>
struct NormalConstantsOf {
  Real kr = 0.0;                ///< stiffness, N/m^beta; N/m^3 for laws by area
  Real kd = 0.0;                ///< damping, N s/m^(1 + alpha); s/m for laws by area
  Real smallestForce = 0.0;     ///< 0: no attraction; -infinity: the damper may pull
  Real stiffnessPerMass = 0.0;  ///< kr / m_eff, for the contact time of Hertz laws
  Real impactRate = 0.0;  ///< one over the contact time of an elastic impact at the speed of the request, 1/s
};
using NormalConstants = NormalConstantsOf<double>;

/// Constants of a shear law.
template <class Real>
struct ShearConstantsOf {
  Real mu = 0.0;
  Real viscosity = 0.0;       ///< kt of eqs. 16 and 18, N s/m
  Real stiffness = 0.0;       ///< kt of eqs. 17 and 19 as given, N/m; 0: by the ratio
  Real stiffnessRatio = 0.0;  ///< tangential over normal tangent stiffness
  /// 1 / sqrt(kt m_t), m/(N s): the speed at which a loaded spring lets go, over its force
  Real slipCompliance = 0.0;
  Real dashpot = 0.0;  ///< beside the spring of eqs. 17 and 19, N s/m
};
using ShearConstants = ShearConstantsOf<double>;

/// What a normal law works its constants out from, for one contact or several at a time.
template <class Real>
struct NormalRequestOf {
  EffectiveContactOf<Real> contact;
  double damping = 0.0;     ///< dimensionless, as the law's own dampingForRestitution returned it
  double speed = 1.0;       ///< at which the restitution shall hold, m/s
  double bodyLength = 0.0;  ///< depth of the elastic layer of bodies, m; laws by area only
  double bodyArea = 0.0;    ///< what the smaller body can touch with at once, m^2; laws by area only
  NormalLawDef def;

  double smallestForce() const { return def.attraction ? -std::numeric_limits<double>::infinity() : 0.0; }
};
using NormalRequest = NormalRequestOf<double>;

/// Duration of an elastic Hertz impact at speed v, s: 3.218065 (m^2 / (kr^2 v))^(1/5) (Landau & Lifshitz,
/// Theory of Elasticity, sec. 9). mass = m_eff, kg.
inline constexpr double kHertzTime = 3.2180653;
template <class Real>
Real hertzContactTime(const Real& kr, const Real& mass, double v) {
  return kHertzTime * inverseFifthRoot(Real(kr * kr * v / (mass * mass)));
}

/// How pressing a contact is, in a measure that costs no root: (kHertzTime / contact time)^10. The largest
/// urgency is the shortest contact time.
inline double contactTimeOfUrgency(double urgency) {
  return kHertzTime * std::pow(urgency, -0.1);
}
/// rate: one over the contact time, 1/s.
template <class Real>
Real urgencyOfRate(const Real& rate) {
  const Real x = kHertzTime * rate, x2 = x * x, x5 = x2 * x2 * x;
  return x5 * x5;
}

}  // namespace granular

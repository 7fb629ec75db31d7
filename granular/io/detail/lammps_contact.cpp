// SPDX-License-Identifier: MIT
#include "granular/io/detail/lammps_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "granular/contact/law_list.h"

namespace granular::detail {
namespace {

// Coulomb's limit where there is none (eq. 16).
constexpr double kNoLimit = 1e10;
// Of a viscosity, as normal damping where there is no other: it takes no energy that could be seen, and lets
// LAMMPS, which knows tangential damping as a multiple of the normal one only, have the viscosity.
constexpr double kTrace = 1e-12;

/// LAMMPS's damping of `tsuji` from the restitution it is given (pair_style granular, after Tsuji 1992).
double tsujiDamping(double e) {
  return 1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))));
}

/// Its inverse. Restitutions below 0 are legal there and damp the more.
double tsujiRestitution(double damping) {
  double low = -1.0, high = 1.001;  // a(1) = 3e-4 is not quite zero
  while (tsujiDamping(low) < damping) low *= 2.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (tsujiDamping(middle) > damping ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The normal damper's constant at an overlap, N s/m.
double normalDamping(const PairLaw& law, double xi) {
  switch (law.normalLaw) {
    case NormalLaw::HertzViscoelastic:
      return law.normal.kd * std::sqrt(xi);
    case NormalLaw::HertzTsuji:
      return law.normal.kd * std::sqrt(std::sqrt(xi));
    default:
      return law.normal.kd;
  }
}

void setNormal(const PairLaw& law, const EffectiveContact& contact, LammpsContact& out) {
  const NormalConstants& c = law.normal;
  const bool isLinear = law.normalLaw == NormalLaw::LinearSpring;
  out.normal = isLinear ? "hooke" : "hertz";
  out.k = isLinear ? c.kr : c.kr / std::sqrt(contact.radius);
  out.limitDamping = c.smallestForce == 0.0;
  out.eta = c.kd;
  if (c.kd == 0.0) return;
  if (law.normalLaw == NormalLaw::HertzViscoelastic) {
    out.damping = "viscoelastic";
    out.eta = c.kd / (contact.mass * std::sqrt(contact.radius));
  } else if (law.normalLaw == NormalLaw::HertzTsuji) {
    out.damping = "tsuji";
    out.eta = tsujiRestitution(c.kd / std::sqrt(contact.mass * c.kr));
  }
}

/// Tangential damping `kt`, N s/m, as a multiple of the normal one.
void setTangentialDamping(const PairLaw& law, double kt, double speed, LammpsContact& out) {
  if (kt == 0.0) return;
  if (law.normal.kd == 0.0) {
    out.eta = kTrace * kt;
    out.x = 1.0 / kTrace;
    return;
  }
  const double time = withNormalLaw(law.normalLaw, [&]<class Law>(Law) {
    return contactTimeOfUrgency(Law::urgency(law.normal, 0.0, speed));
  });
  out.viscosityIsMatched = out.damping != "velocity";
  out.x = kt / normalDamping(law, kReferenceDepth * 0.5 * speed * time);
}

}  // namespace

LammpsContact lammpsContact(const PairLaw& law, const EffectiveContact& contact, double speed) {
  LammpsContact out;
  setNormal(law, contact, out);
  const ShearConstants& shear = law.shear;
  out.mu = law.shearLaw == ShearLaw::Viscous ? kNoLimit : shear.mu;
  if (out.mu == 0.0) return out;  // without friction there is nothing to remember either
  out.hasHistory = law.shearLaw == ShearLaw::StaticFriction || law.shearLaw == ShearLaw::Coulomb;
  setTangentialDamping(law, out.hasHistory ? shear.dashpot : shear.viscosity, speed, out);
  if (!out.hasHistory) return out;
  out.isCoulomb = law.shearLaw == ShearLaw::Coulomb;
  if (shear.stiffness > 0.0 || law.normalLaw == NormalLaw::LinearSpring) {
    out.tangential = "linear_history";
    out.kt = shear.stiffness > 0.0 ? shear.stiffness : shear.stiffnessRatio * law.normal.kr;
  } else {
    // Pressed deeper a contact keeps its tangential force, and gives it up in proportion as it is let go: of
    // LAMMPS's four forms of Mindlin's spring this one does the same.
    out.tangential = "mindlin_rescale/force";
    out.kt = 1.5 * shear.stiffnessRatio * out.k;
  }
  return out;
}

std::string LammpsContact::text() const {
  std::ostringstream line;
  line.precision(17);
  line << normal << ' ' << k << ' ' << eta << " damping " << damping << " tangential " << tangential << ' ';
  if (hasHistory) line << kt << ' ';
  line << x << ' ' << mu;
  if (limitDamping) line << " limit_damping";
  return line.str();
}

bool LammpsContact::isHertzHistory() const {
  const bool isMindlin = tangential == "mindlin_rescale/force" || mu == 0.0;
  return normal == "hertz" && (damping == "viscoelastic" || eta == 0.0) && isMindlin && x == 0.0;
}

std::string LammpsContact::hertzHistoryText() const {
  std::ostringstream line;
  line.precision(17);
  line << k << ' ' << kt << ' ' << eta << " 0 " << mu << " 0";
  if (limitDamping) line << " limit_damping";
  return line.str();
}

double difference(const LammpsContact& a, const LammpsContact& b) {
  if (a.normal != b.normal || a.damping != b.damping || a.tangential != b.tangential ||
      a.limitDamping != b.limitDamping) {
    return std::numeric_limits<double>::infinity();
  }
  const auto relative = [](double p, double q) {
    return p == q ? 0.0 : std::abs(p - q) / std::max(std::abs(p), std::abs(q));
  };
  return std::max({relative(a.k, b.k), relative(a.eta, b.eta), relative(a.kt, b.kt), relative(a.x, b.x),
                   relative(a.mu, b.mu)});
}

}  // namespace granular::detail

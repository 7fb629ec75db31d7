// SPDX-License-Identifier: MIT
// Our pair laws in the words of LAMMPS's `pair_style granular` (its manual, checked against the program of 29
// Sep 2021). Its constants are scaled otherwise than ours, so that for many laws one set of them serves every
// size of particle:
//
//   hertz k, eta       F = k sqrt(R_eff) xi^(3/2) + g xi'        k = kr / sqrt(R_eff)
//   hooke k, eta       F = k xi + g xi'                          k = kr
//   damping velocity   g = eta                                   eta = kd                      alpha = 0
//   damping tsuji      g = a(eta) sqrt(m_eff k_n)                a = kd / sqrt(m_eff kr)       alpha = 1/4
//   damping viscoelastic   g = eta sqrt(R_eff xi) m_eff          eta = kd / (m_eff sqrt(R_eff))   alpha = 1/2
//   tangential linear_nohistory x, mu     kt of eqs. 16, 18 = x g, with the present g
//   tangential linear_history kt, x, mu   kt of eqs. 17, 19, with a dashpot x g beside it
//   tangential mindlin_rescale/force kt, x, mu   the same with kt sqrt(R_eff xi)
//
// A viscosity of eq. 18 that does not follow g is matched at one overlap (kReferenceDepth).
#pragma once

#include <string>

#include "granular/contact/pair_law.h"

namespace granular::detail {

/// Where what cannot follow the overlap is matched: in deepest overlaps of an elastic impact at the pair's
/// restitutionSpeed (as pair_law.cpp has it for the default viscosity).
inline constexpr double kReferenceDepth = 0.5;

/// One line of coefficients, as pair_coeff and fix wall/gran take them.
struct LammpsContact {
  std::string normal = "hooke";
  double k = 0.0, eta = 0.0;
  std::string damping = "velocity";
  std::string tangential = "linear_nohistory";
  double kt = 0.0;  ///< of the tangential models with history
  double x = 0.0, mu = 0.0;
  bool limitDamping = true;
  bool hasHistory = false;
  bool viscosityIsMatched = false;  ///< at the reference overlap only
  bool isCoulomb = false;           ///< eq. 17, written as eq. 19

  /// "hertz 1e6 0.5 damping tsuji tangential linear_nohistory 1 0.5 limit_damping", 17 digits.
  std::string text() const;
  /// Kn Kt gamma_n gamma_t mu 0 limit_damping, of gran/hertz/history. Only where isHertzHistory().
  std::string hertzHistoryText() const;
  bool isHertzHistory() const;
};

/// speed: the pair's restitutionSpeed, m/s. Not for laws by area, which LAMMPS does not have.
LammpsContact lammpsContact(const PairLaw& law, const EffectiveContact& contact, double speed);

/// Largest relative difference of two pairs' coefficients; infinity where the models differ.
double difference(const LammpsContact& a, const LammpsContact& b);

}  // namespace granular::detail

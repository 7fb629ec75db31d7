// SPDX-License-Identifier: MIT
// Which damping gives the restitution a user asks for. One impact of the law  x'' + D x^alpha x' + x^beta = 0
// in units of its own length and time, with the force clamped at no attraction (dry grains), is integrated;
// e(D) is then inverted. Asking by the paper's unclamped formulas would miss by up to a third (shared by
// every law of eqs. 6-12).
#pragma once

namespace granular {

/// Restitution of a head-on impact at dimensionless damping D >= 0, in (0, 1]. With attraction the contact
/// ends where the overlap does, not where the force does.
double restitutionOfDamping(double alpha, double beta, double D, bool attraction = false);

/// The D that gives restitution e in [0.01, 1].
double dampingForRestitution(double alpha, double beta, double e, bool attraction = false);

}  // namespace granular

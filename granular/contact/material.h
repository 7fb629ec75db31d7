// SPDX-License-Identifier: MIT
// What a user says about materials, and about what happens when two of them touch.
// From these the contact laws' constants are worked out once per kind of pair (pair_law.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace granular {

/// Names a material of one GranularSystem.
struct MaterialId {
  std::int32_t index = -1;
  friend bool operator==(MaterialId, MaterialId) = default;
};

struct MaterialDef {
  std::string name = "stone";
  double density = 2500.0;     ///< kg/m^3, > 0; a grain's mass is density times the volume of its particles
  double youngsModulus = 1e7;  ///< E, Pa, > 0. The paper's value for most scenes; 7 % overlap at 1 m/s
  double poissonRatio = 0.3;   ///< nu, in (-1, 0.5]
  double restitution = 0.5;    ///< e_n against its own kind, in (0, 1]
  double friction = 0.5;       ///< mu against its own kind, >= 0
};

/// The pair rule: what holds where materials A and B touch. What is not given follows from the two materials:
/// restitution and friction are the geometric means (a material against itself keeps its own value),
/// stiffness comes from both elasticities (Bell 2005, eqs. 13-15).
struct MaterialPairDef {
  std::optional<double> restitution =
      std::nullopt;               ///< e_n obtained in a head-on impact at restitutionSpeed, in (0, 1]
  double restitutionSpeed = 1.0;  ///< m/s, > 0
  std::optional<double> friction = std::nullopt;  ///< mu, >= 0
  std::optional<double> shearViscosity =
      std::nullopt;  ///< kt of eq. 18, N s/m, >= 0; default (2/7) pi m_eff / t_c, see pair_law.h
};

}  // namespace granular

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
  double restitution = 0.5;    ///< e_n against its own kind, in [0.01, 1]
  double friction = 0.5;       ///< mu against its own kind, >= 0
};

/// Normal laws, fn = kr xi^beta + kd xi^alpha xi' (Bell 2005, eqs. 6-7). A file each in contact/.
enum class NormalLaw : std::uint8_t {
  HertzViscoelastic,     ///< alpha 1/2, beta 3/2: e falls with speed as in experiments; the default (eq. 12)
  HertzTsuji,            ///< alpha 1/4, beta 3/2: the same e at every speed (eq. 12)
  HertzConstantDamping,  ///< alpha 0, beta 3/2: more elastic with speed, unphysical (eq. 12)
  LinearSpring,          ///< alpha 0, beta 1: the same e and contact time at every speed (eqs. 8-11)
  /// alpha = beta = 1 and kd = a kr, stiffness shared out by the area each surface particle stands for: e,
  /// stiffness and overlap of a covered body do not depend on how densely it is covered. For contacts of
  /// bodies. Differs from the paper: its covered bodies bounce according to how many particles happen to
  /// touch (sec. 5).
  ElasticFoundation,
};

/// Shear laws (Bell 2005, eqs. 16-19). A file each in contact/.
enum class ShearLaw : std::uint8_t {
  RegularisedCoulomb,  ///< eq. 18: no memory; holds a load only by creeping at load / viscosity. The default
  StaticFriction,      ///< eq. 19: a spring remembers the tangential displacement; holds a load at rest
  Coulomb,  ///< eq. 17: full friction at once when sliding; held by a spring at Vt = 0, where 17 jumps
  Viscous,  ///< eq. 16: not bounded by the normal force
};

/// How two materials push each other apart. What is not given is worked out from the materials.
struct NormalLawDef {
  NormalLaw law = NormalLaw::HertzViscoelastic;
  /// LinearSpring: t_c of eqs. 9-10 for the pair, s, > 0. Default: that of a Hertz impact at
  /// restitutionSpeed.
  std::optional<double> contactTime = std::nullopt;
  /// kr, N/m^beta (ElasticFoundation: N/m^3), > 0, in place of what elasticity gives.
  std::optional<double> stiffness = std::nullopt;
  /// kd, N s/m^(1 + alpha) (ElasticFoundation: a, s/m), >= 0, in place of what the restitution gives.
  std::optional<double> damping = std::nullopt;
  /// Let the damper pull while the particles separate, as eqs. 6-7 read literally. Dry grains do not.
  bool attraction = false;
};

/// How two materials resist sliding. What is not given is worked out from the materials.
struct ShearLawDef {
  ShearLaw law = ShearLaw::RegularisedCoulomb;
  /// kt of eqs. 16 and 18, N s/m, >= 0. Default (2/7) pi m_eff / t_c at restitutionSpeed: asks for no shorter
  /// sub-steps than the normal law does.
  std::optional<double> viscosity = std::nullopt;
  /// kt of eqs. 17 and 19, N/m, > 0. Default: after Mindlin, (1 - nu)/(1 - nu/2) of the normal tangent
  /// stiffness at every overlap (2 (1 - nu)/(2 - nu) for two of one material).
  std::optional<double> stiffness = std::nullopt;
  /// Dashpot beside the spring of eqs. 17 and 19, as a fraction of critical damping, in [0, 1]. Default: none
  /// in 19, as in the paper; 0.5 in 17.
  std::optional<double> dampingRatio = std::nullopt;
};

/// The pair rule: what holds where materials A and B touch. Restitution and friction that are not given are
/// the geometric means (a material against itself keeps its own value); stiffness comes from both
/// elasticities (Bell 2005, eqs. 13-15).
struct MaterialPairDef {
  std::optional<double> restitution =
      std::nullopt;               ///< e_n of a head-on impact at restitutionSpeed, in [0.01, 1]
  double restitutionSpeed = 1.0;  ///< m/s, > 0
  std::optional<double> friction = std::nullopt;                    ///< mu, >= 0
  NormalLawDef normal = {};                                         ///< where a grain takes part
  NormalLawDef bodyNormal = {.law = NormalLaw::ElasticFoundation};  ///< between bodies
  ShearLawDef shear = {};
};

}  // namespace granular

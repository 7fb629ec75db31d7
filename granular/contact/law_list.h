// SPDX-License-Identifier: MIT
// The laws there are, in the order of the enums in material.h. A new law is a file like its neighbours, a
// name in the enum and a name here; README.md walks through it.
#pragma once

#include "granular/contact/coulomb.h"
#include "granular/contact/elastic_foundation.h"
#include "granular/contact/hertz_constant_damping.h"
#include "granular/contact/hertz_tsuji.h"
#include "granular/contact/hertz_viscoelastic.h"
#include "granular/contact/linear_spring.h"
#include "granular/contact/regularised_coulomb.h"
#include "granular/contact/static_friction.h"
#include "granular/contact/viscous_shear.h"

namespace granular {

template <class... Laws>
struct LawList {
  static constexpr int kCount = sizeof...(Laws);
};

using NormalLaws =
    LawList<HertzViscoelastic, HertzTsuji, HertzConstantDamping, LinearSpring, ElasticFoundation>;
using ShearLaws = LawList<RegularisedCoulomb, StaticFriction, Coulomb, ViscousShear>;

static_assert(static_cast<int>(NormalLaw::ElasticFoundation) == NormalLaws::kCount - 1);
static_assert(static_cast<int>(ShearLaw::Viscous) == ShearLaws::kCount - 1);

namespace detail {

template <class Function, class Law, class... Rest>
decltype(auto) withLaw(int index, Function&& function) {
  if constexpr (sizeof...(Rest) == 0) {
    return function(Law{});
  } else {
    return index == 0 ? function(Law{})
                      : withLaw<Function, Rest...>(index - 1, std::forward<Function>(function));
  }
}
template <class Function, class... Laws>
decltype(auto) withLawOf(LawList<Laws...>, int index, Function&& function) {
  return withLaw<Function, Laws...>(index, std::forward<Function>(function));
}

}  // namespace detail

/// function(Law{}) for the law that the enum names. Once per pair or per run of contacts, never per contact.
template <class Function>
decltype(auto) withNormalLaw(NormalLaw law, Function&& function) {
  return detail::withLawOf(NormalLaws{}, static_cast<int>(law), std::forward<Function>(function));
}
template <class Function>
decltype(auto) withShearLaw(ShearLaw law, Function&& function) {
  return detail::withLawOf(ShearLaws{}, static_cast<int>(law), std::forward<Function>(function));
}

}  // namespace granular

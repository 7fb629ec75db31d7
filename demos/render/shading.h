// SPDX-License-Identifier: MIT
// Reflection laws: GGX microfacets (Walter et al. 2007), Fresnel (Schlick 1994), glass of index 1.5.
// Directions are unit vectors that point away from the surface.
#pragma once

#include "demos/render/color.h"
#include "demos/render/sampling.h"

namespace granular_demo {

using Vector3f = Eigen::Vector3f;

inline constexpr float kGlassIndex = 1.5f;
inline constexpr float kDielectricReflectance = 0.04f;  ///< at normal incidence, index 1.5

Color fresnel(const Color& atNormalIncidence, float cosine);

/// Glass surface between air and glass. `eta` = index on this side / index beyond; 1 when totally reflected.
float glassReflectance(float cosine, float eta);

/// GGX distribution times Smith's height-correlated visibility: specular BRDF without its Fresnel factor.
float ggxSpecular(const Vector3f& normal, const Vector3f& toViewer, const Vector3f& toLight, float alpha);

/// Share of an even sky that the microfacets reflect (Karis 2014, fit for mobile devices).
Color ambientSpecular(const Color& atNormalIncidence, float roughness, float cosine);

/// A microfacet normal around `normal`, distributed as GGX.
Vector3f sampleGgxNormal(const Vector3f& normal, float alpha, Sample2 sample);

/// Direction around `normal` with density cosine / pi.
Vector3f sampleCosine(const Vector3f& normal, Sample2 sample);

/// Direction within a cone of half angle atan(tangent) around `axis`, even over its disc.
Vector3f sampleCone(const Vector3f& axis, float tangent, Sample2 sample);

/// Mirror image of an incoming direction (that points at the surface).
Vector3f reflect(const Vector3f& incoming, const Vector3f& normal);

}  // namespace granular_demo

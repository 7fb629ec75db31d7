// SPDX-License-Identifier: MIT
#include "demos/render/shading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granular_demo {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

struct Basis {
  Vector3f tangent, bitangent;
};

/// Two directions across a unit normal, without a branch that could leave a seam (Duff et al. 2017).
Basis basisAround(const Vector3f& n) {
  const float sign = std::copysign(1.0f, n.z());
  const float a = -1.0f / (sign + n.z());
  const float b = n.x() * n.y() * a;
  return {{1.0f + sign * n.x() * n.x() * a, sign * b, -sign * n.x()}, {b, sign + n.y() * n.y() * a, -n.y()}};
}

float schlickWeight(float cosine) {
  const float m = std::clamp(1.0f - cosine, 0.0f, 1.0f);
  return m * m * m * m * m;
}

}  // namespace

Color fresnel(const Color& atNormalIncidence, float cosine) {
  return atNormalIncidence + (1.0f - atNormalIncidence) * schlickWeight(cosine);
}

float glassReflectance(float cosine, float eta) {
  const float sineBeyondSquared = eta * eta * (1.0f - cosine * cosine);
  if (sineBeyondSquared >= 1.0f) return 1.0f;
  // Schlick's fit holds on the side of air.
  const float airCosine = eta > 1.0f ? std::sqrt(1.0f - sineBeyondSquared) : cosine;
  return kDielectricReflectance + (1.0f - kDielectricReflectance) * schlickWeight(airCosine);
}

float ggxSpecular(const Vector3f& normal, const Vector3f& toViewer, const Vector3f& toLight, float alpha) {
  const float nl = normal.dot(toLight);
  const float nv = std::max(normal.dot(toViewer), 1e-3f);
  if (nl <= 0.0f) return 0.0f;
  const Vector3f half = (toViewer + toLight).normalized();
  const float nh = normal.dot(half);
  const float a2 = alpha * alpha;
  const float d = nh * nh * (a2 - 1.0f) + 1.0f;
  const float distribution = a2 / (kPi * d * d);
  const float visibility =
      0.5f / (nl * std::sqrt(nv * nv * (1.0f - a2) + a2) + nv * std::sqrt(nl * nl * (1.0f - a2) + a2));
  return distribution * visibility;
}

Color ambientSpecular(const Color& atNormalIncidence, float roughness, float cosine) {
  const float x = 1.0f - roughness;
  const float y = 0.0425f - 0.0275f * roughness;
  const float z = 1.04f - 0.572f * roughness;
  const float w = 0.022f * roughness - 0.04f;
  const float a = std::min(x * x, std::exp2(-9.28f * cosine)) * x + y;
  return (atNormalIncidence * (z - 1.04f * a) + (w + 1.04f * a)).max(0.0f);
}

Vector3f sampleGgxNormal(const Vector3f& normal, float alpha, Sample2 sample) {
  const float cosine = std::sqrt((1.0f - sample.x) / (1.0f + (alpha * alpha - 1.0f) * sample.x));
  const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
  const float phi = 2.0f * kPi * sample.y;
  const Basis basis = basisAround(normal);
  return sine * std::cos(phi) * basis.tangent + sine * std::sin(phi) * basis.bitangent + cosine * normal;
}

Vector3f sampleCosine(const Vector3f& normal, Sample2 sample) {
  const float radius = std::sqrt(sample.x);
  const float phi = 2.0f * kPi * sample.y;
  const Basis basis = basisAround(normal);
  return radius * std::cos(phi) * basis.tangent + radius * std::sin(phi) * basis.bitangent +
         std::sqrt(1.0f - sample.x) * normal;
}

Vector3f sampleCone(const Vector3f& axis, float tangent, Sample2 sample) {
  const float radius = tangent * std::sqrt(sample.x);
  const float phi = 2.0f * kPi * sample.y;
  const Basis basis = basisAround(axis);
  return (axis + radius * std::cos(phi) * basis.tangent + radius * std::sin(phi) * basis.bitangent)
      .normalized();
}

Vector3f reflect(const Vector3f& incoming, const Vector3f& normal) {
  return incoming - 2.0f * incoming.dot(normal) * normal;
}

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
#include "demos/render/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace granular_demo {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kInversePi = std::numbers::inv_pi_v<float>;

// Light in the depth of a heap after the one bounce that is traced, as a share of the open sky.
constexpr float kDeepLight = 0.38f;

// Below this roughness a reflection is traced, above it the reflected sky is taken as the mean one.
constexpr float kMirrorRoughness = 0.4f;

// Way behind a scattered ray: its pixel is so wide that it sees no detail of the ground.
constexpr float kBlurred = kInfinity;

// Reflections seen straight from the camera are not smoothed afterwards, so they get more rays.
constexpr std::uint32_t kMirrorRays = 3;

// Dimensions of the sample sequence; each mirror image takes the next block.
enum Dimension : std::uint32_t {
  kSun = kPixelDimension + 1,
  kAmbient,
  kBounceSun,
  kMirror,
  kDimensionsPerDepth
};

std::uint32_t dimension(Dimension which, int depth) {
  return static_cast<std::uint32_t>(depth) * kDimensionsPerDepth + which;
}

Ray leave(const Hit& hit, const Vector3f& direction) {
  const float side = direction.dot(hit.normal) < 0.0f ? -1.0f : 1.0f;
  return {hit.position + side * hit.offset * hit.normal, direction};
}

}  // namespace

/// A line of sight on its way.
struct PathTracer::Path {
  Ray ray;
  int depth;            // mirror images so far
  std::uint32_t index;  // sample
  Color throughput = Color::Ones();
  float way = 0.0f;  // m behind us
  bool insideGlass = false;
};

bool PathTracer::closestOpaque(const Ray& ray, float farthest, float wayBefore, Hit& hit) const {
  const float ground = environment_.groundDistance(ray.origin, ray.direction);
  if (scene_.closestOpaque(ray, std::min(ground, farthest), hit)) return true;
  if (!(ground < farthest)) return false;
  hit.distance = ground;
  hit.position = ray.origin + ground * ray.direction;
  hit.normal = environment_.up();
  hit.isGround = true;
  const float slant = std::max(-ray.direction.dot(hit.normal), 0.02f);
  hit.material = Material{};
  hit.material.roughness = environment_.groundRoughness();
  hit.material.alpha = hit.material.roughness * hit.material.roughness;
  hit.color = environment_.groundColor(hit.position, settings_.pixelAngle * (wayBefore + ground) / slant);
  hit.offset = 1e-5f * ground;
  return true;
}

LightSample PathTracer::follow(Ray ray, int depth, std::uint32_t index) const {
  constexpr int kMostCrossings = 16;
  LightSample light;
  Path path{ray, depth, index};
  for (int crossing = 0; crossing < kMostCrossings; ++crossing) {
    Hit opaque, glass;
    const bool meetsOpaque = closestOpaque(path.ray, kInfinity, path.way, opaque);
    if (!scene_.closestGlass(path.ray, meetsOpaque ? opaque.distance : kInfinity, glass)) {
      if (meetsOpaque) {
        shade(opaque, path, light);
      } else {
        light.rest += path.throughput * environment_.sky(path.ray.direction);
      }
      return light;
    }
    crossGlass(glass, path, light);
  }
  light.rest += path.throughput * environment_.openSkyAverage(environment_.up());
  return light;
}

void PathTracer::crossGlass(const Hit& hit, Path& path, LightSample& light) const {
  const Vector3f& in = path.ray.direction;
  const float cosine = -hit.normal.dot(in);
  const bool solid = hit.material.glass == Glass::solid;
  if (solid && !hit.entering) path.throughput *= solidTransmission(hit.material, hit.distance);
  path.way += hit.distance;

  const float eta = solid && !hit.entering ? kGlassIndex : 1.0f / kGlassIndex;
  const float single = glassReflectance(cosine, eta);
  const float reflectance =
      solid ? single : 2.0f * single / (1.0f + single);  // a pane reflects at both its sides
  if (reflectance >= 1.0f) {                             // total reflection
    path.ray = leave(hit, reflect(in, hit.normal));
    return;
  }
  const Color mirrorShare = path.throughput * reflectance;
  if ((hit.entering || !solid) && luminance(mirrorShare) > 0.004f) {
    const Vector3f out = reflect(in, hit.normal);
    light.rest += mirrorShare * mirrored(leave(hit, out), path.depth, path.index);
  }
  path.throughput *= 1.0f - reflectance;
  if (!solid) {
    path.throughput *= thinTransmission(hit.material, cosine);
    path.ray = leave(hit, in);
    return;
  }
  const float beyond = std::sqrt(1.0f - eta * eta * (1.0f - cosine * cosine));  // Snell
  path.ray = leave(hit, (eta * in + (eta * cosine - beyond) * hit.normal).normalized());
}

void PathTracer::shade(const Hit& hit, const Path& arriving, LightSample& light) const {
  Path path = arriving;
  path.way += hit.distance;
  if (hit.isGround) {
    const float haze = environment_.groundHaze(hit.position);
    const Vector3f level = path.ray.direction - path.ray.direction.dot(hit.normal) * hit.normal;
    light.rest += path.throughput * haze * environment_.sky(level);
    path.throughput *= 1.0f - haze;
    if (haze >= 1.0f) return;
  }
  const Material& material = hit.material;
  const Color albedo = hit.color * (1.0f - material.metallic);
  const Color f0 = kDielectricReflectance * (1.0f - material.metallic) + hit.color * material.metallic;
  const float cosine = -hit.normal.dot(path.ray.direction);
  const Color mirrorShare = ambientSpecular(f0, material.roughness, cosine);
  light.normal = hit.normal;
  light.depth = path.way;
  light.ambientReflectance = path.throughput * albedo;
  if (material.roughness < kMirrorRoughness || material.metallic > 0.5f) {
    light.rest += path.throughput * mirrorShare * glossyReflection(hit, path);
  } else {
    light.ambientReflectance += path.throughput * mirrorShare;
  }
  addAmbient(hit, path, light);
  addSun(hit, path, albedo, f0, light);
}

Color PathTracer::glossyReflection(const Hit& hit, const Path& path) const {
  const auto rays = path.depth == 0 ? kMirrorRays : 1u;
  Color sum = Color::Zero();
  for (std::uint32_t k = 0; k < rays; ++k) {
    const std::uint32_t index = path.index * rays + k;
    const Vector3f facet =
        sampleGgxNormal(hit.normal, hit.material.alpha, samplePair(index, dimension(kMirror, path.depth)));
    Vector3f out = reflect(path.ray.direction, facet);
    if (out.dot(hit.normal) <= 0.0f) out = reflect(path.ray.direction, hit.normal);
    sum += mirrored(leave(hit, out), path.depth, index);
  }
  return sum / static_cast<float>(rays);
}

void PathTracer::addAmbient(const Hit& hit, const Path& path, LightSample& light) const {
  if (luminance(light.ambientReflectance) <= 0.0f) return;
  const int rays = path.depth == 0 ? settings_.ambientRays : 1;
  for (int k = 0; k < rays; ++k) {
    const std::uint32_t index = path.index * static_cast<std::uint32_t>(rays) + static_cast<std::uint32_t>(k);
    const Vector3f out = sampleCosine(hit.normal, samplePair(index, dimension(kAmbient, path.depth)));
    light.ambient += bouncedLight(leave(hit, out), dimension(kBounceSun, path.depth), index);
  }
  light.ambient /= static_cast<float>(rays);
}

void PathTracer::addSun(const Hit& hit, const Path& path, const Color& albedo, const Color& f0,
                        LightSample& light) const {
  const Vector3f toSun = environment_.sampleSun(samplePair(path.index, dimension(kSun, path.depth)));
  const float cosine = hit.normal.dot(toSun);
  if (cosine <= 0.0f) return;
  const Vector3f toViewer = -path.ray.direction;
  const Color f = fresnel(f0, toViewer.dot((toViewer + toSun).normalized()));
  const float alpha =
      std::min(1.0f, hit.material.alpha + 0.5f * environment_.sunTangent());  // the sun has a disc
  const Color specular = f * ggxSpecular(hit.normal, toViewer, toSun, alpha);
  light.sunReflectance =
      path.throughput * (albedo * kInversePi + specular) * environment_.sunIrradiance() * cosine;
  light.sunVisibility = scene_.transmittance(leave(hit, toSun), kInfinity);
}

Color PathTracer::bouncedLight(const Ray& ray, std::uint32_t sunDimension, std::uint32_t index) const {
  Hit hit;
  if (!closestOpaque(ray, kInfinity, kBlurred, hit))
    return environment_.sky(ray.direction) * scene_.glassTransmittance(ray, kInfinity);
  Color arriving = kDeepLight * environment_.openSkyAverage(hit.normal);
  const Vector3f toSun = environment_.sampleSun(samplePair(index, sunDimension));
  const float cosine = hit.normal.dot(toSun);
  if (cosine > 0.0f) {
    const Color visibility = scene_.transmittance(leave(hit, toSun), kInfinity);
    arriving += visibility * environment_.sunIrradiance() * (cosine * kInversePi);
  }
  return hit.color * arriving * scene_.glassTransmittance(ray, hit.distance);
}

Color PathTracer::mirrored(const Ray& ray, int depth, std::uint32_t index) const {
  if (depth >= settings_.reflectionDepth) return environment_.openSkyAverage(ray.direction);
  return follow(ray, depth + 1, index).radiance();
}

}  // namespace granular_demo

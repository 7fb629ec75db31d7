// SPDX-License-Identifier: MIT
#include "demos/render/render.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "demos/render/denoise.h"
#include "demos/render/parallel.h"
#include "demos/render/path_tracer.h"
#include "demos/render/tone.h"
#include "granular/base/require.h"

namespace granular_demo {
namespace {

constexpr int kTile = 16;  // pixels; small enough to share out evenly

void requireBetween(int value, int low, int high, const char* field) {
  granular::require(value >= low && value <= high, field, value, "",
                    "in [" + std::to_string(low) + ", " + std::to_string(high) + "]");
}

void checkSettings(const RenderSettings& settings) {
  requireBetween(settings.width, 1, 16384, "RenderSettings.width");
  requireBetween(settings.height, 1, 16384, "RenderSettings.height");
  requireBetween(settings.samplesPerPixel, 1, 4096, "RenderSettings.samplesPerPixel");
  requireBetween(settings.ambientRays, 1, 64, "RenderSettings.ambientRays");
  requireBetween(settings.reflectionDepth, 0, 8, "RenderSettings.reflectionDepth");
  requireBetween(settings.denoisePasses, 0, 5, "RenderSettings.denoisePasses");
  requireBetween(settings.threads, 0, 4096, "RenderSettings.threads");
  granular::requirePositive(settings.exposure, "RenderSettings.exposure", "");
}

/// The camera in single precision, at (0, 0, 0).
struct Lens {
  Lens(const Camera& camera, int w, int h) : width(w), height(h) {
    const CameraFrame frame(camera, w, h);
    right = (frame.right * frame.halfWidth).cast<float>();
    up = (frame.up * frame.halfHeight).cast<float>();
    forward = frame.forward.cast<float>();
    pixelAngle = static_cast<float>(2.0 * frame.halfHeight / h);
  }

  /// Line of sight through a point of the picture, in pixels from the upper left corner.
  Vector3f direction(float x, float y) const {
    const float across = 2.0f * x / static_cast<float>(width) - 1.0f;
    const float upward = 1.0f - 2.0f * y / static_cast<float>(height);
    return (forward + across * right + upward * up).normalized();
  }

  int width, height;
  Vector3f right, up, forward;
  float pixelAngle;
};

/// Offset within about a pixel for a uniform number: density of a tent of half width 0.8, less jagged than a
/// box.
float tent(float u) {
  const float t = 2.0f * u - 1.0f;
  return 0.5f + 0.8f * std::copysign(1.0f - std::sqrt(1.0f - std::abs(t)), t);
}

/// A highlight brighter than this white would leave a jagged edge, since display values end at 1.
float taming(const LightSample& light) {
  constexpr float kBrightest = 4.0f;
  const float peak = light.radiance().maxCoeff();
  return peak > kBrightest ? kBrightest / peak : 1.0f;
}

/// Weighted sum over weight, per channel; 0 where nothing has weight.
Color ratio(const Color& sum, const Color& weight) {
  return (weight > 0.0f).select(sum / weight.max(1e-30f), 0.0f);
}

void tracePixel(const PathTracer& tracer, const Lens& lens, int x, int y, int samples, LightBuffer& buffer) {
  Color rest = Color::Zero(), ambientWeight = Color::Zero(), ambient = Color::Zero();
  Color sunWeight = Color::Zero(), sun = Color::Zero();
  LightSample nearest;
  for (int s = 0; s < samples; ++s) {
    const std::uint32_t index =
        mortonIndex(x, y) * static_cast<std::uint32_t>(samples) + static_cast<std::uint32_t>(s);
    // The same places in every pixel: edges come out as even steps, where places by chance leave them ragged.
    const Sample2 offset = samplePair(static_cast<std::uint32_t>(s), kPixelDimension);
    const Vector3f direction =
        lens.direction(static_cast<float>(x) + tent(offset.x), static_cast<float>(y) + tent(offset.y));
    const LightSample light = tracer.trace({Vector3f::Zero(), direction}, index);
    const float scale = taming(light) / static_cast<float>(samples);
    rest += scale * light.rest;
    ambientWeight += scale * light.ambientReflectance;
    ambient += scale * light.ambientReflectance * light.ambient;
    sunWeight += scale * light.sunReflectance;
    sun += scale * light.sunReflectance * light.sunVisibility;
    if (light.depth > 0.0f && (nearest.depth == 0.0f || light.depth < nearest.depth)) nearest = light;
  }
  const auto pixel = static_cast<std::size_t>(y) * buffer.width + x;
  buffer.rest[pixel] = rest;
  buffer.ambientReflectance[pixel] = ambientWeight;
  buffer.ambient[pixel] = ratio(ambient, ambientWeight);
  buffer.sunReflectance[pixel] = sunWeight;
  buffer.sunVisibility[pixel] = ratio(sun, sunWeight);
  buffer.normal[pixel] = nearest.normal;
  buffer.position[pixel] =
      nearest.depth * lens.direction(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  buffer.footprint[pixel] = nearest.depth * lens.pixelAngle;
}

void traceTiles(const PathTracer& tracer, const Lens& lens, int samples, int threads, LightBuffer& buffer) {
  const int across = (buffer.width + kTile - 1) / kTile;
  const int down = (buffer.height + kTile - 1) / kTile;
  parallelFor(threads, across * down, [&](int tile) {
    const int left = tile % across * kTile, top = tile / across * kTile;
    for (int y = top; y < std::min(top + kTile, buffer.height); ++y)
      for (int x = left; x < std::min(left + kTile, buffer.width); ++x)
        tracePixel(tracer, lens, x, y, samples, buffer);
  });
}

/// Light to display values. A fraction of one step of the 8 bits is added in a fine pattern, or even skies
/// show bands (interleaved gradient noise, Jimenez 2014).
Image develop(const LightBuffer& buffer, float exposure) {
  Image image{buffer.width, buffer.height, {}};
  image.pixels.reserve(3 * buffer.rest.size());
  for (int y = 0; y < buffer.height; ++y) {
    for (int x = 0; x < buffer.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y) * buffer.width + x;
      const Color radiance = buffer.rest[pixel] + buffer.ambientReflectance[pixel] * buffer.ambient[pixel] +
                             buffer.sunReflectance[pixel] * buffer.sunVisibility[pixel];
      const float ramp = 0.06711056f * static_cast<float>(x) + 0.00583715f * static_cast<float>(y);
      const float wave = 52.9829189f * (ramp - std::floor(ramp));
      const Color display = 255.0f * srgbFromLinear(filmic(exposure * radiance)) + (wave - std::floor(wave));
      for (int c = 0; c < 3; ++c)
        image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(display[c], 0.0f, 255.0f)));
    }
  }
  return image;
}

}  // namespace

RenderSettings quickSettings(int width, int height) {
  return {.width = width,
          .height = height,
          .samplesPerPixel = 2,
          .ambientRays = 1,
          .reflectionDepth = 1,
          .denoisePasses = 3};
}

RenderSettings fineSettings(int width, int height) {
  return {.width = width,
          .height = height,
          .samplesPerPixel = 16,
          .ambientRays = 2,
          .reflectionDepth = 4,
          .denoisePasses = 1};
}

Image render(const RenderScene& scene, const Camera& camera, const RenderSettings& settings) {
  checkSettings(settings);
  const int threads = settings.threads > 0
                          ? settings.threads
                          : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const Lens lens(camera, settings.width, settings.height);
  const Environment environment(scene, camera);
  const RayScene rayScene(scene, camera.eye);
  const PathTracer tracer(rayScene, environment,
                          {settings.ambientRays, settings.reflectionDepth, lens.pixelAngle});
  LightBuffer buffer(settings.width, settings.height);
  traceTiles(tracer, lens, settings.samplesPerPixel, threads, buffer);
  denoise(buffer, settings.denoisePasses, threads);
  return develop(buffer, static_cast<float>(settings.exposure));
}

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
// Draws a scene into a picture, in software: sun with soft shadows, sky with ambient occlusion and one
// bounce, stone, metal and glass. The same picture, bit for bit, for any number of threads.
#pragma once

#include "demos/render/camera.h"
#include "demos/render/image.h"
#include "demos/render/render_scene.h"

namespace granular_demo {

struct RenderSettings {
  int width = 960, height = 540;  ///< pixels, each in [1, 16384]
  int samplesPerPixel = 4;        ///< [1, 4096]; powers of two are spread most evenly
  int ambientRays = 2;            ///< rays towards the sky for each sample, [1, 64]
  int reflectionDepth = 2;        ///< mirror images within mirror images, [0, 8]
  int denoisePasses = 2;          ///< each pass doubles the reach of the smoothing; 0: none, [0, 5]
  double exposure = 1.0;          ///< multiplies the light, > 0
  int threads = 0;                ///< 0: as many as the machine has
};

/// For previews: about half the time of the defaults.
RenderSettings quickSettings(int width = 960, int height = 540);

/// For stills to show: four times the samples of the defaults, and in this size four times the pixels.
RenderSettings fineSettings(int width = 1920, int height = 1080);

/// @throws std::invalid_argument for a scene, camera or setting out of range, std::runtime_error if Embree
/// fails
Image render(const RenderScene& scene, const Camera& camera, const RenderSettings& settings = {});

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
// Smooths the light that arrives at surfaces, sky and sun apart, and never across edges: the edge-avoiding
// a-trous filter (Dammertz et al. 2010), guided by the plane and the normal each pixel shows.
#pragma once

#include <vector>

#include "demos/render/shading.h"

namespace granular_demo {

/// Means over the samples of each pixel; all vectors [height * width], rows from the top.
struct LightBuffer {
  LightBuffer(int width, int height);

  int width, height;
  std::vector<Color> rest;                ///< light that is left as it is
  std::vector<Color> ambientReflectance;  ///< what the surfaces do with `ambient`
  std::vector<Color> ambient;             ///< noisy
  std::vector<Color> sunReflectance;
  std::vector<Color> sunVisibility;  ///< noisy in half shadows
  std::vector<Vector3f> normal;
  std::vector<Vector3f>
      position;  ///< of the surface, m, camera at (0, 0, 0); straight on when seen through glass
  std::vector<float> footprint;  ///< width of a pixel there, m; 0: no surface
};

/// Smooths `ambient` and `sunVisibility`.
void denoise(LightBuffer& buffer, int passes, int threads);

}  // namespace granular_demo

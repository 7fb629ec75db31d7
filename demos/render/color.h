// SPDX-License-Identifier: MIT
// Colours. The API takes them as a colour picker shows them (sRGB, 0 to 1); inside, light is linear.
#pragma once

#include <Eigen/Core>

namespace granular_demo {

/// Red, green, blue. At the API: sRGB display values in [0, 1]. In the renderer: linear radiance or
/// reflectance.
using Color = Eigen::Array3f;

/// Rec. 709 luminance of a linear colour.
inline float luminance(const Color& linear) {
  return 0.2126f * linear.x() + 0.7152f * linear.y() + 0.0722f * linear.z();
}

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
// From light to display values: sRGB curve (IEC 61966-2-1) and a gentle filmic curve.
#pragma once

#include "demos/render/color.h"

namespace granular_demo {

Color linearFromSrgb(const Color& srgb);
Color srgbFromLinear(const Color& linear);

/// Linear radiance to linear display value in [0, 1], per channel: a soft toe, a straight middle, a shoulder
/// that reaches white slowly (Uchimura 2017, "HDR theory and practice").
Color filmic(const Color& radiance);

}  // namespace granular_demo

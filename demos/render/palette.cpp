// SPDX-License-Identifier: MIT
#include "demos/render/palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "granular/base/random.h"

namespace granular_demo {

Color viridis(double t) {
  // Polynomial of degree 6 fitted to the published table, per channel, error about 0.01 (Zucker 2018).
  static const std::array<Color, 7> coefficients = {
      Color(0.277727f, 0.005407f, 0.334100f),   Color(0.105093f, 1.404614f, 1.384590f),
      Color(-0.330862f, 0.214848f, 0.095095f),  Color(-4.634230f, -5.799101f, -19.332441f),
      Color(6.228270f, 14.179933f, 56.690553f), Color(4.776385f, -13.745145f, -65.353033f),
      Color(-5.435456f, 4.645853f, 26.312435f)};
  const float x = static_cast<float>(std::clamp(t, 0.0, 1.0));
  Color sum = coefficients[6];
  for (int i = 5; i >= 0; --i) sum = sum * x + coefficients[static_cast<std::size_t>(i)];
  return sum.max(0.0f).min(1.0f);
}

Color colorByScalar(double value, double low, double high) {
  return viridis(high > low ? (value - low) / (high - low) : 0.5);
}

Color sandColor(std::uint64_t grain) {
  struct Mineral {
    Color color;
    double share;  // of all grains; the shares add up to 1
  };
  static const std::array<Mineral, 5> minerals = {
      {{Color(0.83f, 0.71f, 0.53f), 0.50},    // stained quartz
       {Color(0.88f, 0.80f, 0.66f), 0.22},    // clear quartz
       {Color(0.76f, 0.61f, 0.44f), 0.18},    // iron-stained feldspar
       {Color(0.63f, 0.50f, 0.38f), 0.08},    // rock fragments
       {Color(0.44f, 0.39f, 0.35f), 0.02}}};  // dark minerals
  granular::Random random = granular::Random(0x5a4d).forItem(grain);
  double pick = random.uniform();
  std::size_t kind = 0;
  while (kind + 1 < minerals.size() && pick >= minerals[kind].share) pick -= minerals[kind++].share;
  const float lightness = static_cast<float>(random.uniform(0.92, 1.06));
  const float warmth = static_cast<float>(random.uniform(-0.02, 0.02));
  return (minerals[kind].color * lightness + Color(warmth, 0.0f, -warmth)).max(0.0f).min(1.0f);
}

Color ownerColor(std::uint64_t owner) {
  // Oklab (Ottosson 2020) at fixed lightness and chroma, so that no tint shouts.
  constexpr double kLightness = 0.74, kChroma = 0.105;
  const double hue =
      std::fmod(0.6 + static_cast<double>(owner % 100000) * 2.399963229728653, 2.0 * std::numbers::pi);
  const double a = kChroma * std::cos(hue), b = kChroma * std::sin(hue);
  const double l = std::pow(kLightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(kLightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(kLightness - 0.0894841775 * a - 1.2914855480 * b, 3);
  const Eigen::Array3d linear(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                              -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                              -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s);
  return linear.max(0.0).min(1.0).pow(1.0 / 2.2).cast<float>();
}

}  // namespace granular_demo

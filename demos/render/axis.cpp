// SPDX-License-Identifier: MIT
#include "demos/render/axis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "granular/base/require.h"

namespace granular_demo {
namespace {

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  std::string result = text;
  if (!result.empty() && result[0] == '-') result.replace(0, 1, "\u2212");  // a minus as wide as a plus
  return result;
}

std::string powerOfTen(int exponent) {
  return "10^{" + formatted("%.0f", exponent) + "}";
}

/// A number as people write it: plain where it is short, else with a power of ten.
std::string numberLabel(double value, double step) {
  if (std::abs(value) < 1e-9 * step) return "0";
  const int size = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
  if (size >= 5 || size <= -4) {
    const double mantissa = value / std::pow(10.0, size);
    if (std::abs(mantissa - 1.0) < 1e-6) return powerOfTen(size);
    const int decimals = std::max(0, size - static_cast<int>(std::floor(std::log10(step) + 1e-9)));
    return formatted(decimals == 0   ? "%.0f"
                     : decimals == 1 ? "%.1f"
                                     : "%.2f",
                     mantissa) +
           "\u00b7" + powerOfTen(size);
  }
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  char format[8];
  std::snprintf(format, sizeof format, "%%.%df", std::min(decimals, 9));
  return formatted(format, value);
}

double niceStep(double rough) {
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double lead = rough / power;
  return power * (lead <= 1.0 ? 1.0 : lead <= 2.0 ? 2.0 : lead <= 5.0 ? 5.0 : 10.0);
}

std::vector<Tick> linearTicks(const AxisRange& range, int mostLabels) {
  const double step = niceStep((range.high - range.low) / mostLabels);
  const double slack = 1e-9 * step;
  std::vector<Tick> ticks;
  for (double k = std::ceil((range.low - slack) / step); k * step <= range.high + slack; ++k)
    ticks.push_back({k * step, numberLabel(k * step, step)});
  return ticks;
}

std::vector<Tick> logarithmicTicks(const AxisRange& range, int mostLabels) {
  const double lowest = std::log10(range.low), highest = std::log10(range.high);
  const int every = std::max(1, static_cast<int>(std::ceil((highest - lowest) / mostLabels)));
  const bool fewDecades = highest - lowest < 1.7;
  const bool manyDecades = highest - lowest > 14.0;
  std::vector<Tick> ticks;
  for (int decade = static_cast<int>(std::floor(lowest)); decade <= static_cast<int>(std::floor(highest));
       ++decade) {
    for (int lead = 1; lead <= (manyDecades ? 1 : 9); ++lead) {
      const double value = lead * std::pow(10.0, decade);
      if (value < range.low * (1.0 - 1e-9) || value > range.high * (1.0 + 1e-9)) continue;
      std::string label;
      if (fewDecades && (lead == 1 || lead == 2 || lead == 5)) {
        label = numberLabel(value, std::pow(10.0, decade));
      } else if (!fewDecades && lead == 1 && decade % every == 0) {
        label = powerOfTen(decade);
      }
      ticks.push_back({value, label});
    }
  }
  return ticks;
}

}  // namespace

bool AxisRange::canShow(double value) const {
  return std::isfinite(value) && (scale == Scale::linear || value > 0.0);
}

double AxisRange::fraction(double value) const {
  if (scale == Scale::linear) return (value - low) / (high - low);
  return std::log(value / low) / std::log(high / low);
}

AxisRange rangeAround(Scale scale, const std::vector<double>& values, const std::string& field) {
  AxisRange range{scale, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double value : values) {
    if (!range.canShow(value)) continue;
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  }
  granular::require(range.low <= range.high, field, "without a value to show", "",
                    scale == Scale::linear ? "at least one finite number" : "at least one finite number > 0");
  if (scale == Scale::logarithmic) {
    const double room = std::max(std::pow(range.high / range.low, 0.06), 1.15);
    return {scale, range.low / room, range.high * room};
  }
  const double size = range.high - range.low;
  const double room = size > 0.0 ? 0.05 * size : std::max(0.5 * std::abs(range.high), 1e-12);
  // An axis of counts or lengths starts at its zero, not just below it.
  const double low = range.low >= 0.0 && range.low < 0.25 * range.high ? 0.0 : range.low - room;
  return {scale, low, range.high + room};
}

std::vector<Tick> ticksOf(const AxisRange& range, int mostLabels) {
  return range.scale == Scale::linear ? linearTicks(range, mostLabels) : logarithmicTicks(range, mostLabels);
}

}  // namespace granular_demo

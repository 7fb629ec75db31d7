// SPDX-License-Identifier: MIT
// Checks of what a user gave: one line naming field, value, allowed range and unit. All build types.
#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "granular/base/pose.h"

namespace granular {

/// Throws std::invalid_argument "<field> is <value> <unit>; it must be <allowed>" unless `ok`.
template <class Value>
void require(bool ok, std::string_view field, const Value& value, std::string_view unit,
             std::string_view allowed) {
  if (ok) return;
  std::ostringstream text;
  text << field << " is " << value;
  if (!unit.empty()) text << ' ' << unit;
  text << "; it must be " << allowed;
  throw std::invalid_argument(text.str());
}

inline void requirePositive(double value, std::string_view field, std::string_view unit) {
  require(std::isfinite(value) && value > 0.0, field, value, unit, "finite and > 0");
}

inline void requireNotNegative(double value, std::string_view field, std::string_view unit) {
  require(std::isfinite(value) && value >= 0.0, field, value, unit, "finite and >= 0");
}

inline void requireFinite(const Vector3& value, std::string_view field, std::string_view unit) {
  require(value.allFinite(), field, value.transpose(), unit, "finite in all components");
}

/// A unit quaternion within 1e-6; the caller normalises the rest away.
inline void requireRotation(const Quaternion& value, std::string_view field) {
  require(std::abs(value.norm() - 1.0) < 1e-6, field, value.coeffs().transpose(), "(x y z w)",
          "a unit quaternion");
}

}  // namespace granular

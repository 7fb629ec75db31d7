// SPDX-License-Identifier: MIT
#include "tests/verification/verification_case.h"

#include <cmath>
#include <utility>

namespace granular::verification {

double Check::error() const {
  const double difference = std::abs(measured - expected);
  return kind == ErrorKind::Relative ? difference / std::abs(expected) : difference;
}

bool Check::passes() const {
  return error() <= tolerance;
}

Check relative(std::string quantity, double expected, double measured, double tolerance) {
  return {std::move(quantity), expected, measured, tolerance, ErrorKind::Relative};
}

Check absolute(std::string quantity, double expected, double measured, double tolerance) {
  return {std::move(quantity), expected, measured, tolerance, ErrorKind::Absolute};
}

Check truth(std::string quantity, bool expected, bool actual) {
  return absolute(std::move(quantity), expected ? 1.0 : 0.0, actual ? 1.0 : 0.0, 0.0);
}

std::span<const VerificationCase> verificationCases() {
  static const CaseList cases = [] {
    CaseList list;
    addNormalCases(list);
    addChungOoiCases(list);
    addFrictionCases(list);
    addMotionCases(list);
    addCoveringCases(list);
    return list;
  }();
  return cases;
}

}  // namespace granular::verification

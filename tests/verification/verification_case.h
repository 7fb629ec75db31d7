// SPDX-License-Identifier: MIT
// Cases whose answers are known, for GranularSystem as its users see it. Each case is a sentence of the
// physics with numbers: what is expected comes from a closed form, or from an independent integration inside
// the case, never from a run of the system under test. One list serves the tests (label `law`) and
// `granular_bench verify`.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace granular::verification {

enum class ErrorKind { Relative, Absolute };

/// One quantity of a case.
struct Check {
  std::string quantity = {};  ///< with its unit
  double expected = 0.0;
  double measured = 0.0;
  double tolerance = 0.0;  ///< allowed error(): relative to `expected`, or absolute
  ErrorKind kind = ErrorKind::Relative;

  double error() const;
  bool passes() const;  ///< false for what is not a number
};

Check relative(std::string quantity, double expected, double measured, double tolerance);
Check absolute(std::string quantity, double expected, double measured, double tolerance);
/// A yes or no: passes if `actual` is `expected`.
Check truth(std::string quantity, bool expected, bool actual);

struct VerificationCase {
  std::string name = {};     ///< section, subject, numbers, e.g. "1.elastic-hertz.glass"
  std::string section = {};  ///< what it is about, in words
  std::function<std::vector<Check>()> run = {};
  bool isLong =
      false;  ///< more than some seconds: left out of the tests, run by `granular_bench verify --long`
};

/// Every case, in the order of the sections.
std::span<const VerificationCase> verificationCases();

using CaseList = std::vector<VerificationCase>;

// One file each.
void addNormalCases(CaseList& cases);
void addChungOoiCases(CaseList& cases);
void addFrictionCases(CaseList& cases);
void addMotionCases(CaseList& cases);
void addCoveringCases(CaseList& cases);

}  // namespace granular::verification

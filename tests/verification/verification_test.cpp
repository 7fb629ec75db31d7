// SPDX-License-Identifier: MIT
// Every case of verification_case.h as a test of its own: Verification/Law.Holds/<name>.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <iterator>

#include "tests/verification/verification_case.h"

namespace granular::verification {
namespace {

class Law : public testing::TestWithParam<const VerificationCase*> {};

TEST_P(Law, Holds) {
  for (const Check& check : GetParam()->run()) {
    EXPECT_TRUE(check.passes()) << check.quantity << ": expected " << check.expected << ", measured "
                                << check.measured << ", error " << check.error() << ", tolerance "
                                << check.tolerance;
  }
}

std::vector<const VerificationCase*> shortCases() {
  std::vector<const VerificationCase*> cases;
  for (const VerificationCase& c : verificationCases()) {
    if (!c.isLong) cases.push_back(&c);
  }
  return cases;
}

/// GoogleTest takes letters, digits and underscores.
std::string testName(const testing::TestParamInfo<const VerificationCase*>& info) {
  std::string name = info.param->name;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Verification, Law, testing::ValuesIn(shortCases()), testName);

}  // namespace
}  // namespace granular::verification

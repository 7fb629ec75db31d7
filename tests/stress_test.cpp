// SPDX-License-Identifier: MIT
// The quick scenes of the stress matrix; `granular_bench stress` runs all of them.
#include "tests/stress_cases.h"

#include <gtest/gtest.h>

namespace granular::stress {
namespace {

TEST(Stress, QuickScenesDoWhatIsExpected) {
  int count = 0;
  for (const Case& scene : allCases()) {
    if (!scene.isQuick) continue;
    ++count;
    for (const std::string& complaint : complaints(scene, scene.run())) {
      ADD_FAILURE() << scene.name << ": " << scene.setUp << "; expected: " << scene.expectation << "\n  "
                    << complaint;
    }
  }
  EXPECT_GT(count, 20);
}

TEST(Stress, ComplaintNamesTheSettingToChange) {
  Case scene;
  Outcome outcome;
  outcome.flags = StepFlag::FixedSubStepTooLong;
  const std::vector<std::string> lines = complaints(scene, outcome);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("IntegratorDef.fixedSubStep"), std::string::npos) << lines[0];
}

}  // namespace
}  // namespace granular::stress

// SPDX-License-Identifier: MIT
// Slow, full runs: tests/run --bulk.
#include <gtest/gtest.h>

#include <memory>

#include "demos/runner/run_scene.h"
#include "demos/scene/scene_catalog.h"
#include "demos/scene/scene_file.h"
#include "tests/verification/verification_case.h"

namespace granular_demo {
namespace {

/// Side of the glass towards the heap, m: the wall of scenes/splash.json stands at x = 0.55 and is 0.04
/// thick.
constexpr double kWallFace = 0.53;

class DefaultSplash : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    SceneDef scene = readSceneFile(findScene("splash"), "default");
    scene.outputs.pictures = false;
    run_ = std::make_unique<FinishedRun>(runScene(scene, {.threads = 2}));
  }
  static void TearDownTestSuite() { run_.reset(); }

  static inline std::unique_ptr<FinishedRun> run_;
};

TEST_F(DefaultSplash, LetsNothingThroughSurfaces) {
  EXPECT_EQ(run_->result.worst.insideBodies, 0);
  EXPECT_EQ(run_->result.worst.belowGround, 0);
  EXPECT_EQ(run_->result.worst.notFinite, 0);
}

TEST_F(DefaultSplash, NeverRisesAboveItsEnergy) {
  EXPECT_LE(run_->result.energy.worstFraction(), 1e-3);
}

TEST_F(DefaultSplash, AccountsForItsEnergy) {
  const granular::StepReport &start = run_->result.state.start, &end = run_->result.state.end;
  const double lost = start.energy.total() - end.energy.total();
  EXPECT_NEAR(end.dissipated, lost, 0.01 * start.energy.total());
}

TEST_F(DefaultSplash, HeapsUpAtTheFootOfTheWall) {
  // Within three particle radii of the glass, and higher than one layer of grains lies there.
  const auto motions = run_->scene->grains().grainMotions();
  int atFoot = 0, raised = 0;
  for (const granular::RigidMotion& m : motions) {
    const double gap = kWallFace - m.pose.position.x();
    if (gap < 0.0 || gap > 0.06) continue;
    ++atFoot;
    raised += m.pose.position.y() > 0.04;
  }
  EXPECT_GT(atFoot, 30);
  EXPECT_GT(raised, 10);
}

/// The scenes of the paper at their small scale, from start to outcome. The files say what is expected.
FinishedRun runToTheEnd(const std::string& name, const std::string& scale,
                        const SavedState* state = nullptr) {
  SceneDef scene = readSceneFile(findScene(name), scale, state ? state->document : "");
  scene.outputs.pictures = false;
  return runScene(scene, {.state = state, .threads = 2});
}

void expectOutcome(const FinishedRun& run) {
  const RunResult& r = run.result;
  EXPECT_EQ(r.worst.insideBodies, 0) << r.worst.inside;
  EXPECT_EQ(r.worst.belowGround, 0);
  EXPECT_EQ(r.worst.notFinite, 0);
  EXPECT_LE(r.energy.worstFraction(), 1e-3);
  EXPECT_LE(r.balance.worstFraction(), 0.01) << "at " << r.balance.worstTime() << " s";
  EXPECT_GT(r.expected.size(), 0u);
  for (const ExpectedResult& e : r.expected)
    EXPECT_TRUE(e.holds()) << e.part.meter << "." << e.part.value << " is " << e.measured;
}

double valueOf(const FinishedRun& run, const std::string& name) {
  for (const auto& [key, value] : run.result.meters.at(0).values) {
    if (key == name) return value;
  }
  ADD_FAILURE() << "no value " << name;
  return 0.0;
}

TEST(PaperScales, CanBeBuilt) {
  for (const char* name : {"hourglass", "rings", "splash", "avalanche"}) {
    BuiltScene scene(readSceneFile(findScene(name), "paper"), 2);
    EXPECT_LT(scene.grains().measure().energy.elastic, 1e-30) << name;  // by rounding, where bodies touch
  }
}

TEST(SmallHourglass, RunsAtANearlyConstantRateUntilItIsEmpty) {
  expectOutcome(runToTheEnd("hourglass", "small"));
}

TEST(SmallRings, ScatterWhereSmoothMoreThanWhereRough) {
  const FinishedRun smooth = runToTheEnd("rings", "small"), rough = runToTheEnd("rings", "small+rough");
  expectOutcome(smooth);
  expectOutcome(rough);
  EXPECT_GT(valueOf(smooth, "meanDistanceFromMiddle"), valueOf(rough, "meanDistanceFromMiddle"));
}

TEST(SmallAvalanche, BreaksStructuresThatStoodBefore) {
  const FinishedRun avalanche = runToTheEnd("avalanche", "small");
  expectOutcome(avalanche);
  const SavedState remains = avalanche.scene->savedState();
  expectOutcome(runToTheEnd("bulldozer", "small", &remains));
}

}  // namespace
}  // namespace granular_demo

namespace granular::verification {
namespace {

TEST(LongVerification, Holds) {
  int cases = 0;
  for (const VerificationCase& c : verificationCases()) {
    if (!c.isLong) continue;
    ++cases;
    for (const Check& check : c.run()) {
      EXPECT_TRUE(check.passes()) << c.name << ", " << check.quantity << ": measured " << check.measured;
    }
  }
  EXPECT_GT(cases, 0);
}

}  // namespace
}  // namespace granular::verification

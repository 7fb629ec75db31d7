// SPDX-License-Identifier: MIT
// Runs of scenes: the physics stays sane, threads change nothing, files hold what they promise.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "demos/runner/csv_file.h"
#include "demos/runner/frame_table.h"
#include "demos/runner/progress_line.h"
#include "demos/runner/run_report.h"
#include "demos/runner/run_scene.h"
#include "demos/scene/scene_catalog.h"
#include "demos/scene/scene_file.h"

namespace granular_demo {
namespace {

SceneDef smallSplash() {
  SceneDef scene = readSceneFile(findScene("splash"), "small");
  scene.outputs.pictures = false;
  return scene;
}

std::filesystem::path scratchFolder(const std::string& name) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / ("granular_run_" + name);
  std::filesystem::remove_all(folder);
  return folder;
}

std::vector<std::vector<std::string>> readCsv(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

/// Fourteen frames of the small splash: the ball has hit the heap by then.
const FinishedRun& impact() {
  static const FinishedRun run = runScene(smallSplash(), {.frames = 14, .threads = 2});
  return run;
}

TEST(SmallSplash, LetsNothingThroughSurfaces) {
  EXPECT_EQ(impact().result.worst.insideBodies, 0);
  EXPECT_EQ(impact().result.worst.belowGround, 0);
  EXPECT_EQ(impact().result.worst.notFinite, 0);
}

TEST(SmallSplash, GainsNoEnergy) {
  EXPECT_LE(impact().result.energy.worstFraction(), 1e-3);
}

TEST(SmallSplash, LosesEnergyInTheImpact) {
  EXPECT_GT(impact().result.energy.fallen(), 0.5 * impact().result.energy.first());
}

TEST(SmallSplash, AccountsForTheEnergyItLoses) {
  const RunState& state = impact().result.state;
  // Heat is what is missing. The dissipation is integrated beside the state, so it agrees to the steps'
  // error.
  EXPECT_NEAR(state.end.dissipated, state.start.energy.total() - state.end.energy.total(),
              0.01 * state.end.dissipated);
}

TEST(SmallSplash, IsTheSameForOneThreadAndTwo) {
  EXPECT_EQ(runScene(smallSplash(), {.frames = 14, .threads = 1}).result.stateHash,
            impact().result.stateHash);
}

/// The first frames of the scenes of the paper; tests/run --bulk goes to their outcomes.
class PaperScene : public ::testing::TestWithParam<const char*> {
 protected:
  static FinishedRun start(int threads) {
    SceneDef scene = readSceneFile(findScene(GetParam()), "small");
    scene.outputs.pictures = false;
    return runScene(scene, {.frames = 3, .threads = threads});
  }
};

TEST_P(PaperScene, BeginsWithNothingWhereItMustNotBe) {
  const FinishedRun run = start(2);
  EXPECT_TRUE(run.result.passed(false)) << run.result.worst.inside;
  EXPECT_FALSE(run.result.meters.empty());
  EXPECT_TRUE(run.result.expected.empty());  // bounds are for whole runs
}

TEST_P(PaperScene, IsTheSameForOneThreadAndTwo) {
  EXPECT_EQ(start(1).result.stateHash, start(2).result.stateHash);
}

INSTANTIATE_TEST_SUITE_P(Small, PaperScene, ::testing::Values("hourglass", "rings", "avalanche"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(RunScene, StopsAfterTheTickInWhichItIsAsked) {
  int asked = 0;
  const FinishedRun run = runScene(
      smallSplash(), {.frames = 5, .threads = 1, .onFrame = {}, .shallStop = [&] { return ++asked == 6; }});
  EXPECT_TRUE(run.result.interrupted);
  EXPECT_EQ(run.scene->ticksDone(), 6);
  EXPECT_EQ(run.result.frames, 2);  // four ticks a frame: the second one was begun
}

TEST(RunScene, WritesARowAFrameAndOneForTheStart) {
  const auto folder = scratchFolder("frames");
  runScene(smallSplash(), {.folder = folder, .frames = 3, .threads = 1});
  const auto rows = readCsv(folder / "frames.csv");
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[0], FrameTable::columns({}));
  for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size());
  EXPECT_EQ(rows[1][0], "0");
  EXPECT_EQ(rows[4][0], "3");
  EXPECT_NEAR(std::stod(rows[4][1]), 3.0 / 30.0, 1e-12);
}

TEST(RunScene, WritesTrajectoriesThatFallOnTheParabola) {
  const auto folder = scratchFolder("trajectory");
  const SceneDef scene = smallSplash();
  runScene(scene, {.folder = folder, .frames = 4, .threads = 1});
  const auto rows = readCsv(folder / "trajectory_body_ball.csv");
  EXPECT_EQ(rows.at(0), (std::vector<std::string>{"time", "x", "y", "z", "vx", "vy", "vz", "qw", "qx", "qy",
                                                  "qz", "wx", "wy", "wz"}));
  ASSERT_EQ(rows.size(), 1u + 1u + 16u);  // names, start, four ticks in each of four frames
  const BodyPart& ball = scene.bodies.back();
  ASSERT_EQ(ball.name, "ball");
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double t = std::stod(rows[i][0]);
    EXPECT_NEAR(t, static_cast<double>(i - 1) / 120.0, 1e-12);
    EXPECT_NEAR(std::stod(rows[i][1]), ball.pose.position.x() + ball.velocity.x() * t, 1e-9);
    EXPECT_NEAR(std::stod(rows[i][2]), ball.pose.position.y() + ball.velocity.y() * t - 0.5 * 9.81 * t * t,
                1e-9);
  }
}

TEST(RunScene, WritesVtpFilesAndTheirSeries) {
  const auto folder = scratchFolder("vtp");
  SceneDef scene = smallSplash();
  scene.outputs.vtp = true;
  scene.outputs.vtpEvery = 2;
  runScene(scene, {.folder = folder, .frames = 4, .threads = 1});
  EXPECT_TRUE(std::filesystem::exists(folder / "particles.pvd"));
  for (const char* file : {"particles_00000.vtp", "particles_00002.vtp", "particles_00004.vtp"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / "vtp" / file)) << file;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "vtp/particles_00001.vtp"));
}

TEST(RunReport, HoldsCountsAndResult) {
  const Json report = makeReport(impact(), {.threads = 2}, {"granular_demo", "run"});
  EXPECT_EQ(report["result"], "completed");
  EXPECT_EQ(report["counts"]["grains"], 300);
  EXPECT_EQ(report["counts"]["grainParticles"], 1200);
  EXPECT_EQ(report["steps"]["ticks"], 56);
  EXPECT_EQ(report["checks"]["passed"], true);
  EXPECT_EQ(report["commandLine"], (Json{"granular_demo", "run"}));
}

TEST(RunReport, GivesTheCreepSpeedOfSandOnEveryMaterial) {
  const Json report = makeReport(impact(), {.threads = 2}, {});
  ASSERT_EQ(report["creepSpeeds"].size(), 4u);
  for (const Json& pair : report["creepSpeeds"]) {
    EXPECT_EQ(pair["grain"], "sand");
    EXPECT_GT(pair["speed"].get<double>(), 0.0);
  }
}

TEST(RunReport, HoldsTheAdviceAndTheSpeedItIsFor) {
  const Json report = makeReport(impact(), {.threads = 2}, {});
  EXPECT_EQ(report["advice"]["lines"].get<std::vector<std::string>>(), impact().scene->advice());
  EXPECT_EQ(report["advice"]["impactSpeed"], impact().scene->impactSpeed().speed);
}

// ---- the scene of one impact, read as a user reads it: from its trajectory

struct ObliqueImpact {
  double restitution, friction, degrees;  // angle of incidence from the normal
  granular::NormalLaw law = granular::NormalLaw::HertzViscoelastic;
};

class ImpactScene : public ::testing::TestWithParam<ObliqueImpact> {};

TEST_P(ImpactScene, ReboundsAsAskedAndSlidesAsCoulombSays) {
  const auto [e, mu, degrees, law] = GetParam();
  SceneDef scene = readSceneFile(findScene("impact"));
  scene.outputs.pictures = false;
  scene.pairs.at(0).law.restitution = e;
  scene.pairs.at(0).law.friction = mu;
  scene.pairs.at(0).law.normal.law = law;
  const double tangent = std::tan(degrees * std::numbers::pi / 180.0);
  const double radius = scene.shapes.at(0).particles.at(0).radius;
  scene.grains.at(0).velocity.x() = -tangent * scene.grains.at(0).velocity.y();
  const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto folder = scratchFolder("impact" + name.substr(name.find('/') + 1));  // they run side by side
  runScene(scene, {.folder = folder, .threads = 1});
  const auto rows = readCsv(folder / "trajectory_grain_ball.csv");
  const auto last = [&](std::size_t column) { return std::stod(rows.back().at(column)); };
  const auto first = [&](std::size_t column) { return std::stod(rows.at(1).at(column)); };
  constexpr std::size_t kVx = 4, kVy = 5, kWz = 13;
  EXPECT_NEAR(-last(kVy) / first(kVy), e, 1e-3);
  // It slides all the while: the impulse along the plane is mu times that across it.
  ASSERT_LT(3.5 * mu * (1.0 + e), tangent);
  EXPECT_NEAR(last(kVx) / first(kVx), 1.0 - mu * (1.0 + e) / tangent, 1e-3);
  const double spin = 2.5 * mu * (1.0 + e) * first(kVy) / radius;  // backwards: about -z
  EXPECT_NEAR(last(kWz), spin, 3e-3 * std::abs(spin));  // the lever is shorter by the overlap, up to 0.27 %
}

INSTANTIATE_TEST_SUITE_P(OfTheFileAndOthers, ImpactScene,
                         ::testing::Values(ObliqueImpact{0.9, 0.1, 60}, ObliqueImpact{0.5, 0.3, 75},
                                           ObliqueImpact{0.7, 0.05, 30},
                                           ObliqueImpact{0.98, 0.2, 80, granular::NormalLaw::LinearSpring},
                                           ObliqueImpact{0.3, 0.1, 45, granular::NormalLaw::HertzTsuji}));

// ---- energy check, on made-up energies

granular::StepReport stateOf(double kinetic, double potential, double workByMoved = 0.0) {
  granular::StepReport report;
  report.energy.kinetic = kinetic;
  report.energy.potential = potential;
  report.workByMovedBodies = workByMoved;
  return report;
}

TEST(EnergyCheck, TellsTheRiseAsAFractionOfTheFall) {
  EnergyCheck check;
  for (const double e : {10.0, 8.0, 6.0, 6.5, 5.0}) check.add(stateOf(e, 0));
  // From 6 to 6.5 when 4 had fallen.
  EXPECT_DOUBLE_EQ(check.worstFraction(), 0.5 / 4.0);
  EXPECT_DOUBLE_EQ(check.worstRise(), 0.5);
  EXPECT_DOUBLE_EQ(check.fallen(), 5.0);
}

TEST(EnergyCheck, IsSilentWhenEnergyOnlyChangesItsKind) {
  EnergyCheck check;
  for (const double kinetic : {0.0, 1.0, 2.0, 3.0}) check.add(stateOf(kinetic, 10.0 - kinetic));
  EXPECT_EQ(check.worstFraction(), 0.0);
}

TEST(EnergyCheck, DoesNotBlameWorkOfMovedBodies) {
  EnergyCheck check;
  check.add(stateOf(1.0, 0.0, 0.0));
  check.add(stateOf(6.0, 0.0, 5.0));
  EXPECT_EQ(check.worstFraction(), 0.0);
}

TEST(EnergyCheck, SeesAGainBeforeAnythingHasFallen) {
  EnergyCheck check;
  check.add(stateOf(1.0, 0.0));
  check.add(stateOf(1.1, 0.0));
  EXPECT_GT(check.worstFraction(), 1.0);
}

// ---- small parts

TEST(CsvFile, NumbersReadBackToTheSameBits) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "numbers.csv";
  const std::vector<double> numbers = {0.1, -1.0 / 3.0, 6.02214076e23, 5e-324, 0.0};
  CsvFile csv(file, {"a", "b", "c", "d", "e"});
  csv.row(numbers);
  const auto rows = readCsv(file);
  ASSERT_EQ(rows.size(), 2u);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    EXPECT_EQ(std::strtod(rows[1][i].c_str(), nullptr), numbers[i]);
}

TEST(CsvFile, QuotesTexts) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "texts.csv";
  CsvFile csv(file, {"scene", "width"});
  csv.row({"ring, 2\" wide"}, {0.5});
  std::ifstream in(file);
  std::string head, line;
  std::getline(in, head);
  std::getline(in, line);
  EXPECT_EQ(line, "\"ring, 2\"\" wide\",0.5");
}

TEST(CsvFile, NamesTheFileItCannotWrite) {
  EXPECT_THROW(CsvFile("/no/such/folder/a.csv", {"a"}), std::runtime_error);
}

TEST(ProgressLine, TellsTimesAsAClock) {
  EXPECT_EQ(clockText(65.2), "1:05");
  EXPECT_EQ(clockText(7261), "2:01:01");
}

}  // namespace
}  // namespace granular_demo

// SPDX-License-Identifier: MIT
// What a system becomes as input for LAMMPS, read back line by line. io_lammps_program_test.cpp lets LAMMPS
// itself judge.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <numbers>
#include <sstream>

#include "granular/granular.h"
#include "granular/io/lammps_writer.h"

namespace granular {
namespace {

constexpr double kRounding = 1e-15;  // relative: 17 digits say a double whole, sums of a few may lose a bit

std::filesystem::path folderOf(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("granular_lammps_" + name);
}

std::vector<std::string> linesOf(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Numbers of the lines of a section, which a blank line, its name and a blank line begin.
std::vector<std::vector<double>> section(const std::filesystem::path& file, const std::string& name) {
  const std::vector<std::string> lines = linesOf(file);
  auto line = std::find_if(lines.begin(), lines.end(), [&](const auto& l) { return l.starts_with(name); });
  std::vector<std::vector<double>> rows;
  if (line == lines.end()) return rows;
  for (line += 2; line != lines.end() && !line->empty(); ++line) {
    std::istringstream in(*line);
    rows.emplace_back();
    for (double number; in >> number;) rows.back().push_back(number);
  }
  return rows;
}

bool hasLine(const std::filesystem::path& file, const std::string& start) {
  const std::vector<std::string> lines = linesOf(file);
  return std::any_of(lines.begin(), lines.end(), [&](const auto& l) { return l.starts_with(start); });
}

bool mentions(const LammpsReport& report, const std::string& part) {
  return std::any_of(report.notes.begin(), report.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

/// A sphere, a tetrahedron that turns, a static and a dynamic covered body, on a floor.
struct SmallScene {
  GranularSystem system;
  MaterialId stone = system.addMaterial({.name = "stone"});
  GrainId sphere = system.addGrain({.shape = system.addGrainShape(sphereShape(0.005)),
                                    .material = stone,
                                    .pose = {.position = {0.0, 0.01, 0.0}},
                                    .velocity = {0.1, 0.2, 0.3}});
  GrainId tetrahedron = system.addGrain({.shape = system.addGrainShape(tetrahedronShape(0.004)),
                                         .material = stone,
                                         .pose = {{0.05, 0.02, 0.0}, Quaternion(0.5, 0.5, -0.5, 0.5)},
                                         .angularVelocity = {1.0, 2.0, 3.0},
                                         .scale = 1.1});
  BodyId block = system.addBody({.covering = {{{0.0, 0.0, 0.0}, {0.004, 0.0, 0.0}}, {0.003, 0.003}},
                                 .material = stone,
                                 .pose = {.position = {0.1, 0.02, 0.0}}});
  BodyId rod =
      system.addBody({.motion = BodyMotion::Dynamic,
                      .covering = {{{-0.01, 0.0, 0.0}, {0.01, 0.0, 0.0}}, {0.003, 0.003}},
                      .material = stone,
                      .mass = 0.02,
                      .principalInertia = {1e-7, 3e-6, 3e-6},
                      .pose = {{0.2, 0.02, 0.0}, Quaternion(Eigen::AngleAxisd(0.3, Vector3::UnitZ()))},
                      .velocity = {0.0, -1.0, 0.0},
                      .angularVelocity = {0.0, 0.0, 4.0}});
  BodyId floor = system.addBody({.exact = HalfSpace{}, .material = stone});
};

TEST(LammpsWriter, WritesEveryParticleOnceInTheOrderOfReadParticles) {
  const SmallScene scene;
  const std::filesystem::path folder = folderOf("order");
  const LammpsReport report = writeLammps(scene.system, folder);
  std::vector<ParticleView> particles;
  scene.system.readParticles(particles);
  const auto atoms = section(folder / "particles.data", "Atoms");
  ASSERT_EQ(atoms.size(), particles.size());
  EXPECT_EQ(report.atoms, static_cast<std::int64_t>(particles.size()));
  for (std::size_t i = 0; i < atoms.size(); ++i) {
    ASSERT_EQ(atoms[i].size(), 7u);
    EXPECT_EQ(atoms[i][0], static_cast<double>(i + 1));
    EXPECT_EQ(atoms[i][2], 2.0 * particles[i].radius);
    EXPECT_LE((Vector3(atoms[i][4], atoms[i][5], atoms[i][6]) - particles[i].position).norm(), 1e-16);
  }
}

TEST(LammpsWriter, GrainsWeighWhatTheyWeighHere) {
  const SmallScene scene;
  const std::filesystem::path folder = folderOf("mass");
  writeLammps(scene.system, folder);
  const auto atoms = section(folder / "particles.data", "Atoms");
  const auto massOf = [&](std::size_t i) {
    return atoms[i][3] * std::numbers::pi / 6.0 * std::pow(atoms[i][2], 3);
  };
  EXPECT_NEAR(massOf(0), scene.system.massOf(scene.sphere), kRounding * massOf(0));
  const double clump = massOf(1) + massOf(2) + massOf(3) + massOf(4);
  EXPECT_NEAR(clump, scene.system.massOf(scene.tetrahedron), 4.0 * kRounding * clump);
}

TEST(LammpsWriter, RigidBodiesHaveOurMassAndInertiaAboutWorldAxes) {
  const SmallScene scene;
  const std::filesystem::path folder = folderOf("rigid");
  const LammpsReport report = writeLammps(scene.system, folder, {.timeStep = 1e-5});
  EXPECT_EQ(report.rigidBodies, 2);
  const std::vector<std::string> lines = linesOf(folder / "bodies.rigid");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0], "2");
  std::istringstream in(lines[2]);
  std::vector<double> rod;
  for (double number; in >> number;) rod.push_back(number);
  ASSERT_EQ(rod.size(), 20u);
  EXPECT_EQ(rod[1], 0.02);
  // The inertia of a rod at angle a to the x axis: the axial moment along it, the other across.
  const double a = 0.3, axial = 1e-7, across = 3e-6;
  const double xx = axial * std::cos(a) * std::cos(a) + across * std::sin(a) * std::sin(a);
  EXPECT_NEAR(rod[5], xx, 1e-14 * across);
  EXPECT_NEAR(rod[8], (axial - across) * std::sin(a) * std::cos(a), 1e-14 * across);
  EXPECT_NEAR(rod[12], -1.0 - 9.81 * 0.5e-5, 1e-15);  // with the first kick of gravity, which LAMMPS forgets
  EXPECT_NEAR(rod[16], across * 4.0, 1e-14 * across);
}

TEST(LammpsWriter, EveryParticleOfARigidBodyNamesIt) {
  const SmallScene scene;
  const std::filesystem::path folder = folderOf("molecules");
  writeLammps(scene.system, folder);
  const auto molecules = section(folder / "particles.data", "Molecules");
  std::vector<double> numbers;
  for (const auto& row : molecules) numbers.push_back(row[1]);
  EXPECT_EQ(numbers, (std::vector<double>{0, 1, 1, 1, 1, 0, 0, 2, 2}));
}

TEST(LammpsWriter, StaticCoveredBodiesAreFrozen) {
  const SmallScene scene;
  const std::filesystem::path folder = folderOf("frozen");
  EXPECT_EQ(writeLammps(scene.system, folder).frozenAtoms, 2);
  EXPECT_TRUE(hasLine(folder / "in.granular", "fix held frozen freeze"));
}

TEST(LammpsWriter, SpheresAloneNeedNoRigidBodies) {
  GranularSystem system;
  system.addGrain({.shape = system.addGrainShape(sphereShape(0.01)), .material = system.addMaterial({})});
  const std::filesystem::path folder = folderOf("spheres");
  EXPECT_EQ(writeLammps(system, folder).files.size(), 2u);
  EXPECT_FALSE(hasLine(folder / "in.granular", "fix rigid"));
  EXPECT_TRUE(section(folder / "particles.data", "Molecules").empty());
}

/// Spheres of `count` sizes within 5 %, under a normal law and static friction.
GranularSystem mixture(NormalLaw law, int count) {
  GranularSystem system;
  const MaterialId stone = system.addMaterial({});
  system.setMaterialPair(stone, stone, {.normal = {.law = law}, .shear = {.law = ShearLaw::StaticFriction}});
  const GrainShapeId shape = system.addGrainShape(sphereShape(0.01));
  for (int i = 0; i < count; ++i) {
    system.addGrain({.shape = shape,
                     .material = stone,
                     .pose = {.position = {0.03 * i, 0.0, 0.0}},
                     .scale = 0.95 + 0.1 * i / count});
  }
  return system;
}

TEST(LammpsWriter, OneTypeServesAllSizesUnderALawThatDoesNotDependOnThem) {
  const LammpsReport report = writeLammps(mixture(NormalLaw::HertzTsuji, 50), folderOf("one_type"));
  EXPECT_EQ(report.types, 1);
  EXPECT_LT(report.coefficientError, 1e-9);
}

TEST(LammpsWriter, SizesHaveTypesOfTheirOwnWhereTheLawDependsOnThem) {
  const LammpsReport report = writeLammps(mixture(NormalLaw::HertzViscoelastic, 7), folderOf("own_types"));
  EXPECT_EQ(report.types, 7);
  EXPECT_EQ(report.coefficientError, 0.0);
}

TEST(LammpsWriter, SaysHowFarOffSharedCoefficientsAre) {
  const LammpsReport report =
      writeLammps(mixture(NormalLaw::HertzViscoelastic, 50), folderOf("shared"), {.largestTypeCount = 5});
  EXPECT_EQ(report.types, 5);
  // eta goes as R^-2, and a type spans a fifth of the ten per cent from end to end: about 2 % from its
  // middle.
  EXPECT_NEAR(report.coefficientError, 0.02, 0.006);
  EXPECT_TRUE(mentions(report, "coefficients of single pairs are off by up to"));
}

TEST(LammpsWriter, SaysThatTangentialVelocitiesHaveAnotherArm) {
  EXPECT_TRUE(mentions(writeLammps(SmallScene().system, folderOf("arm")), "R - xi/2"));
}

TEST(LammpsWriter, SaysThatBodiesDoNotMeetUnderALawByArea) {
  EXPECT_TRUE(mentions(writeLammps(SmallScene().system, folderOf("area")), "bodies do not meet one another"));
}

TEST(LammpsWriter, SaysThatLocksAndLoadsAreLeftOut) {
  SmallScene scene;
  scene.system.setBodyFactors(scene.rod, Vector3::UnitX(), Vector3::Zero());
  scene.system.setBodyLoad(scene.rod, {.force = Vector3::UnitX()});
  const LammpsReport report = writeLammps(scene.system, folderOf("locks"));
  EXPECT_TRUE(mentions(report, "factors are left out"));
  EXPECT_TRUE(mentions(report, "outside forces and torques"));
}

TEST(LammpsWriter, SaysThatFiltersAreLeftOutWhereTheyMatter) {
  SmallScene scene;
  EXPECT_FALSE(mentions(writeLammps(scene.system, folderOf("filters")), "contact filters"));
  // Held things need not meet one another anyway.
  const ContactFilter held{.group = 2u, .mask = ~2u};
  for (int i = 0; i < 2; ++i) {
    scene.system.addBody({.exact = HalfSpace{}, .material = scene.stone, .filter = held});
  }
  EXPECT_FALSE(mentions(writeLammps(scene.system, folderOf("filters")), "contact filters"));
  scene.system.addBody({.exact = HalfSpace{}, .material = scene.stone, .filter = {.mask = 2u}});
  EXPECT_TRUE(mentions(writeLammps(scene.system, folderOf("filters")), "contact filters"));
}

TEST(LammpsWriter, OldStyleIsRefusedForLawsItDoesNotHave) {
  const GranularSystem system = mixture(NormalLaw::HertzTsuji, 2);
  EXPECT_THROW(writeLammps(system, folderOf("old"), {.style = LammpsStyle::HertzHistory}),
               std::invalid_argument);
}

TEST(LammpsWriter, RefusesASystemInWhichNothingMoves) {
  GranularSystem system;
  system.addBody({.exact = HalfSpace{}, .material = system.addMaterial({})});
  EXPECT_THROW(writeLammps(system, folderOf("nothing")), std::invalid_argument);
}

TEST(LammpsWriter, RefusesATypeCountOutOfRange) {
  EXPECT_THROW(writeLammps(SmallScene().system, folderOf("count"), {.largestTypeCount = 0}),
               std::invalid_argument);
}

}  // namespace
}  // namespace granular

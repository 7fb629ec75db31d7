// SPDX-License-Identifier: MIT
// LAMMPS itself reads what we wrote, and finds the forces that we find. Built where LAMMPS is installed.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "granular/granular.h"
#include "granular/io/lammps_writer.h"
#include "granular/system/fill.h"
#include "tests/lammps_program.h"

namespace granular {
namespace {

using granular_test::DumpedAtom;

std::filesystem::path folderOf(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("granular_lammps_program_" + name);
}

constexpr double kRadius = 0.005;  // m

struct Laws {
  NormalLaw normal = NormalLaw::HertzViscoelastic;
  ShearLaw shear = ShearLaw::RegularisedCoulomb;
  double friction = 0.5;
};

/// Two spheres of different size and material, a tetrahedron and a dynamic covered rod, moving and turning,
/// in contact with one another, a floor, a tilted wall, a frozen particle and a frozen exact sphere.
GranularSystem heap(const Laws& laws) {
  GranularSystem system({.gravity = {0.3, -9.81, 0.2}});
  const MaterialId a = system.addMaterial({.name = "a", .friction = laws.friction});
  const MaterialId b = system.addMaterial({.name = "b",
                                           .density = 2100.0,
                                           .youngsModulus = 2e7,
                                           .poissonRatio = 0.25,
                                           .restitution = 0.6,
                                           .friction = laws.friction});
  for (const auto& [one, other] : {std::pair(a, a), std::pair(a, b), std::pair(b, b)}) {
    system.setMaterialPair(one, other, {.normal = {.law = laws.normal}, .shear = {.law = laws.shear}});
  }
  const GrainShapeId sphere = system.addGrainShape(sphereShape(kRadius));
  system.addGrain({.shape = sphere,
                   .material = a,
                   .pose = {.position = {0.0, 0.98 * kRadius, 0.0}},
                   .velocity = {0.3, 0.1, 0.0},
                   .angularVelocity = {5.0, 7.0, 50.0}});
  system.addGrain({.shape = sphere,
                   .material = b,
                   .pose = {.position = {1.98 * kRadius, 0.97 * kRadius, 0.0}},
                   .velocity = {-0.2, -0.1, 0.2},
                   .angularVelocity = {3.0, 4.0, -20.0},
                   .scale = 1.04});
  system.addGrain({.shape = system.addGrainShape(tetrahedronShape(kRadius)),
                   .material = a,
                   .pose = {{0.0, 3.62 * kRadius, 0.0}, Quaternion(0.5, 0.5, 0.5, 0.5)},
                   .velocity = {-0.1, -0.2, 0.2},
                   .angularVelocity = {3.0, 4.0, -20.0}});
  system.addBody({.motion = BodyMotion::Dynamic,
                  .covering = {{{-0.01, 0.0, 0.0}, {0.01, 0.0, 0.0}}, {kRadius, kRadius}},
                  .material = b,
                  .mass = 0.01,
                  .principalInertia = {1e-7, 1.5e-6, 2e-6},
                  .pose = {.position = {4.95 * kRadius, 2.3 * kRadius, 0.0}},
                  .velocity = {0.0, -0.2, 0.0},
                  .angularVelocity = {10.0, 3.0, 4.0}});
  system.addBody({.exact = HalfSpace{}, .material = b});
  const Vector3 tilted = Vector3(1.0, 0.1, 0.0).normalized();
  system.addBody(
      {.exact = HalfSpace{},
       .material = a,
       .pose = {{-0.96 * kRadius, 0.0, 0.0}, Quaternion::FromTwoVectors(Vector3::UnitY(), tilted)}});
  system.addBody({.covering = {{Vector3::Zero()}, {kRadius}},
                  .material = b,
                  .pose = {.position = {0.0, 0.98 * kRadius, 1.97 * kRadius}}});
  system.addBody({.exact = ExactSphere{2.0 * kRadius},
                  .exactPose = {.position = {kRadius, 0.0, 0.0}},
                  .material = a,
                  .pose = {.position = {kRadius, 0.98 * kRadius, -2.9 * kRadius}}});
  return system;
}

struct Forces {
  Vector3 onGrain[3], onRod;
};

/// Of contacts, and of gravity on the spheres: LAMMPS gives that of rigid bodies to their centres.
Forces ourForces(GranularSystem& system) {
  Forces forces;
  for (int g = 0; g < 3; ++g) {
    forces.onGrain[g] = (g < 2 ? system.massOf(system.grainAt(g)) : 0.0) * system.gravity();
  }
  forces.onRod.setZero();
  std::vector<ContactView> contacts;
  system.readContacts(contacts);
  for (const ContactView& contact : contacts) {
    for (int side = 0; side < 2; ++side) {
      const Vector3 force = side == 0 ? contact.force : Vector3(-contact.force);
      if (contact.ownerKind[side] == OwnerKind::Grain)
        forces.onGrain[contact.ownerIndex[side]] += force;
      else if (contact.ownerIndex[side] == 0)
        forces.onRod += force;
    }
  }
  return forces;
}

Forces lammpsForces(const GranularSystem& system, const std::string& name, LammpsDef def = {}) {
  def.dumpEvery = 1;
  writeLammps(system, folderOf(name), def);
  granular_test::runLammps(GRANULAR_LAMMPS, folderOf(name));
  const std::vector<DumpedAtom> atoms = granular_test::readDump(folderOf(name)).front().atoms;
  return {.onGrain = {atoms.at(0).force, atoms.at(1).force,
                      atoms.at(2).force + atoms.at(3).force + atoms.at(4).force + atoms.at(5).force},
          .onRod = atoms.at(6).force + atoms.at(7).force};
}

/// Largest difference as a fraction of the largest force.
double difference(const Forces& ours, const Forces& theirs) {
  double worst = (ours.onRod - theirs.onRod).norm(), largest = ours.onRod.norm();
  for (int g = 0; g < 3; ++g) {
    worst = std::max(worst, (ours.onGrain[g] - theirs.onGrain[g]).norm());
    largest = std::max(largest, ours.onGrain[g].norm());
  }
  return worst / largest;
}

std::string nameOf(const testing::TestParamInfo<NormalLaw>& law) {
  const char* names[] = {"Viscoelastic", "Tsuji", "ConstantDamping", "Linear"};
  return names[static_cast<int>(law.param)];
}

class LammpsNormalLaw : public testing::TestWithParam<NormalLaw> {};

TEST_P(LammpsNormalLaw, GivesTheForcesThatItGivesHere) {
  GranularSystem system = heap({.normal = GetParam(), .friction = 0.0});
  const Forces ours = ourForces(system);
  ASSERT_GT(ours.onRod.norm(), 1.0);  // N: all of them push
  const std::string name = "normal_" + std::to_string(static_cast<int>(GetParam()));
  EXPECT_LT(difference(ours, lammpsForces(system, name)),
            1e-13);  // rounding, overlaps being 1e-2 of positions
}

// At first touch springs have no load yet, and only the limit of friction and the dashpot could differ.
TEST_P(LammpsNormalLaw, GivesTheForcesThatItGivesHereWithViscosityOfItsOwn) {
  GranularSystem system = heap({.normal = GetParam(), .shear = ShearLaw::RegularisedCoulomb});
  const std::string name = "viscous_" + std::to_string(static_cast<int>(GetParam()));
  const double apart = difference(ourForces(system), lammpsForces(system, name));
  // Constant dampers: only the arm differs, R for R - xi/2, of which xi/R <= 0.06 of the rotational part.
  // Others: viscosity is matched at one overlap and goes as xi^alpha around it.
  const bool isConstant =
      GetParam() == NormalLaw::LinearSpring || GetParam() == NormalLaw::HertzConstantDamping;
  EXPECT_LT(apart, isConstant ? 0.01 : 0.1);
}

INSTANTIATE_TEST_SUITE_P(Laws, LammpsNormalLaw,
                         testing::Values(NormalLaw::HertzViscoelastic, NormalLaw::HertzTsuji,
                                         NormalLaw::HertzConstantDamping, NormalLaw::LinearSpring),
                         nameOf);

TEST(LammpsProgram, OldStyleGivesTheSameNormalForces) {
  GranularSystem system;
  const MaterialId stone = system.addMaterial({.friction = 0.0});
  const GrainShapeId sphere = system.addGrainShape(sphereShape(kRadius));
  for (const double x : {0.0, 1.97 * kRadius}) {
    system.addGrain({.shape = sphere,
                     .material = stone,
                     .pose = {.position = {x, 0.99 * kRadius, 0.0}},
                     .velocity = {-x, -0.2, 0.0}});
  }
  system.addBody({.exact = HalfSpace{}, .material = stone});
  writeLammps(system, folderOf("old"), {.dumpEvery = 1, .style = LammpsStyle::HertzHistory});
  granular_test::runLammps(GRANULAR_LAMMPS, folderOf("old"));
  const std::vector<DumpedAtom> atoms = granular_test::readDump(folderOf("old")).front().atoms;
  std::vector<ContactView> contacts;
  system.readContacts(contacts);
  ASSERT_EQ(contacts.size(), 3u);
  Vector3 force = system.massOf(system.grainAt(0)) * system.gravity();
  for (const ContactView& contact : contacts) {
    if (contact.ownerKind[0] == OwnerKind::Grain && contact.ownerIndex[0] == 0) force += contact.force;
  }
  EXPECT_LT((atoms.at(0).force - force).norm(), 1e-13 * force.norm());
}

// ---- motion: plain velocity Verlet in both, one evaluation a step

constexpr double kStep = 2e-5;  // s, a twentieth of a contact time

/// Grains at random in a corner of three walls, thrown at its middle.
GranularSystem shower(const GrainShapeDef& shape, const MaterialPairDef& pair) {
  GranularSystem system({.integrator = {.stepper = Stepper::Verlet, .fixedSubStep = kStep}});
  const MaterialId stone = system.addMaterial({});
  system.setMaterialPair(stone, stone, pair);
  const GrainShapeId id = system.addGrainShape(shape);
  for (const PlacedGrain& grain : fillRegion(boxRegion({{-0.02, 0.0, -0.02}, {0.02, 0.04, 0.02}}), shape,
                                             {.solidFraction = 0.45, .minScale = 0.8})) {
    system.addGrain({.shape = id,
                     .material = stone,
                     .pose = grain.pose,
                     .velocity = -60.0 * grain.pose.position,
                     .angularVelocity = {3.0, -5.0, 4.0},
                     .scale = grain.scale});
  }
  for (const Vector3& inward : std::array<Vector3, 3>{Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()}) {
    system.addBody({.exact = HalfSpace{},
                    .material = stone,
                    .pose = {{-0.02, 0.0, -0.02}, Quaternion::FromTwoVectors(Vector3::UnitY(), inward)}});
  }
  return system;
}

/// Distance of the farthest particle here from itself there after `steps`, in radii.
double apart(GranularSystem& system, const std::string& name, std::int64_t steps) {
  writeLammps(system, folderOf(name), {.timeStep = kStep, .steps = steps, .dumpEvery = steps});
  granular_test::runLammps(GRANULAR_LAMMPS, folderOf(name));
  const granular_test::DumpedState state = granular_test::readDump(folderOf(name)).back();
  EXPECT_EQ(state.step, steps);
  const StepReport report = system.step(static_cast<double>(steps) * kStep);
  EXPECT_EQ(report.subSteps, steps);
  EXPECT_GT(report.contacts, 20);
  std::vector<ParticleView> particles;
  system.readParticles(particles);
  double worst = 0.0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    worst = std::max(worst, (particles[i].position - state.atoms.at(i).position).norm());
  }
  return worst / kRadius;
}

MaterialPairDef frictionless() {
  return {.friction = 0.0, .normal = {.law = NormalLaw::HertzTsuji}};
}

// The same formulas in the same order but for sums: rounding, which contacts make grow.
TEST(LammpsProgram, SpheresMoveAsTheyDoHere) {
  GranularSystem system = shower(sphereShape(kRadius), frictionless());
  EXPECT_LT(apart(system, "spheres", 200), 1e-9);
}

// LAMMPS turns rigid bodies by an iteration, which is off by some (w dt)^3/12 a step: at the 500 rad/s that
// an impact of 2 m/s at 4 mm from the centre gives, 2e-5 in 200 steps, which contacts make grow.
TEST(LammpsProgram, ClumpsMoveAsTheyDoHere) {
  GranularSystem system = shower(tetrahedronShape(0.5 * kRadius), frictionless());
  EXPECT_LT(apart(system, "clumps", 200), 1e-4);
}

// Both dampers constant, so that LAMMPS has law 18 but for the arm of rotation, R for R - xi/2: some per cent
// of the way that spins of 10 rad/s make in 200 steps, 0.04 radii.
TEST(LammpsProgram, SpheresUnderLaw18PartByTheArmAlone) {
  MaterialPairDef pair{.normal = {.law = NormalLaw::HertzConstantDamping, .damping = 0.2}};
  pair.shear.viscosity = 0.5;
  GranularSystem system = shower(sphereShape(kRadius), pair);
  EXPECT_LT(apart(system, "law18", 200), 0.004);
}

}  // namespace
}  // namespace granular

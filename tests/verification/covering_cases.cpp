// SPDX-License-Identifier: MIT
// Covered bodies whose surface particles share the stiffness by area: what one sees must not depend on how
// densely the body is covered (VERIFICATION, section 5; Bell 2005, sec. 5, says that it does there).
#include <algorithm>
#include <cmath>
#include <sstream>

#include "granular/geometry/cover.h"
#include "granular/geometry/mesh_primitives.h"
#include "tests/verification/covering_drop.h"
#include "tests/verification/verification_case.h"

namespace granular::verification {
namespace {

constexpr char kSection[] = "covered bodies";

std::string text(double value) {
  std::ostringstream out;
  out.precision(4);
  out << value;
  return out.str();
}

std::string count(const Covering& covering) {
  return std::to_string(covering.positions.size()) + " particles";
}

/// A user's e, given with a speed, is what a drop test at that speed measures; the integrator at its
/// defaults.
std::vector<Check> restitutionAsAsked(CubePose pose) {
  std::vector<Check> checks;
  for (const int n : {2, 5, 14}) {
    const Covering covering = cubeCovering(n);
    for (const double e : {0.2, 0.5, 0.9}) {
      for (const double v : {0.1, 1.0}) {
        const CubeBounce bounce =
            dropCube({.covering = covering,
                      .pose = pose,
                      .speed = v,
                      .pair = {.restitution = e, .restitutionSpeed = v, .friction = 0.0}});
        checks.push_back(absolute("e asked " + text(e) + " at " + text(v) + " m/s, " + count(covering), e,
                                  bounce.restitution, 5e-3));
      }
    }
  }
  return checks;
}

/// Sparsely or densely covered, one face or all, it slides and gives way sideways as its material says.
std::vector<Check> flatDrop() {
  std::vector<Check> checks;
  const std::vector<Covering> coverings = {
      footCovering(2), footCovering(10), footCovering(32), cubeCovering(4),
      coverMesh(makeBox(Vector3::Constant(kCubeSide)), {.particleRadius = 0.006})};
  const auto bounceOf = [](const Covering& covering) {
    CubeDrop drop{.covering = covering};
    drop.pair.bodyNormal.stiffness = kStiffness;
    return dropCube(drop);
  };
  const double depth = bounceOf(coverings.front()).overlap;
  for (const Covering& covering : coverings) {
    const std::string with = ", " + count(covering);
    const CubeFriction friction = slideCube(covering, 0.4);
    const CubeBounce bounce = bounceOf(covering);
    checks.push_back(relative("restitution" + with, 0.5, bounce.restitution, 5e-3));
    checks.push_back(relative("overlap, that of 4 particles, m" + with, depth, bounce.overlap, 5e-3));
    checks.push_back(relative("stiffness, N/m" + with, exactStiffness(CubePose::Flat, 1e-4),
                              cubeStiffness(covering, CubePose::Flat, 1e-4), 1e-9));
    checks.push_back(
        relative("shear stiffness, N/m" + with, exactShearStiffness(), friction.shearStiffness, 0.01));
    checks.push_back(relative("friction coefficient" + with, 0.4, friction.coefficient, 1e-3));
  }
  return checks;
}

/// The force on a flat face is the given stiffness times area times depth.
std::vector<Check> givenStiffness() {
  std::vector<Check> checks;
  for (const int n : {2, 6}) {
    GranularSystem system({.gravity = Vector3::Zero()});
    const MaterialId stone = system.addMaterial({.name = "stone"});
    const double perVolume = 3e8, depth = 2e-4;
    system.setMaterialPair(stone, stone,
                           {.bodyNormal = {.law = NormalLaw::ElasticFoundation, .stiffness = perVolume}});
    system.addBody({.exact = HalfSpace{}, .material = stone});
    const BodyId cube = system.addBody({.motion = BodyMotion::Dynamic,
                                        .covering = cubeCovering(n),
                                        .material = stone,
                                        .mass = 1.0,
                                        .principalInertia = Vector3::Ones(),
                                        .pose = {.position = {0.0, 0.5 * kCubeSide - depth, 0.0}}});
    checks.push_back(relative("force, N, " + count(cubeCovering(n)),
                              perVolume * kCubeSide * kCubeSide * depth, system.contactWrench(cube).force.y(),
                              1e-9));
  }
  return checks;
}

/// However densely it is covered, the cube presses like the solid cube: flat, on its edge and on its corner.
void pressesLikeTheSolid(const Covering& covering, CubePose pose, std::vector<Check>& checks) {
  const double depth = depthOf(pose);
  const std::string with = ", " + count(covering);
  for (const double part : {0.1, 0.37, 1.0}) {
    checks.push_back(relative("stiffness at " + text(part * depth / kCubeSide) + " sides deep, N/m" + with,
                              exactStiffness(pose, part * depth), cubeStiffness(covering, pose, part * depth),
                              1e-9));
  }
  if (covering.positions.size() > 6000) return;  // drops take long
  // Two integrations' worth of the default tolerance, 1e-4 of a particle's radius.
  checks.push_back(
      relative("deepest overlap, m" + with, depth, dropCubeTo(covering, pose, depth).overlap, 1e-3));
  checks.push_back(
      relative("restitution" + with, 0.5, dropCube({.covering = covering, .pose = pose}).restitution, 5e-3));
}

std::vector<Check> cellsPressLikeTheSolid(CubePose pose) {
  std::vector<Check> checks;
  for (const int n : {1, 4, 8, 16, 32, 64}) pressesLikeTheSolid(cubeCovering(n), pose, checks);
  return checks;
}

/// Coverings as users get them: floaters on the mesh of the cube.
std::vector<Check> meshPressesLikeTheSolid(CubePose pose) {
  std::vector<Check> checks;
  const TriangleMesh mesh = makeBox(Vector3::Constant(kCubeSide));
  for (const double radius : {0.02, 0.012, 0.006, 0.003}) {
    pressesLikeTheSolid(coverMesh(mesh, {.particleRadius = radius}), pose, checks);
  }
  return checks;
}

/// Turned by any angle: the force of the plane's springs and where it acts.
std::vector<Check> tilted() {
  std::vector<Check> checks;
  const double depth = 0.002;  // of the middle of its foot
  const Covering coverings[] = {cubeCovering(3),
                                coverMesh(makeBox(Vector3::Constant(kCubeSide)), {.particleRadius = 0.006})};
  for (const Covering& covering : coverings) {
    for (const double angle : {0.0, 1e-6, 1e-3, 0.03, 0.05, 0.3}) {
      const TiltedCube expected = tiltedSolid(depth, angle), measured = tiltCube(covering, depth, angle);
      const std::string with = " turned by " + text(angle) + ", " + count(covering);
      checks.push_back(relative("force, N," + with, expected.force, measured.force, 1e-9));
      checks.push_back(absolute("torque about the middle, N m," + with, expected.torque, measured.torque,
                                1e-9 * expected.force * kCubeSide));
    }
  }
  return checks;
}

}  // namespace

void addCoveringCases(CaseList& cases) {
  const auto add = [&](const std::string& name, auto&& run) {
    cases.push_back({"5.covering." + name, kSection, run});
  };
  add("flat", flatDrop);
  add("given-stiffness", givenStiffness);
  for (const CubePose pose : {CubePose::Flat, CubePose::Edge, CubePose::Corner}) {
    add(std::string("e-as-asked.") + nameOf(pose), [=] { return restitutionAsAsked(pose); });
    add(std::string("as-the-solid.") + nameOf(pose), [=] { return cellsPressLikeTheSolid(pose); });
    add(std::string("as-the-solid.mesh.") + nameOf(pose), [=] { return meshPressesLikeTheSolid(pose); });
  }
  add("tilted", tilted);
}

}  // namespace granular::verification

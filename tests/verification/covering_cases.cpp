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

/// Each against the one before it, within 5 %.
std::vector<Check> flatDrop() {
  std::vector<Check> checks;
  CubeBounce first;
  CubeFriction firstFriction;
  double firstStiffness = 0.0;
  for (const int n : {2, 10, 32}) {  // 4, 100 and 1024 particles
    const Covering covering = footCovering(n);
    const CubeBounce bounce = dropCube({.covering = covering});
    const CubeFriction friction = slideCube(covering, 0.4);
    const double stiffness = cubeStiffness(covering, CubePose::Flat, 1e-4);
    if (n == 2) {
      first = bounce;
      firstFriction = friction;
      firstStiffness = stiffness;
    }
    const std::string with = ", " + count(covering);
    checks.push_back(relative("restitution" + with, first.restitution, bounce.restitution, 0.05));
    checks.push_back(relative("overlap, m" + with, first.overlap, bounce.overlap, 0.05));
    checks.push_back(relative("stiffness, N/m" + with, firstStiffness, stiffness, 0.05));
    checks.push_back(
        relative("shear stiffness, N/m" + with, firstFriction.shearStiffness, friction.shearStiffness, 0.05));
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

/// On edge and corner the covering rounds the solid off, less and less: restitution within 5 % throughout,
/// stiffness and overlap closer to those of the true cube with every refinement.
std::vector<Check> convergesOn(CubePose pose) {
  std::vector<Check> checks;
  const double depth = depthOf(pose);
  double overlapBefore = 1.0, stiffnessBefore = 1.0;
  for (const int n : {8, 16, 32, 64}) {
    const Covering covering = cubeCovering(n);
    const double overlap = dropCubeTo(covering, pose, depth).overlap / depth - 1.0;
    const double stiffness = cubeStiffness(covering, pose, depth) / exactStiffness(pose, depth) - 1.0;
    const std::string with = ", " + count(covering) + ", less than before";
    checks.push_back(absolute("overlap, off the true one by" + with, 0.0, overlap, overlapBefore));
    checks.push_back(absolute("stiffness, off the true one by" + with, 0.0, stiffness, stiffnessBefore));
    overlapBefore = std::abs(overlap);
    stiffnessBefore = std::abs(stiffness);
    if (n > 32) continue;
    checks.push_back(relative("restitution, " + count(covering), 0.5,
                              dropCube({.covering = covering, .pose = pose}).restitution, 0.05));
  }
  return checks;
}

/// Coverings as users get them: floaters on the mesh of the cube.
std::vector<Check> meshCovering(CubePose pose) {
  std::vector<Check> checks;
  const TriangleMesh mesh = makeBox(Vector3::Constant(kCubeSide));
  for (const double radius : {0.012, 0.006, 0.003}) {
    const Covering covering = coverMesh(mesh, {.particleRadius = radius});
    const CubeBounce bounce = dropCube({.covering = covering, .pose = pose});
    checks.push_back(relative("restitution, " + count(covering), 0.5, bounce.restitution, 0.05));
  }
  return checks;
}

}  // namespace

void addCoveringCases(CaseList& cases) {
  const auto add = [&](const std::string& name, auto&& run) {
    cases.push_back({"5.covering." + name, kSection, run});
  };
  add("flat-4-100-1000", flatDrop);
  add("given-stiffness", givenStiffness);
  for (const CubePose pose : {CubePose::Flat, CubePose::Edge, CubePose::Corner}) {
    add(std::string("e-as-asked.") + nameOf(pose), [=] { return restitutionAsAsked(pose); });
    add(std::string("mesh.") + nameOf(pose), [=] { return meshCovering(pose); });
  }
  for (const CubePose pose : {CubePose::Edge, CubePose::Corner}) {
    add(std::string("converges.") + nameOf(pose), [=] { return convergesOn(pose); });
  }
}

}  // namespace granular::verification

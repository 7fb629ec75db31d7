// SPDX-License-Identifier: MIT
// Exact surfaces: their distance against the nearest of many points on them, and what grains feel there.
#include "granular/geometry/exact_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "granular/base/random.h"
#include "granular/geometry/mesh_primitives.h"
#include "granular/granular.h"
#include "granular/system/fill.h"

namespace granular {
namespace {

constexpr double kSpacing = 0.02;  // of the mesh field's samples, m

/// A solid about 0.4 m across, with a mesh of it made apart.
struct Solid {
  std::string name;
  ExactSurface surface;
  TriangleMesh mesh;      // of the same solid, for brute force
  double rounding = 0.0;  // how far the surface may be from the mesh, m
};

TriangleMesh turned(TriangleMesh mesh, const Quaternion& turn) {
  for (Vector3& v : mesh.vertices) v = turn * v;
  return mesh;
}

ExactSurface fieldOf(const TriangleMesh& mesh) {
  return ExactMesh{
      std::make_shared<MeshField>(mesh, MeshFieldDef{.spacing = kSpacing, .reach = 4.0 * kSpacing})};
}

std::vector<Solid> solids() {
  const Vector3 size(0.4, 0.3, 0.2);
  const TriangleMesh tilted =
      turned(makeBox(size), Quaternion(Eigen::AngleAxisd(0.5, Vector3(1, 2, 3).normalized())));
  const Quaternion zToY = Quaternion::FromTwoVectors(Vector3::UnitZ(), Vector3::UnitY());
  // Facets are off a circle of radius r by r (1 - cos(pi / n)).
  const double facets = 0.2 * (1.0 - std::cos(3.15 / 200));
  return {{"sphere", ExactSphere{0.2}, makeIcosphere(0.2, 5), 2e-4},
          {"box", ExactBox{0.5 * size}, makeBox(size), 1e-12},
          {"capsule", ExactCapsule{0.1, 0.15}, turned(makeCapsule(0.1, 0.3, 200), zToY), facets},
          {"cylinder", ExactCylinder{0.2, 0.1}, turned(makeCylinder(0.2, 0.2, 200), zToY), facets},
          // Interpolation rounds an edge off by less than the half diagonal of a voxel.
          {"mesh", fieldOf(tilted), tilted, 0.87 * kSpacing}};
}

class ExactSurfaces : public testing::TestWithParam<Solid> {};

TEST_P(ExactSurfaces, AreAsFarAsTheNearestPointOfTheSurface) {
  const auto& [name, surface, mesh, rounding] = GetParam();
  const MeshDistance brute(mesh);  // tested against every triangle in geometry_triangle_mesh_test.cpp
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vector3 p(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
    const NearestPoint nearest = brute.nearest(p);
    const SurfaceDistance at = surfaceDistance(surface, p);
    EXPECT_NEAR(at.distance, nearest.signedDistance, rounding + 1e-12) << name << " at " << p.transpose();
    EXPECT_NEAR(at.normal.norm(), 1.0, 1e-12);
    EXPECT_TRUE(mayBeWithin(surface, p, std::max(1e-3, at.distance + 1e-9)));
    EXPECT_LE(p.norm(), boundingRadius(surface) + at.distance + rounding + 1e-12);
  }
}

TEST_P(ExactSurfaces, HaveTheirNormalAlongTheSlopeOfTheDistance) {
  const ExactSurface& surface = GetParam().surface;
  Random random(2);
  const double h = 1e-6;
  int skipped = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector3 p(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
    const SurfaceDistance at = surfaceDistance(surface, p);
    Vector3 slope, back;
    for (int k = 0; k < 3; ++k) {
      const Vector3 step = h * Vector3::Unit(k);
      slope[k] = (surfaceDistance(surface, p + step).distance - at.distance) / h;
      back[k] = (at.distance - surfaceDistance(surface, p - step).distance) / h;
    }
    if ((slope - back).norm() > 1e-3) {  // across a crease: in the middle of the solid, between samples
      ++skipped;
      continue;
    }
    EXPECT_LT((slope - at.slope * at.normal).norm(), 1e-3) << p.transpose();
  }
  EXPECT_LT(skipped, 25);
}

TEST_P(ExactSurfaces, ShowTheAreaOfTheirShadow) {
  const auto& [name, surface, mesh, rounding] = GetParam();
  Vector3 area = Vector3::Zero();
  for (const auto& t : mesh.triangles) area += 0.5 * doubleAreaVector(mesh, t).cwiseAbs();
  EXPECT_LT((shownArea(surface) - area).norm(), 2e-3 * area.norm());
}

/// An elastic ball flies at the free solid, centre to centre or off it.
TEST_P(ExactSurfaces, KeepMomentumAndEnergyInAnElasticImpact) {
  const auto& [name, surface, mesh, rounding] = GetParam();
  // At faces, edges, corners, and beside them.
  for (const Vector3& from : {Vector3(0, 1, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(1, 1.2, 0.9),
                              Vector3(-0.3, 1, 0.2), Vector3(-1, -0.3, 0.7)}) {
    GranularSystem system({.gravity = Vector3::Zero(), .integrator = {.tolerance = 1e-8}});
    const MaterialId stone = system.addMaterial({.restitution = 1.0, .friction = 0.0});
    const BodyId body = system.addBody({.motion = BodyMotion::Dynamic,
                                        .exact = surface,
                                        .material = stone,
                                        .mass = 3.0,
                                        .principalInertia = {0.03, 0.04, 0.05}});
    const Vector3 way = -from.normalized(), aside = 0.03 * way.unitOrthogonal();
    system.addGrain({.shape = system.addGrainShape(sphereShape(0.05)),
                     .material = stone,
                     .pose = {.position = aside - 0.33 * way},
                     .velocity = way});
    const StepReport before = system.measure();
    StepReport after;
    for (int i = 0; i < 60; ++i) after = system.step(0.01);
    ASSERT_GT(system.bodyMotion(body).velocity.norm(), 1e-3) << name << ": no impact";
    ASSERT_EQ(after.contacts, 0);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
    EXPECT_LT((after.angularMomentum - before.angularMomentum).norm(), 1e-5 * before.momentum.norm());
    // Interpolated distances have creases between voxels, which an integrator steps over; a ball that crosses
    // one at depth d errs by about d times the step.
    const double allowed = std::holds_alternative<ExactMesh>(surface) ? 1e-4 : 1e-6;
    EXPECT_NEAR(after.energy.kinetic, before.energy.kinetic, allowed * before.energy.kinetic)
        << name << " from " << from.transpose();
  }
}

TEST_P(ExactSurfaces, PushAGrainInsideOutTheShorterWay) {
  const auto& [name, surface, mesh, rounding] = GetParam();
  const MeshDistance brute(mesh);
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    Vector3 p;
    NearestPoint nearest;
    do {  // a little inside, and clear of creases: nearest to the middle of a face
      p = {random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)};
      nearest = brute.nearest(p);
    } while (nearest.signedDistance > -0.005 || nearest.signedDistance < -0.05 ||
             std::abs(surfaceDistance(surface, p).slope - 1.0) > 0.02);
    GranularSystem system({.gravity = Vector3::Zero()});
    const MaterialId stone = system.addMaterial({});
    system.addBody({.exact = surface, .material = stone});
    system.addGrain(
        {.shape = system.addGrainShape(sphereShape(0.01)), .material = stone, .pose = {.position = p}});
    std::vector<ContactView> contacts;
    system.readContacts(contacts);
    ASSERT_EQ(contacts.size(), 1u) << name;
    EXPECT_NEAR(contacts[0].overlap, 0.01 - nearest.signedDistance, rounding + 1e-12);
    const Vector3 out = (nearest.point - p).normalized();
    EXPECT_GT(contacts[0].force.normalized().dot(out), 0.99) << name << " at " << p.transpose();
  }
}

/// The frame of the surface may lie anywhere in that of the body.
TEST_P(ExactSurfaces, AreWhereTheirPoseSays) {
  GranularSystem system({.gravity = Vector3::Zero()});
  const MaterialId stone = system.addMaterial({});
  const Pose surface{{0, -0.1, 0.3}, Quaternion(Eigen::AngleAxisd(0.4, Vector3::UnitX()))};
  const Pose body{{5, 1, 0}, Quaternion(Eigen::AngleAxisd(-1.1, Vector3(1, 1, 0).normalized()))};
  system.addBody({.exact = GetParam().surface, .exactPose = surface, .material = stone, .pose = body});
  const Vector3 p(0.05, 0.21, 0.02);
  const SurfaceDistance at = surfaceDistance(GetParam().surface, p);
  const double radius = std::abs(at.distance) + 0.01;
  system.addGrain({.shape = system.addGrainShape(sphereShape(radius)),
                   .material = stone,
                   .pose = {.position = body.toWorld(surface.toWorld(p))}});
  std::vector<ContactView> contacts;
  system.readContacts(contacts);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].overlap, radius - at.distance, 1e-12);
  const Vector3 normal = body.orientation * (surface.orientation * at.normal);
  EXPECT_LT((contacts[0].force.normalized() - normal).norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(All, ExactSurfaces, testing::ValuesIn(solids()),
                         [](const auto& test) { return test.param.name; });

/// A ball slides over a face with no friction, across triangles and samples: it feels nothing but the face.
TEST(ExactSurface, HasNoGhostForcesOnAFace) {
  const TriangleMesh box = turned(makeBox({1.0, 0.2, 0.4}, 7), Quaternion::Identity());
  for (const ExactSurface& surface : {ExactSurface(ExactBox{{0.5, 0.1, 0.2}}), fieldOf(box)}) {
    GranularSystem system;
    const MaterialId stone = system.addMaterial({.restitution = 0.5, .friction = 0.0});
    const Quaternion slope(Eigen::AngleAxisd(0.3, Vector3::UnitZ()));
    const BodyId body = system.addBody({.exact = surface, .material = stone, .pose = {.orientation = slope}});
    const Vector3 start = slope * Vector3(0.4, 0.1 + 0.03 - 1e-6, 0.017);
    const GrainId ball = system.addGrain(
        {.shape = system.addGrainShape(sphereShape(0.03)), .material = stone, .pose = {.position = start}});
    for (int i = 0; i < 50; ++i) {
      system.step(0.01);
      const Vector3 own = slope.conjugate() * system.grainMotions()[ball.index].velocity;
      const double time = 0.01 * (i + 1);
      EXPECT_NEAR(own.x(), -9.81 * std::sin(0.3) * time, 1e-9);
      EXPECT_NEAR(own.z(), 0.0, 1e-9);
    }
    EXPECT_GT(system.contactWrench(body).force.norm(), 0.0);
  }
}

TEST(ExactSurface, OfAKinematicBodyPushesGrains) {
  GranularSystem system({.gravity = Vector3::Zero()});
  const MaterialId stone = system.addMaterial({.restitution = 1.0, .friction = 0.0});
  const BodyId box = system.addBody({.motion = BodyMotion::Kinematic,
                                     .exact = ExactBox{{0.1, 0.1, 0.1}},
                                     .material = stone,
                                     .velocity = {1, 0, 0}});
  const GrainId ball = system.addGrain({.shape = system.addGrainShape(sphereShape(0.02)),
                                        .material = stone,
                                        .pose = {.position = {0.13, 0, 0}}});
  double impulse = 0.0;
  for (int i = 0; i < 40; ++i) {
    system.step(0.005);
    impulse += system.contactImpulse(box).force.x();
  }
  // An elastic impact with something that does not give way: twice its speed.
  EXPECT_NEAR(system.grainMotions()[ball.index].velocity.x(), 2.0, 1e-3);
  EXPECT_NEAR(impulse, -2.0 * system.massOf(ball), 2e-3 * system.massOf(ball));
}

TEST(ExactSurface, OfABoxTurnsUnderAnOffCentreImpact) {
  GranularSystem system({.gravity = Vector3::Zero()});
  const MaterialId stone = system.addMaterial({.restitution = 1.0, .friction = 0.0});
  const double mass = 2.0, inertia = 0.02;
  const BodyId box = system.addBody({.motion = BodyMotion::Dynamic,
                                     .exact = ExactBox{{0.2, 0.1, 0.1}},
                                     .material = stone,
                                     .mass = mass,
                                     .principalInertia = Vector3::Constant(inertia)});
  const double arm = 0.15, speed = 0.1;
  const GrainId ball = system.addGrain({.shape = system.addGrainShape(sphereShape(0.02)),
                                        .material = stone,
                                        .pose = {.position = {arm, 0.125, 0}},
                                        .velocity = {0, -speed, 0}});
  for (int i = 0; i < 20; ++i) system.step(0.01);
  // Impulse of an elastic impact: 2 v / (1/m + 1/M + arm^2/I).
  const double impulse = 2.0 * speed / (1.0 / system.massOf(ball) + 1.0 / mass + arm * arm / inertia);
  EXPECT_NEAR(system.bodyMotion(box).velocity.y(), -impulse / mass, 2e-3 * impulse / mass);
  EXPECT_NEAR(system.bodyMotion(box).angularVelocity.z(), -impulse * arm / inertia,
              2e-3 * impulse * arm / inertia);
}

TEST(ExactSurface, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    GranularSystem system({.threads = threads});
    const MaterialId stone = system.addMaterial({});
    const GrainShapeDef tetrahedron = tetrahedronShape(0.02);
    const GrainShapeId shape = system.addGrainShape(tetrahedron);
    double x = 0.0;
    for (const Solid& solid : solids()) {
      system.addBody({.motion = x == 0.0 ? BodyMotion::Dynamic : BodyMotion::Static,
                      .exact = solid.surface,
                      .material = stone,
                      .mass = 10.0,
                      .principalInertia = Vector3::Ones(),
                      .pose = {.position = {x, 0, 0}}});
      const FillRegion region = boxRegion({{x - 0.2, 0.3, -0.2}, {x + 0.2, 0.5, 0.2}});
      for (const PlacedGrain& grain : fillRegion(region, tetrahedron, {.count = 40})) {
        system.addGrain({.shape = shape, .material = stone, .pose = grain.pose});
      }
      x += 0.45;
    }
    for (int i = 0; i < 15; ++i) system.step(0.02);
    std::vector<double> state;
    for (const RigidMotion& m : system.grainMotions()) {
      state.insert(state.end(), m.pose.position.data(), m.pose.position.data() + 3);
      state.insert(state.end(), m.angularVelocity.data(), m.angularVelocity.data() + 3);
    }
    return state;
  };
  const std::vector<double> one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(3), one);
}

TEST(MeshField, TakesMemoryByTheAreaOfTheSurface) {
  const auto bytes = [](double size) {
    const MeshField field(makeBox(Vector3::Constant(size)), {.spacing = 0.02, .reach = 0.04});
    return static_cast<double>(field.bytes());
  };
  const double growth = bytes(1.6) / bytes(0.8);  // 4 by area, 8 by volume
  EXPECT_GT(growth, 3.0);
  EXPECT_LT(growth, 5.0);
}

TEST(MeshField, RefusesWhatIsNotTheSurfaceOfASolid) {
  EXPECT_THROW(MeshField(makePlanePatch(1, 1), {.spacing = 0.1}), std::invalid_argument);
  EXPECT_THROW(MeshField(makeBox({1, 1, 1}), {.spacing = 0.0}), std::invalid_argument);
  EXPECT_THROW(MeshField(makeBox({1, 1, 1}), {.spacing = 0.1, .reach = -1.0}), std::invalid_argument);
}

TEST(ExactSurface, RefusesBadNumbersByField) {
  GranularSystem system;
  const MaterialId stone = system.addMaterial({});
  const auto refusal = [&](const ExactSurface& surface) -> std::string {
    try {
      system.addBody({.exact = surface, .material = stone});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal(ExactSphere{-1.0}).find("BodyDef.exact.radius"), std::string::npos);
  EXPECT_NE(refusal(ExactBox{{1, 0, 1}}).find("BodyDef.exact.halfSize"), std::string::npos);
  EXPECT_NE(refusal(ExactCapsule{0.1, -1.0}).find("BodyDef.exact.halfLength"), std::string::npos);
  EXPECT_NE(refusal(ExactCylinder{0.1, std::nan("")}).find("BodyDef.exact.halfLength"), std::string::npos);
  EXPECT_NE(refusal(ExactMesh{}).find("BodyDef.exact.field"), std::string::npos);
}

}  // namespace
}  // namespace granular

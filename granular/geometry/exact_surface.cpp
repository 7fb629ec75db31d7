// SPDX-License-Identifier: MIT
#include "granular/geometry/exact_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "granular/base/require.h"
#include "granular/geometry/mesh_field.h"

namespace granular {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

/// Away from `center`, or anywhere if p is there.
SurfaceDistance ofBall(const Vector3& p, const Vector3& center, double radius) {
  const Vector3 arm = p - center;
  const double length = arm.norm();
  return {length - radius, length > 0.0 ? Vector3(arm / length) : Vector3(Vector3::UnitY())};
}

/// excess: of a point over the surface along some directions at right angles, m, negative inside. Outside the
/// nearest point is on a face, edge or corner; inside on the nearest face.
template <int n>
SurfaceDistance ofSlabs(const Eigen::Matrix<double, n, 1>& excess, const std::array<Vector3, n>& directions) {
  int nearest;
  const double most = excess.maxCoeff(&nearest);
  const Eigen::Matrix<double, n, 1> outside = excess.cwiseMax(0.0);
  const double length = outside.norm();
  if (most <= 0.0 || length == most) return {most, directions[nearest]};
  Vector3 normal = Vector3::Zero();
  for (int k = 0; k < n; ++k) normal += outside[k] / length * directions[k];
  return {length, normal};
}

SurfaceDistance distanceTo(const HalfSpace&, const Vector3& p) {
  return {p.y(), Vector3::UnitY()};
}
SurfaceDistance distanceTo(const ExactSphere& ball, const Vector3& p) {
  return ofBall(p, Vector3::Zero(), ball.radius);
}

SurfaceDistance distanceTo(const ExactBox& box, const Vector3& p) {
  std::array<Vector3, 3> directions;
  for (int k = 0; k < 3; ++k) directions[k] = std::copysign(1.0, p[k]) * Vector3::Unit(k);
  return ofSlabs<3>(p.cwiseAbs() - box.halfSize, directions);
}

SurfaceDistance distanceTo(const ExactCapsule& capsule, const Vector3& p) {
  const double along = std::clamp(p.y(), -capsule.halfLength, capsule.halfLength);
  return ofBall(p, along * Vector3::UnitY(), capsule.radius);
}

SurfaceDistance distanceTo(const ExactCylinder& cylinder, const Vector3& p) {
  const Vector3 across(p.x(), 0.0, p.z());
  const double radius = across.norm();
  const Vector3 outward = radius > 0.0 ? Vector3(across / radius) : Vector3(Vector3::UnitX());
  return ofSlabs<2>({radius - cylinder.radius, std::abs(p.y()) - cylinder.halfLength},
                    {outward, std::copysign(1.0, p.y()) * Vector3::UnitY()});
}

SurfaceDistance distanceTo(const ExactMesh& mesh, const Vector3& p) {
  const DistanceSample s = mesh.field->at(p);
  const double slope = s.gradient.norm();
  if (!(slope > 0.0))
    return {s.value, Vector3::UnitY(), 0.0};  // the very middle of a part: no way is shorter
  return {s.value, s.gradient / slope, slope};
}

}  // namespace

SurfaceDistance surfaceDistance(const ExactSurface& surface, const Vector3& p) {
  return std::visit([&](const auto& s) { return distanceTo(s, p); }, surface);
}

bool mayBeWithin(const ExactSurface& surface, const Vector3& p, double reach) {
  if (const auto* mesh = std::get_if<ExactMesh>(&surface)) return mesh->field->mayBeWithin(p, reach);
  return surfaceDistance(surface, p).distance < reach;
}

double boundingRadius(const ExactSurface& surface) {
  return std::visit(Overloaded{[](const HalfSpace&) { return std::numeric_limits<double>::infinity(); },
                               [](const ExactSphere& s) { return s.radius; },
                               [](const ExactBox& s) { return s.halfSize.norm(); },
                               [](const ExactCapsule& s) { return s.halfLength + s.radius; },
                               [](const ExactCylinder& s) { return std::hypot(s.halfLength, s.radius); },
                               [](const ExactMesh& s) { return s.field->boundingRadius(); }},
                    surface);
}

Vector3 shownArea(const ExactSurface& surface) {
  const double pi = std::numbers::pi;
  return std::visit(
      Overloaded{
          [](const HalfSpace&) { return Vector3(Vector3::Zero()); },
          [&](const ExactSphere& s) { return Vector3(Vector3::Constant(2.0 * pi * s.radius * s.radius)); },
          [](const ExactBox& s) {
            return Vector3(8.0 * s.halfSize.y() * s.halfSize.z(), 8.0 * s.halfSize.z() * s.halfSize.x(),
                           8.0 * s.halfSize.x() * s.halfSize.y());
          },
          [&](const ExactCapsule& s) {
            const double disc = pi * s.radius * s.radius;
            const double side = 2.0 * (disc + 4.0 * s.radius * s.halfLength);
            return Vector3(side, 2.0 * disc, side);
          },
          [&](const ExactCylinder& s) {
            const double side = 8.0 * s.radius * s.halfLength;
            return Vector3(side, 2.0 * pi * s.radius * s.radius, side);
          },
          [](const ExactMesh& s) { return s.field->shownArea(); }},
      surface);
}

void checkExactSurface(const ExactSurface& surface, const std::string& what) {
  std::visit(Overloaded{[](const HalfSpace&) {},
                        [&](const ExactSphere& s) { requirePositive(s.radius, what + ".radius", "m"); },
                        [&](const ExactBox& s) {
                          for (int k = 0; k < 3; ++k) requirePositive(s.halfSize[k], what + ".halfSize", "m");
                        },
                        [&](const ExactCapsule& s) {
                          requirePositive(s.radius, what + ".radius", "m");
                          requireNotNegative(s.halfLength, what + ".halfLength", "m");
                        },
                        [&](const ExactCylinder& s) {
                          requirePositive(s.radius, what + ".radius", "m");
                          requirePositive(s.halfLength, what + ".halfLength", "m");
                        },
                        [&](const ExactMesh& s) {
                          require(s.field != nullptr, what + ".field", "null", "", "a MeshField");
                        }},
             surface);
}

}  // namespace granular

// SPDX-License-Identifier: MIT
#include "granular/system/fill_region.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "granular/base/require.h"
#include "granular/geometry/mesh_distance.h"

namespace granular {

FillRegion boxRegion(const Box& box) {
  requireFinite(box.lower, "boxRegion lower", "m");
  requireFinite(box.upper, "boxRegion upper", "m");
  require((box.size().array() > 0.0).all(), "boxRegion size", box.size().transpose(), "m",
          "> 0 in every direction");
  return {box, [box](const Vector3& p) {
            return std::min((p - box.lower).minCoeff(), (box.upper - p).minCoeff());
          }};
}

FillRegion ballRegion(const Vector3& center, double radius) {
  requireFinite(center, "ballRegion center", "m");
  requirePositive(radius, "ballRegion radius", "m");
  const Vector3 half = Vector3::Constant(radius);
  return {{center - half, center + half}, [=](const Vector3& p) { return radius - (p - center).norm(); }};
}

FillRegion cylinderRegion(const Vector3& foot, const Vector3& axis, double radius, double height) {
  return frustumRegion(foot, axis, radius, radius, height);
}

FillRegion coneRegion(const Vector3& foot, const Vector3& axis, double radius, double height) {
  return frustumRegion(foot, axis, radius, 0.0, height);
}

FillRegion frustumRegion(const Vector3& foot, const Vector3& axis, double footRadius, double topRadius,
                         double height) {
  requireFinite(foot, "frustumRegion foot", "m");
  requireFinite(axis, "frustumRegion axis", "");
  require(axis.norm() > 0.0, "frustumRegion axis", axis.transpose(), "", "not zero");
  requireNotNegative(footRadius, "frustumRegion footRadius", "m");
  requireNotNegative(topRadius, "frustumRegion topRadius", "m");
  requirePositive(std::max(footRadius, topRadius), "frustumRegion larger radius", "m");
  requirePositive(height, "frustumRegion height", "m");
  const Vector3 a = axis.normalized();
  // A disc of radius R across a reaches R sqrt(1 - a_i^2) along axis i.
  const Vector3 spread = (Vector3::Ones() - a.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  const Vector3 top = foot + height * a;
  const Box bounds = {(foot - footRadius * spread).cwiseMin(top - topRadius * spread),
                      (foot + footRadius * spread).cwiseMax(top + topRadius * spread)};
  const double slope = (topRadius - footRadius) / height;
  const double lateral = 1.0 / std::hypot(1.0, slope);  // cosine between the side and the axis
  return {bounds, [=](const Vector3& p) {
            const double z = a.dot(p - foot);
            const double r = (p - foot - z * a).norm();
            return std::min({z, height - z, lateral * (footRadius + slope * z - r)});
          }};
}

FillRegion boxRegion(const Pose& middle, const Vector3& size) {
  requireFinite(middle.position, "boxRegion middle", "m");
  requireRotation(middle.orientation, "boxRegion orientation");
  requireFinite(size, "boxRegion size", "m");
  require((size.array() > 0.0).all(), "boxRegion size", size.transpose(), "m", "> 0 in every direction");
  const Vector3 half = 0.5 * size;
  const Vector3 reach = middle.orientation.toRotationMatrix().cwiseAbs() * half;
  return {{middle.position - reach, middle.position + reach},
          [=](const Vector3& p) { return (half - middle.toOwn(p).cwiseAbs()).minCoeff(); }};
}

FillRegion slopeRegion(const SlopeDef& def) {
  requireFinite(def.foot, "SlopeDef.foot", "m");
  requireFinite(def.up, "SlopeDef.up", "");
  requireFinite(def.uphill, "SlopeDef.uphill", "");
  require(def.up.norm() > 0.0, "SlopeDef.up", def.up.transpose(), "", "not zero");
  const Vector3 up = def.up.normalized();
  const Vector3 level = def.uphill - up.dot(def.uphill) * up;
  require(level.norm() > 1e-9 * def.uphill.norm() && level.norm() > 0.0, "SlopeDef.uphill",
          def.uphill.transpose(), "", "not along SlopeDef.up");
  require(def.angleDegrees >= 0.0 && def.angleDegrees < 90.0, "SlopeDef.angleDegrees", def.angleDegrees,
          "degrees", "in [0, 90)");
  requirePositive(def.length, "SlopeDef.length", "m");
  requirePositive(def.width, "SlopeDef.width", "m");
  requirePositive(def.depth, "SlopeDef.depth", "m");
  const double angle = def.angleDegrees * std::numbers::pi / 180.0;
  const Vector3 along = std::cos(angle) * level.normalized() + std::sin(angle) * up;
  const Vector3 normal = std::cos(angle) * up - std::sin(angle) * level.normalized();
  Matrix3 axes;
  axes << along, normal, along.cross(normal);
  return boxRegion({def.foot + 0.5 * def.length * along + 0.5 * def.depth * normal, Quaternion(axes)},
                   {def.length, def.depth, def.width});
}

FillRegion meshRegion(const TriangleMesh& mesh) {
  const MeshReport report = checkMesh(mesh);
  if (!report.isSolid())
    throw std::invalid_argument("meshRegion: not the closed surface of a solid: " + report.text());
  const auto distance = std::make_shared<const MeshDistance>(mesh);
  return {distance->bounds(), [distance](const Vector3& p) { return -distance->nearest(p).signedDistance; }};
}

}  // namespace granular

// SPDX-License-Identifier: MIT
#include "granular/geometry/mass_properties.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <stdexcept>

#include "granular/base/require.h"

namespace granular {
namespace {

// Off-diagonal terms below this part of the trace are rounding of the sums over the faces: such axes are
// kept.
constexpr double kDiagonalTolerance = 1e-12;

/// Integrals over the solid of 1, x and x x^T, x from the reference point.
struct VolumeIntegrals {
  double one = 0.0;
  Vector3 x = Vector3::Zero();
  Matrix3 xx = Matrix3::Zero();
};

/// Tetrahedron (0, a, b, c) of volume V: int x = V/4 (a+b+c), int x x^T = V/20 (s s^T + a a^T + b b^T + c
/// c^T), s = a+b+c.
VolumeIntegrals integrate(const TriangleMesh& mesh, const Vector3& reference) {
  VolumeIntegrals sum;
  for (const auto& t : mesh.triangles) {
    const Vector3 a = mesh.vertices[t[0]] - reference;
    const Vector3 b = mesh.vertices[t[1]] - reference;
    const Vector3 c = mesh.vertices[t[2]] - reference;
    const double volume = a.dot(b.cross(c)) / 6.0;
    const Vector3 s = a + b + c;
    sum.one += volume;
    sum.x += volume / 4.0 * s;
    sum.xx += volume / 20.0 * (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  return sum;
}

bool isDiagonal(const Matrix3& m) {
  const double limit = kDiagonalTolerance * m.trace();
  return std::abs(m(0, 1)) <= limit && std::abs(m(0, 2)) <= limit && std::abs(m(1, 2)) <= limit;
}

/// The columns of `axes` in the order, and with the signs, of the right-handed rotation nearest to identity.
Matrix3 nearestToIdentity(const Matrix3& axes) {
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  Matrix3 best = Matrix3::Identity();
  double bestTrace = -4.0;  // the trace of a rotation is 1 + 2 cos(angle)
  for (const auto& order : kOrders) {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3 candidate;
      for (int k = 0; k < 3; ++k) candidate.col(k) = ((signs >> k) & 1 ? -1.0 : 1.0) * axes.col(order[k]);
      if (candidate.determinant() < 0.0 || candidate.trace() <= bestTrace) continue;
      best = candidate;
      bestTrace = candidate.trace();
    }
  }
  return best;
}

Matrix3 principalAxes(const Matrix3& inertia) {
  if (isDiagonal(inertia)) return Matrix3::Identity();
  return nearestToIdentity(Eigen::SelfAdjointEigenSolver<Matrix3>(inertia).eigenvectors());
}

}  // namespace

void findPrincipalFrame(MassProperties& properties) {
  const Matrix3 axes = principalAxes(properties.inertia);
  properties.principalMoments = (axes.transpose() * properties.inertia * axes).diagonal();
  properties.principalFrame = {properties.centerOfMass, Quaternion(axes).normalized()};
}

MassProperties massProperties(const TriangleMesh& mesh, double density) {
  requirePositive(density, "massProperties density", "kg/m^3");
  const MeshReport report = checkMesh(mesh);
  if (!report.isSolid()) {
    throw std::invalid_argument("massProperties needs the closed surface of a solid; the mesh has " +
                                report.text());
  }
  // A second pass about the centre of mass, so that the parallel-axis shift subtracts next to nothing.
  const Vector3 boxCenter = boundingBox(mesh).center();
  const VolumeIntegrals first = integrate(mesh, boxCenter);
  const Vector3 center = boxCenter + first.x / first.one;
  const VolumeIntegrals about = integrate(mesh, center);

  MassProperties result;
  result.volume = about.one;
  result.mass = density * about.one;
  result.centerOfMass = center;
  result.inertia = density * (about.xx.trace() * Matrix3::Identity() - about.xx);
  findPrincipalFrame(result);
  return result;
}

}  // namespace granular

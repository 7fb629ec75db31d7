// SPDX-License-Identifier: MIT
#include "granular/system/grain_shape.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "granular/base/require.h"

namespace granular {
namespace {

double sphereVolume(double radius) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
}

/// Inertia tensor about the origin at density 1: each particle's own, and Steiner's share.
Matrix3 unitInertiaTensor(const std::vector<ShapeParticle>& particles) {
  Matrix3 tensor = Matrix3::Zero();
  for (const ShapeParticle& p : particles) {
    const double volume = sphereVolume(p.radius);
    tensor += volume * (0.4 * p.radius * p.radius + p.position.squaredNorm()) * Matrix3::Identity();
    tensor -= volume * p.position * p.position.transpose();
  }
  return tensor;
}

/// Rotation whose columns are the principal axes; the identity where the tensor is already diagonal.
Matrix3 principalAxes(const Matrix3& tensor) {
  const Matrix3 offDiagonal = tensor - Matrix3(tensor.diagonal().asDiagonal());
  if (offDiagonal.norm() <= 1e-13 * tensor.norm()) return Matrix3::Identity();
  Matrix3 axes = Eigen::SelfAdjointEigenSolver<Matrix3>(tensor).eigenvectors();
  if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
  return axes;
}

}  // namespace

GrainShapeDef sphereShape(double particleRadius) {
  return {.name = "sphere", .particles = {{.radius = particleRadius}}};
}

GrainShapeDef tetrahedronShape(double particleRadius) {
  const double a = particleRadius / std::sqrt(2.0);  // corners at (+-a, +-a, +-a), edge 2 r
  return {.name = "tetrahedron",
          .particles = {{{a, a, a}, particleRadius},
                        {{a, -a, -a}, particleRadius},
                        {{-a, a, -a}, particleRadius},
                        {{-a, -a, a}, particleRadius}}};
}

GrainShapeDef cubeShape(double particleRadius) {
  GrainShapeDef def{.name = "cube", .particles = {}};
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    def.particles.push_back({particleRadius * side, particleRadius});
  }
  return def;
}

GrainShape makeGrainShape(const GrainShapeDef& def) {
  require(!def.particles.empty(), "GrainShapeDef.particles", 0, "particles", "at least one");
  for (const ShapeParticle& p : def.particles) {
    requirePositive(p.radius, "GrainShapeDef.particles.radius", "m");
    requireFinite(p.position, "GrainShapeDef.particles.position", "m");
  }
  GrainShape shape;
  shape.name = def.name;
  shape.particles = def.particles;

  Vector3 firstMoment = Vector3::Zero();
  for (const ShapeParticle& p : def.particles) {
    shape.volume += sphereVolume(p.radius);
    firstMoment += sphereVolume(p.radius) * p.position;
  }
  const Vector3 center = firstMoment / shape.volume;
  for (ShapeParticle& p : shape.particles) p.position -= center;

  const Matrix3 axes = principalAxes(unitInertiaTensor(shape.particles));
  for (ShapeParticle& p : shape.particles) {
    p.position = axes.transpose() * p.position;
    shape.boundingRadius = std::max(shape.boundingRadius, p.position.norm() + p.radius);
  }
  shape.unitInertia = unitInertiaTensor(shape.particles).diagonal();
  const double spread = shape.unitInertia.maxCoeff() - shape.unitInertia.minCoeff();
  shape.isotropic = spread <= 1e-12 * shape.unitInertia.maxCoeff();
  if (shape.isotropic) shape.unitInertia.setConstant(shape.unitInertia.mean());
  shape.principalFrame = {center, Quaternion(axes).normalized()};
  return shape;
}

}  // namespace granular

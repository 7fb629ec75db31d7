// SPDX-License-Identifier: MIT
#include "demos/impact_speed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "demos/built_scene.h"

namespace granular_demo {
namespace {

/// How far something reaches down and up along an axis, m.
struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double middle, double radius) {
    low = std::min(low, middle - radius);
    high = std::max(high, middle + radius);
  }
  double length() const { return std::max(0.0, high - low); }
};

/// Of all particles and exact bodies.
Span spanOf(const BuiltScene& scene, const Vector3& up) {
  Span span;
  std::vector<granular::ParticleView> particles;
  scene.grains().readParticles(particles);
  for (const granular::ParticleView& p : particles) span.add(up.dot(p.position), p.radius);
  for (const BuiltBody& body : scene.bodies()) {
    if (body.part->contact != BodyContact::exact || std::holds_alternative<HalfSpaceShape>(body.part->shape))
      continue;
    for (const Vector3& v : body.solid.parts.front().vertices) span.add(up.dot(body.pose().toWorld(v)), 0.0);
  }
  return span;
}

/// The point of a half-space nearest to where its body was put.
double heightOf(const HalfSpaceShape& space, const Pose& pose, const Vector3& up) {
  return up.dot(pose.toWorld(space.height * space.normal));
}

double heightOfScene(const BuiltScene& scene) {
  const Vector3 up = -scene.def().gravity.normalized();
  Span span = spanOf(scene, up);
  for (const BuiltBody& body : scene.bodies()) {
    const auto* space = std::get_if<HalfSpaceShape>(&body.part->shape);
    if (!space || !body.part->meetsGrains()) continue;
    const double height = heightOf(*space, body.pose(), up);
    if (height < span.high) span.low = std::min(span.low, height);
  }
  return span.length();
}

double largestStartSpeed(const BuiltScene& scene) {
  double speed = 0.0;
  for (const granular::RigidMotion& motion : scene.grains().grainMotions())
    speed = std::max(speed, motion.velocity.norm());
  for (const BodyPart& body : scene.def().bodies) speed = std::max(speed, body.velocity.norm());
  return speed;
}

std::string withNumber(const char* format, double number) {
  char text[64];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

}  // namespace

ImpactSpeed impactSpeedOf(const BuiltScene& scene) {
  const double atStart = largestStartSpeed(scene);
  const double gravity = scene.def().gravity.norm();
  const double height = gravity > 0.0 ? heightOfScene(scene) : 0.0;
  const double byFall = std::sqrt(2.0 * gravity * height);
  if (atStart >= byFall) return {atStart, "the largest speed at the start"};
  return {byFall, withNumber("a fall through the scene's height, %.3g m", height)};
}

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
#include "demos/world/body_copies.h"

#include "granular/base/random.h"

namespace granular_demo {
namespace {

BodyPart copyOf(const BodyPart& body, int number, int upAxis, const granular::Random& seed) {
  const CopiesDef& copies = *body.copies;
  const std::array<int, 3>& n = copies.counts;
  BodyPart copy = body;
  copy.name = body.name + "[" + std::to_string(number) + "]";
  copy.group = body.name;
  copy.copies.reset();
  copy.place = {number % n[0], number / n[0] % n[1], number / (n[0] * n[1])};
  for (int axis = 0; axis < 3; ++axis) copy.pose.position[axis] += copy.place[axis] * copies.step[axis];
  if (copy.place[upAxis] % 2 == 1) copy.pose.position += copies.stagger;
  granular::Random random = seed.forItem(static_cast<std::uint64_t>(number));
  for (int axis = 0; axis < 3; ++axis) copy.pose.position[axis] += copies.jitter * random.uniform(-1.0, 1.0);
  if (copies.randomOrientations) copy.pose.orientation = random.rotation();
  return copy;
}

}  // namespace

std::vector<BodyPart> withCopies(const SceneDef& scene) {
  int upAxis = 1;
  if (scene.gravity.norm() > 0.0) scene.gravity.cwiseAbs().maxCoeff(&upAxis);
  std::vector<BodyPart> all;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyPart& body = scene.bodies[i];
    if (!body.copies) {
      all.push_back(body);
      continue;
    }
    const granular::Random seed = granular::Random(scene.seed).forItem(body.copies->seed).forItem(i);
    for (int k = 0; k < body.copies->total(); ++k) all.push_back(copyOf(body, k, upAxis, seed));
  }
  return all;
}

}  // namespace granular_demo

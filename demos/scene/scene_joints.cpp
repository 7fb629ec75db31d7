// SPDX-License-Identifier: MIT
#include <algorithm>

#include "demos/scene/scene_readers.h"

namespace granular_demo {
namespace {

/// "wall" or, of copies, "wall[7]".
void checkBodyName(const JsonPlace& place, const std::vector<BodyPart>& bodies) {
  const std::string name = place.string();
  const std::string stem = name.substr(0, name.find('['));
  const auto body =
      std::find_if(bodies.begin(), bodies.end(), [&](const BodyPart& b) { return b.name == stem; });
  if (body == bodies.end()) place.fail("one of " + joined(namesOf(bodies)) + ", of copies with [number]");
  if (!body->copies) {
    if (name != stem) place.fail("\"" + stem + "\", which has no copies");
    return;
  }
  for (int i = 0; i < body->copies->total(); ++i) {
    if (name == stem + "[" + std::to_string(i) + "]") return;
  }
  place.fail("\"" + stem + "[0]\" to \"" + stem + "[" + std::to_string(body->copies->total() - 1) + "]\"");
}

std::vector<std::string> namesWithCopies(const std::vector<BodyPart>& bodies) {
  std::vector<std::string> names;
  for (const BodyPart& body : bodies) {
    if (body.copies) names.push_back(body.name);
  }
  return names;
}

JointPart readJoint(const std::string& name, const JsonPlace& place, const std::vector<BodyPart>& bodies) {
  JsonObject object(place);
  JointPart joint;
  joint.name = name;
  joint.kind = static_cast<JointKind>(object.choice("type", {"fixed", "hinge", "point"}));
  if (object.has("copiesOf")) {
    const std::vector<std::string> names = namesWithCopies(bodies);
    joint.copiesOf = names.empty() ? object.string("copiesOf") : names[object.choice("copiesOf", names)];
    if (names.empty()) object.at("copiesOf").fail("none, since no body has copies");
    joint.along = static_cast<int>(object.choice("along", {"x", "y", "z"}, 1));
  } else {
    const JsonPlace between = object.at("between");
    const std::vector<JsonPlace> names = between.elements();
    if (names.size() != 2) between.fail("the names of two bodies");
    for (std::size_t i = 0; i < 2; ++i) {
      checkBodyName(names[i], bodies);
      joint.bodies[i] = names[i].string();
    }
    if (joint.bodies[0] == joint.bodies[1]) between.fail("two different bodies");
    if (object.has("at")) joint.at = object.vector3("at");
  }
  if (joint.kind == JointKind::hinge) joint.axis = object.direction("axis", joint.axis).normalized();
  joint.breakingForce = object.optionalNumber("breakingForce", Range::positive());
  joint.touching = object.boolean("touching", joint.touching);
  object.finish();
  return joint;
}

}  // namespace

std::vector<JointPart> readJoints(const JsonPlace& place, const std::vector<BodyPart>& bodies) {
  std::vector<JointPart> all;
  for (const auto& [name, member] : JsonObject(place).members())
    all.push_back(readJoint(name, member, bodies));
  return all;
}

}  // namespace granular_demo

// SPDX-License-Identifier: MIT
// From a system to atoms, rigid bodies and walls. lammps_types.cpp sorts the atoms into types.
#include "granular/io/detail/lammps_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <variant>

namespace granular::detail {
namespace {

constexpr double kSameInertia = 1e-9;  // relative: a ball's, but for rounding

double ballVolume(double radius) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
}

/// Of an exact ball that grains meet; null: there is none.
const double* exactRadius(const BodyDef& body) {
  if (!body.exact || body.exactUse != ExactUse::Everything) return nullptr;
  const auto* ball = std::get_if<ExactSphere>(&*body.exact);
  return ball ? &ball->radius : nullptr;
}

/// An atom at p (own frame) of something that moves like this.
LammpsAtom atomOf(const RigidMotion& motion, const Vector3& p, double radius, double density) {
  const Vector3 arm = motion.pose.orientation * p;
  LammpsAtom atom;
  atom.position = motion.pose.position + arm;
  atom.velocity = motion.velocity + motion.angularVelocity.cross(arm);
  atom.angularVelocity = motion.angularVelocity;
  atom.radius = radius;
  atom.density = density;
  return atom;
}

}  // namespace

LammpsModel::LammpsModel(const GranularSystem& system, int largestTypeCount) : system_(system) {
  addGrains();
  addBodies();
  noteFilters();
  combineMaterialPairs();
  makeTypes(largestTypeCount);
  measureContacts();
}

void LammpsModel::note(const std::string& text) {
  if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
}

void LammpsModel::addAtom(LammpsAtom atom, const Side& side) {
  const auto found = std::find_if(families.begin(), families.end(), [&](const LammpsFamily& family) {
    return family.material == side.material && family.role == side.role;
  });
  atom.family = static_cast<std::int32_t>(found - families.begin());
  atom.size = side.size;
  if (found == families.end()) families.push_back({.material = side.material, .role = side.role});
  families[atom.family].sizes.push_back(side.size);
  atoms.push_back(std::move(atom));
}

void LammpsModel::addGrains() {
  for (std::int32_t g = 0; g < static_cast<std::int32_t>(system_.grainMotions().size()); ++g) {
    const GrainId id = system_.grainAt(g);
    if (id.index < 0) continue;
    const GrainShape& shape = system_.grainShape(system_.shapeOf(id));
    const MaterialId material = system_.materialOf(id);
    const double density = system_.material(material).density, scale = system_.scaleOf(id);
    const RigidMotion& motion = system_.grainMotions()[g];
    const double mass = system_.massOf(id);
    const bool isClump = shape.particles.size() > 1;
    if (isClump) {
      rigidBodies.push_back({.mass = mass,
                             .motion = motion,
                             .inertia = density * std::pow(scale, 5) * shape.unitInertia,
                             .reach = scale * shape.boundingRadius});
    }
    for (const ShapeParticle& particle : shape.particles) {
      LammpsAtom atom = atomOf(motion, scale * particle.position, scale * particle.radius, density);
      if (isClump) atom.molecule = static_cast<std::int64_t>(rigidBodies.size());
      addAtom(std::move(atom), {material, LammpsRole::Grain, {scale * particle.radius, mass}});
    }
    const ContactFilter& filter = system_.filterOf(id);
    filters_.insert({filter.group, filter.mask, false});
  }
}

void LammpsModel::addBodies() {
  std::int64_t exact = 0, dynamicExact = 0;
  for (const BodyId id : system_.bodies()) {
    const BodyDef body = system_.bodyDef(id);
    noteBody(id, body);
    addBody(body);
    const bool isMet = body.exact && body.exactUse == ExactUse::Everything;
    exact += isMet;
    dynamicExact += isMet && body.motion == BodyMotion::Dynamic;
  }
  if (dynamicExact > 0 && exact > 1) note("exact surfaces meet one another, which they do not here");
  for (auto& [atom, side] : exactSpheres_) addAtom(std::move(atom), side);
  exactSpheres_.clear();
}

void LammpsModel::addBody(const BodyDef& body) {
  const bool isDynamic = body.motion == BodyMotion::Dynamic;
  const RigidMotion motion{body.pose, body.velocity, body.angularVelocity};
  double volume = 0.0, reach = 0.0;
  for (std::size_t i = 0; i < body.covering.radii.size(); ++i) {
    volume += ballVolume(body.covering.radii[i]);
    reach = std::max(reach, body.covering.positions[i].norm() + body.covering.radii[i]);
  }
  std::size_t count = body.covering.radii.size();
  if (const double* radius = exactRadius(body)) {
    volume += ballVolume(*radius);
    reach = std::max(reach, body.exactPose.position.norm() + *radius);
    ++count;
  }
  const bool isRigid = isDynamic && count > 1;
  if (isRigid) rigidBodies.push_back({body.mass, motion, body.principalInertia, reach});
  if (isDynamic && count == 1) {                             // LAMMPS's rigid bodies have two atoms at least
    const double inertia = 0.4 * body.mass * reach * reach;  // a ball's, if its centre is the body's
    if ((body.principalInertia - Vector3::Constant(inertia)).norm() > kSameInertia * inertia) {
      note("dynamic bodies of a single particle turn as balls of that size and the body's mass do");
    }
  }
  const std::int64_t molecule = isRigid ? static_cast<std::int64_t>(rigidBodies.size()) : 0;
  const double density = isDynamic ? body.mass / volume : system_.material(body.material).density;
  const auto first = static_cast<std::int64_t>(atoms.size()) + 1;
  for (std::size_t i = 0; i < body.covering.radii.size(); ++i) {
    LammpsAtom atom = atomOf(motion, body.covering.positions[i], body.covering.radii[i], density);
    atom.molecule = molecule;
    addAtom(std::move(atom), {body.material,
                              isDynamic ? LammpsRole::DynamicBody : LammpsRole::FixedBody,
                              {body.covering.radii[i], isDynamic ? body.mass : 0.0}});
  }
  const bool moves = body.velocity != Vector3::Zero() || body.angularVelocity != Vector3::Zero();
  if (body.motion == BodyMotion::Kinematic && moves && !body.covering.radii.empty()) {
    movers.push_back({first, static_cast<std::int64_t>(atoms.size()), motion});
  }
  if (body.exact) addExactSurface(body, molecule, density);
}

void LammpsModel::addExactSurface(const BodyDef& body, std::int64_t molecule, double density) {
  if (body.exactUse != ExactUse::Everything) {
    note("exact surfaces that are for other bodies only are left out");
    return;
  }
  const bool isDynamic = body.motion == BodyMotion::Dynamic;
  const bool moves = body.velocity != Vector3::Zero() || body.angularVelocity != Vector3::Zero();
  if (!isDynamic && moves) note("exact surfaces of kinematic bodies stand still");
  if (std::holds_alternative<HalfSpace>(*body.exact)) {
    walls.push_back({body.material, body.pose.toWorld(body.exactPose.position),
                     body.pose.orientation * (body.exactPose.orientation * Vector3::UnitY())});
  } else if (const double* radius = exactRadius(body)) {
    const RigidMotion motion{body.pose, isDynamic ? body.velocity : Vector3(Vector3::Zero()),
                             isDynamic ? body.angularVelocity : Vector3(Vector3::Zero())};
    LammpsAtom atom = atomOf(motion, body.exactPose.position, *radius, density);
    atom.molecule = molecule;
    exactSpheres_.emplace_back(std::move(atom),
                               Side{body.material,
                                    isDynamic ? LammpsRole::DynamicBody : LammpsRole::FixedBody,
                                    {*radius, isDynamic ? body.mass : 0.0}});
  } else {
    note("exact surfaces other than half-spaces and spheres are left out");
  }
}

void LammpsModel::noteBody(BodyId id, const BodyDef& body) {
  filters_.insert({body.filter.group, body.filter.mask, body.motion != BodyMotion::Dynamic});
  if (body.motion == BodyMotion::Kinematic) {
    note("kinematic bodies move on as they do now: what the host would do with them is left out");
  }
  if (body.motion != BodyMotion::Dynamic) return;
  if (body.linearFactor != Vector3::Ones() || body.angularFactor != Vector3::Ones()) {
    note("linear and angular factors are left out: bodies move and turn about every axis");
  }
  const Wrench load = system_.bodyLoad(id);
  if (load.force != Vector3::Zero() || load.torque != Vector3::Zero()) {
    note("outside forces and torques on bodies are left out");
  }
  if (system_.bodyGravity(id) != system_.gravity())
    note("bodies with a gravity of their own feel everyone's");
}

/// LAMMPS lets everything meet: told if something that moves would pass through something here.
void LammpsModel::noteFilters() {
  for (const auto& [group, mask, isHeld] : filters_) {
    for (const auto& [otherGroup, otherMask, otherIsHeld] : filters_) {
      if (isHeld && otherIsHeld) continue;
      if ((group & otherMask) != 0 && (otherGroup & mask) != 0) continue;
      note("contact filters are left out: everything meets everything");
    }
  }
}

}  // namespace granular::detail

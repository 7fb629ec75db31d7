// SPDX-License-Identifier: MIT
// Every number that a user gives is refused if it is not finite or out of range: at the call that takes it,
// in a line that names the field.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "granular/granular.h"
#include "granular/system/fill.h"

namespace granular {
namespace {

enum class Allowed { Positive, NotNegative, AnyFinite };

/// A field of the public defs, and a call that is given a value for it.
struct Field {
  const char* name;
  Allowed allowed;
  std::function<void(double)> give;
};

template <class Set>
std::function<void(double)> inMaterial(Set set) {
  return [set](double x) {
    MaterialDef def;
    set(def, x);
    GranularSystem().addMaterial(def);
  };
}

template <class Set>
std::function<void(double)> inPair(Set set) {
  return [set](double x) {
    MaterialPairDef def;
    set(def, x);
    GranularSystem system;
    const MaterialId stone = system.addMaterial({});
    system.setMaterialPair(stone, stone, def);
  };
}

template <class Set>
std::function<void(double)> inIntegrator(Set set) {
  return [set](double x) {
    IntegratorDef def;
    set(def, x);
    GranularSystem().setIntegrator(def);
  };
}

template <class Set>
std::function<void(double)> inGrain(Set set) {
  return [set](double x) {
    GranularSystem system;
    GrainDef def;
    def.material = system.addMaterial({});
    def.shape = system.addGrainShape(sphereShape(0.01));
    set(def, x);
    system.addGrain(def);
  };
}

template <class Set>
std::function<void(double)> inBody(Set set) {
  return [set](double x) {
    GranularSystem system;
    BodyDef def;
    def.motion = BodyMotion::Dynamic;
    def.covering = {.positions = {Vector3::Zero()}, .radii = {0.01}};
    def.material = system.addMaterial({});
    def.mass = 1.0;
    def.principalInertia = Vector3::Ones();
    set(def, x);
    system.addBody(def);
  };
}

using M = MaterialDef;
using P = MaterialPairDef;
using I = IntegratorDef;

const Field kFields[] = {
    {"MaterialDef.density", Allowed::Positive, inMaterial([](M& d, double x) { d.density = x; })},
    {"MaterialDef.youngsModulus", Allowed::Positive, inMaterial([](M& d, double x) { d.youngsModulus = x; })},
    {"MaterialDef.restitution", Allowed::Positive, inMaterial([](M& d, double x) { d.restitution = x; })},
    {"MaterialDef.friction", Allowed::NotNegative, inMaterial([](M& d, double x) { d.friction = x; })},
    {"MaterialDef.poissonRatio", Allowed::AnyFinite, inMaterial([](M& d, double x) { d.poissonRatio = x; })},
    {"MaterialPairDef.restitution", Allowed::Positive, inPair([](P& d, double x) { d.restitution = x; })},
    {"MaterialPairDef.restitutionSpeed", Allowed::Positive,
     inPair([](P& d, double x) { d.restitutionSpeed = x; })},
    {"MaterialPairDef.friction", Allowed::NotNegative, inPair([](P& d, double x) { d.friction = x; })},
    {"MaterialPairDef.normal.contactTime", Allowed::Positive,
     inPair([](P& d, double x) { d.normal = {.law = NormalLaw::LinearSpring, .contactTime = x}; })},
    {"MaterialPairDef.normal.stiffness", Allowed::Positive,
     inPair([](P& d, double x) { d.normal.stiffness = x; })},
    {"MaterialPairDef.normal.damping", Allowed::NotNegative,
     inPair([](P& d, double x) { d.normal.damping = x; })},
    {"MaterialPairDef.bodyNormal.stiffness", Allowed::Positive,
     inPair([](P& d, double x) { d.bodyNormal.stiffness = x; })},
    {"MaterialPairDef.bodyNormal.damping", Allowed::NotNegative,
     inPair([](P& d, double x) { d.bodyNormal.damping = x; })},
    {"MaterialPairDef.shear.viscosity", Allowed::NotNegative,
     inPair([](P& d, double x) { d.shear.viscosity = x; })},
    {"MaterialPairDef.shear.stiffness", Allowed::Positive,
     inPair([](P& d, double x) { d.shear = {.law = ShearLaw::StaticFriction, .stiffness = x}; })},
    {"MaterialPairDef.shear.dampingRatio", Allowed::NotNegative,
     inPair([](P& d, double x) { d.shear = {.law = ShearLaw::StaticFriction, .dampingRatio = x}; })},
    {"IntegratorDef.tolerance", Allowed::Positive, inIntegrator([](I& d, double x) { d.tolerance = x; })},
    {"IntegratorDef.contactTimeFraction", Allowed::Positive,
     inIntegrator([](I& d, double x) { d.contactTimeFraction = x; })},
    {"IntegratorDef.eventFraction", Allowed::Positive,
     inIntegrator([](I& d, double x) { d.eventFraction = x; })},
    {"IntegratorDef.smallestSubStep", Allowed::Positive,
     inIntegrator([](I& d, double x) { d.smallestSubStep = x; })},
    {"GrainDef.scale", Allowed::Positive, inGrain([](GrainDef& d, double x) { d.scale = x; })},
    {"GrainDef.pose.position", Allowed::AnyFinite,
     inGrain([](GrainDef& d, double x) { d.pose.position.y() = x; })},
    {"GrainDef.velocity", Allowed::AnyFinite, inGrain([](GrainDef& d, double x) { d.velocity.x() = x; })},
    {"GrainDef.angularVelocity", Allowed::AnyFinite,
     inGrain([](GrainDef& d, double x) { d.angularVelocity.z() = x; })},
    {"BodyDef.mass", Allowed::Positive, inBody([](BodyDef& d, double x) { d.mass = x; })},
    {"BodyDef.principalInertia", Allowed::Positive,
     inBody([](BodyDef& d, double x) { d.principalInertia.y() = x; })},
    {"BodyDef.covering.radii", Allowed::Positive,
     inBody([](BodyDef& d, double x) { d.covering.radii = {x}; })},
    {"BodyDef.covering.positions", Allowed::AnyFinite, inBody([](BodyDef& d, double x) {
       d.covering.positions = {{x, 0, 0}};
     })},
    {"BodyDef.exact.radius", Allowed::Positive,
     inBody([](BodyDef& d, double x) { d.exact = ExactSphere{x}; })},
    {"BodyDef.pose.position", Allowed::AnyFinite,
     inBody([](BodyDef& d, double x) { d.pose.position.x() = x; })},
    {"BodyDef.velocity", Allowed::AnyFinite, inBody([](BodyDef& d, double x) { d.velocity.x() = x; })},
    {"BodyDef.angularVelocity", Allowed::AnyFinite,
     inBody([](BodyDef& d, double x) { d.angularVelocity.x() = x; })},
    {"gravity", Allowed::AnyFinite,
     [](double x) {
       GranularSystem().setGravity({0.0, x, 0.0});
     }},
    {"SystemDef.gravity", Allowed::AnyFinite,
     [](double x) {
       GranularSystem({.gravity = {x, 0.0, 0.0}});
     }},
};

struct Mistake {
  const Field* field;
  double value;
};

std::vector<Mistake> mistakes() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<Mistake> all;
  for (const Field& field : kFields) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity})
      all.push_back({&field, value});
    if (field.allowed != Allowed::AnyFinite) all.push_back({&field, -1.0});
    if (field.allowed == Allowed::Positive) all.push_back({&field, 0.0});
  }
  return all;
}

void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.field->name << " = " << mistake.value;
}

class Refusal : public testing::TestWithParam<Mistake> {};

TEST_P(Refusal, NamesTheField) {
  try {
    GetParam().field->give(GetParam().value);
    FAIL() << "it was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with(GetParam().field->name)) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(OfEveryNumber, Refusal, testing::ValuesIn(mistakes()));

/// What is refused above is refused for the value's sake.
TEST(Refusal, SparesAQuarter) {
  for (const Field& field : kFields) EXPECT_NO_THROW(field.give(0.25)) << field.name;
}

}  // namespace
}  // namespace granular

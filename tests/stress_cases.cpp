// SPDX-License-Identifier: MIT
#include "tests/stress_cases.h"

#include <cstdio>
#include <limits>
#include <utility>

#include "tests/stress_scenes.h"

namespace granular::stress {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string text(const char* format, double value) {
  char line[160];
  std::snprintf(line, sizeof line, format, value);
  return line;
}

const char* nameOf(Stepper stepper) {
  constexpr const char* kNames[] = {"RKF45", "leapfrog", "Verlet", "semi-implicit Euler", "Bogacki-Shampine"};
  return kNames[static_cast<int>(stepper)];
}

/// Below and above the longest step that closed forms allow in a packing and under law 18.
void addBounds(std::vector<Case>& cases) {
  for (const Stepper stepper : {Stepper::Leapfrog, Stepper::Verlet}) {
    const std::string name = "packing bound ";
    const std::string setUp = "20 balls in a row on undamped springs, ";
    cases.push_back(
        {.name = name + "kept, " + nameOf(stepper),
         .setUp = setUp + "dt = 0.99 x 2/w, w^2 = 2 sum over contacts [k/m]",
         .expectation = "no mode grows: speed below the sum of the modes of the start, 3 times it",
         .lowest = 0.5,
         .highest = 3.0,
         .wantedFlags = StepFlag::FixedSubStepTooLong,
         .isQuick = true,
         .run = [=] { return row(stepper, 0.99); }});
    cases.push_back({.name = name + "passed, " + nameOf(stepper),
                     .setUp = setUp + "dt = 1.01 x 2/w",
                     .expectation = "the fastest mode, at 0.997 of the bound, grows a hundredfold; flagged",
                     .lowest = 100.0,
                     .highest = kInfinity,
                     .wantedFlags = StepFlag::FixedSubStepTooLong,
                     .isQuick = true,
                     .run = [=] { return row(stepper, 1.01); }});
  }
  for (const auto& [stepper, limit] :
       {std::pair(Stepper::Leapfrog, largestFrequencyByLeapfrog()), std::pair(Stepper::Verlet, 2.0)}) {
    const std::string name = "bound by springs of friction ";
    cases.push_back({.name = name + "kept, " + nameOf(stepper),
                     .setUp = text("64 balls in a cubic lattice, kt = 0.8 k, w dt = 0.98 x %.3f", limit) +
                              ", w^2 = 20 kt/m",
                     .expectation = "no mode grows: spin below that of the start times 1/sqrt(1 - 0.98^2)",
                     .lowest = 0.5,
                     .highest = 5.1,
                     .wantedFlags = StepFlag::FixedSubStepTooLong,
                     .isQuick = true,
                     .run = [stepper = stepper, limit = limit] { return lattice(stepper, 0.98 * limit); }});
    cases.push_back({.name = name + "passed, " + nameOf(stepper),
                     .setUp = text("the same, 1.05 x %.3f", limit),
                     .expectation = "all turning alike, the fastest mode, grows a hundredfold; flagged",
                     .lowest = 100.0,
                     .highest = kInfinity,
                     .wantedFlags = StepFlag::FixedSubStepTooLong,
                     .isQuick = true,
                     .run = [stepper = stepper, limit = limit] { return lattice(stepper, 1.05 * limit); }});
  }
  const std::pair<Stepper, double> limits[] = {{Stepper::Leapfrog, 1.0},
                                               {Stepper::Verlet, 2.0},
                                               {Stepper::SemiImplicitEuler, 2.0},
                                               {Stepper::Rkf45, largestRateByRkf45()}};
  for (const std::pair<Stepper, double>& bound : limits) {
    const Stepper stepper = bound.first;
    const double limit = bound.second;
    cases.push_back(
        {.name = std::string("law 18's rate kept, ") + nameOf(stepper),
         .setUp = text("a ball slides, dt kt (1/m + R^2/I) = 0.98 x %.3f", limit),
         .expectation = "sliding dies away: speed never above that of the start",
         .lowest = 0.0,
         .highest = 1.0,
         .wantedFlags = stepper == Stepper::Rkf45 ? StepFlag::FixedSubStepTooLong : StepFlag::None,
         .isQuick = true,
         .run = [=] { return slide(stepper, 0.98 * limit); }});
    cases.push_back({.name = std::string("law 18's rate passed, ") + nameOf(stepper),
                     .setUp = text("the same, 1.03 x %.3f", limit),
                     .expectation = "beyond the stepper's limit it grows a hundredfold; flagged",
                     .lowest = 100.0,
                     .highest = kInfinity,
                     .wantedFlags = StepFlag::FixedSubStepTooLong,
                     .isQuick = true,
                     .run = [=] { return slide(stepper, 1.03 * limit); }});
  }
  for (const auto& [stepper, limit] : {std::pair(Stepper::Leapfrog, 1.0), std::pair(Stepper::Verlet, 2.0),
                                       std::pair(Stepper::SemiImplicitEuler, 2.0)}) {
    cases.push_back({.name = std::string("steps found for law 18's rate, ") + nameOf(stepper),
                     .setUp = "a ball slides, kt a thousand times what a contact time asks for",
                     .expectation = text("longest sub-step times kt (1/m + R^2/I) is %.0f", limit),
                     .lowest = 0.9 * limit,  // a step is shared out evenly among its sub-steps
                     .highest = (1.0 + 1e-9) * limit,
                     .isQuick = true,
                     .run = [stepper = stepper] { return slideOfItself(stepper); }});
  }
  for (const double x : {0.3, 0.8}) {
    cases.push_back({.name = text("RKF45 on a spring, w0 dt = %.1f", x),
                     .setUp = "ball on an undamped linear spring, fixed steps",
                     .expectation = "swing over |P(i w0 dt)|^2000 of its stability polynomial, within 1 %",
                     .lowest = 0.99,
                     .highest = 1.01,
                     .wantedFlags = x > 0.5 ? StepFlag::FixedSubStepTooLong : StepFlag::None,
                     .isQuick = true,
                     .run = [=] { return growthByRkf45(x); }});
  }
}

void addSteps(std::vector<Case>& cases) {
  for (const Stepper stepper : {Stepper::Leapfrog, Stepper::Verlet, Stepper::SemiImplicitEuler}) {
    cases.push_back({.name = std::string("largest step, ") + nameOf(stepper),
                     .setUp = "ball on an undamped linear spring, w0 dt = 1.95",
                     .expectation = "swing stays below 1/sqrt(1 - (w0 dt/2)^2) = 4.5 times the first",
                     .highest = 4.6,
                     .wantedFlags = StepFlag::FixedSubStepTooLong,
                     .isQuick = true,
                     .run = [=] { return swing(stepper, 1.95); }});
    cases.push_back(
        {.name = std::string("too large a step, ") + nameOf(stepper),
         .setUp = "the same, w0 dt = 2.05",
         .expectation = "beyond w0 dt = 2 the swing grows without bounds: a hundredfold, and is flagged",
         .lowest = 100.0,
         .highest = kInfinity,
         .wantedFlags = StepFlag::FixedSubStepTooLong,
         .isQuick = true,
         .run = [=] { return swing(stepper, 2.05); }});
  }
  addBounds(cases);
  for (const double E : {1e5, 1e7, 1e9, 1e11}) {
    cases.push_back({.name = text("stiffness %.0e Pa", E),
                     .setUp = "ball on a floor at 0.3 m/s, e = 0.5 at that speed, default integrator",
                     .expectation = "rebound / impact speed is the e asked for, within 1e-3",
                     .lowest = 0.499,
                     .highest = 0.501,
                     .isQuick = true,
                     .run = [=] { return rebound(E, 0.3); }});
  }
  for (const Stepper stepper : {Stepper::Rkf45, Stepper::Leapfrog, Stepper::BogackiShampine}) {
    for (const double tolerance : {1e-1, 1e-3, 1e-6}) {
      cases.push_back({.name = std::string("drop, ") + nameOf(stepper) + text(", tolerance %.0e", tolerance),
                       .setUp = "ball dropped from rest, 1.25 s",
                       .expectation = "never rises above its start, radii",
                       .lowest = -kInfinity,
                       .highest = 0.0,
                       .isQuick = true,
                       .run = [=] { return riseAfterDrop(stepper, tolerance); }});
    }
  }
  for (const Stepper stepper : {Stepper::Rkf45, Stepper::Leapfrog}) {
    cases.push_back({.name = std::string("a million steps at rest, ") + nameOf(stepper),
                     .setUp = "ball on the floor, law 19, fixed sub-steps of 2e-5 s",
                     .expectation = "way made, radii: rounding of a million sums of 1e-16",
                     .highest = 1e-9,
                     .run = [=] { return millionSteps(stepper); }});
  }
  const double reference = bounceAtFrames(1.0 / 240.0).measured;
  for (const double rate : {60.0, 15.0, 5.0}) {
    cases.push_back({.name = text("frames of 1/%.0f s", rate),
                     .setUp = "ball dropped from 10 radii, 0.2 s",
                     .expectation = "height is that of frames of 1/240 s within 0.01 radii",
                     .lowest = reference - 0.01,
                     .highest = reference + 0.01,
                     .isQuick = true,
                     .run = [=] { return bounceAtFrames(1.0 / rate); }});
  }
}

void addMasses(std::vector<Case>& cases) {
  cases.push_back({.name = "body 1e6 times as heavy",
                   .setUp = "it hits a free grain at 1 m/s, e = 0.5 at 1 m/s",
                   .expectation = "grain's speed / (1 + e) of the body's, within 1e-3",
                   .lowest = 0.999,
                   .highest = 1.001,
                   .isQuick = true,
                   .run = heavyBody});
  cases.push_back({.name = "radii 1 : 20",
                   .setUp = "a ball of 20 R laid on a bed of two layers, E = 1e9 Pa, 0.5 s",
                   .expectation = "comes to rest: kinetic energy below 1e-3 m g R of the large one",
                   .highest = 1e-3,
                   .run = [] { return unequal(20.0, 1.0, 1e9); }});
  cases.push_back({.name = "densities 1 : 1000",
                   .setUp = "a ball 1000 times as dense laid on a bed of two layers, E = 1e9 Pa, 0.5 s",
                   .expectation = "comes to rest: kinetic energy below 1e-2 m g R of the heavy one",
                   .highest = 1e-2,
                   .run = [] { return unequal(1.0, 1000.0, 1e9); }});
}

void addStarts(std::vector<Case>& cases) {
  cases.push_back({.name = "overlap of half a diameter",
                   .setUp = "two balls let go",
                   .expectation = "kinetic energy over the elastic one of the start, <= 1",
                   .lowest = 0.1,
                   .highest = 1.0,
                   .highestEnergyRatio = 1.001,
                   .isQuick = true,
                   .run = [] { return letGo(0.499); }});
  cases.push_back(
      {.name = "coincident centres",
       .setUp = "two balls in one place let go",
       .expectation = "kinetic energy over the elastic one of the start, <= 1; flagged as too deep",
       .lowest = 0.1,
       .highest = 1.0,
       .highestEnergyRatio = 1.001,
       .wantedFlags = StepFlag::DeepOverlap,
       .isQuick = true,
       .run = [] { return letGo(1.0); }});
  for (const Stepper stepper : {Stepper::Rkf45, Stepper::Leapfrog}) {
    cases.push_back({.name = std::string("momentum of a cloud, ") + nameOf(stepper),
                     .setUp = "64 balls that fall together without outside forces",
                     .expectation = "change of momentum over sum m v: rounding",
                     .highest = 1e-12,
                     .highestEnergyRatio = 1.0001,
                     .isQuick = true,
                     .run = [=] { return cloud(stepper); }});
  }
}

void addSpeeds(std::vector<Case>& cases) {
  cases.push_back({.name = "100 m/s at a covering, E = 130 MPa",
                   .setUp = "49 balls at particles two radii apart, each at another place of the lattice",
                   .expectation = "none crosses: the barrier of four particles exceeds the kinetic energy",
                   .highest = 0.0,
                   .run = [] { return shots(1.3e8); }});
  cases.push_back({.name = "100 m/s at a covering, E = 10 MPa",
                   .setUp = "the same, softer than the barrier needs",
                   .expectation = "those that cross are counted, of 49",
                   .lowest = 1.0,
                   .highest = 49.0,
                   .wantedFlags = StepFlag::DeepOverlap,
                   .isQuick = true,
                   .run = [] { return shots(1e7); }});
  const double modulus = advisedModulus(100.0);
  cases.push_back({.name = text("100 m/s at a covering, advised E = %.2g Pa", modulus),
                   .setUp = "the same, at the Young's modulus that advice(100 m/s) names in place of 10 MPa",
                   .expectation = "none crosses",
                   .highest = 0.0,
                   .run = [=] { return shots(modulus); }});
  for (const double speed : {1.0, 100.0}) {
    cases.push_back({.name = text("wall at %.0f m/s", speed),
                     .setUp = "a kinematic wall hits a resting ball, e = 0.5, E = 1e9 Pa",
                     .expectation = "ball's speed over (1 + e) of the wall's, within 1e-3",
                     .lowest = 0.999,
                     .highest = 1.001,
                     .isQuick = true,
                     .run = [=] { return movingWall(speed, 1e9); }});
  }
}

void addBeds(std::vector<Case>& cases) {
  for (const ShearLaw law : {ShearLaw::RegularisedCoulomb, ShearLaw::StaticFriction}) {
    for (const Stepper stepper : {Stepper::Rkf45, Stepper::Leapfrog}) {
      for (const double E : {1e7, 1e9}) {
        cases.push_back({.name = std::string("bed at rest, ") +
                                 (law == ShearLaw::StaticFriction ? "law 19, " : "law 18, ") +
                                 nameOf(stepper) + text(", E = %.0e Pa", E),
                         .setUp = "54 balls between walls, 1.5 s",
                         .expectation = "kinetic energy and energy made in the last half below 1e-3 of m g R",
                         .highest = 1e-3,
                         .highestEnergyRatio = 1.001,
                         .run = [=] { return bedAtRest(law, stepper, E); }});
      }
    }
  }
  for (const Stepper stepper : {Stepper::Rkf45, Stepper::Leapfrog, Stepper::Verlet}) {
    cases.push_back({.name = std::string("undamped springs of friction, ") + nameOf(stepper),
                     .setUp = "164 balls in the hollows of one another, law 19, 0.6 s",
                     .expectation = "energy made from nowhere in the last 0.4 s, over m g R of all",
                     .lowest = -1e-3,
                     .highest = 1e-3,
                     .isQuick = stepper == Stepper::Leapfrog,
                     .run = [=] { return crystal(stepper); }});
  }
  for (const Stepper stepper : {Stepper::Leapfrog, Stepper::Verlet, Stepper::SemiImplicitEuler}) {
    cases.push_back({.name = std::string("huge viscosity, ") + nameOf(stepper),
                     .setUp = "54 balls between walls, law 18 with kt a hundred times the default, 0.6 s",
                     .expectation = "kinetic energy and energy made in the last half below 1e-3 of m g R",
                     .highest = 1e-3,
                     .highestEnergyRatio = 1.001,
                     .run = [=] { return bedOfHugeViscosity(stepper); }});
  }
  cases.push_back(
      {.name = "sub-steps far too long",
       .setUp = "54 balls that overlap a little, E = 1e9 Pa, Verlet at a fixed 1e-3 s",
       .expectation = "says that IntegratorDef::fixedSubStep is why; what is left of the scene is finite",
       .lowest = 1.0,
       .highest = 1.0,
       .wantedFlags = StepFlag::FixedSubStepTooLong | StepFlag::DeepOverlap | StepFlag::GrainsQuarantined,
       .isQuick = true,
       .run = tooLongSteps});
}

}  // namespace

std::vector<std::string> complaints(const Case& stressCase, const Outcome& outcome) {
  std::vector<std::string> lines;
  if (!(outcome.measured >= stressCase.lowest && outcome.measured <= stressCase.highest)) {
    lines.push_back(text("measured %.6g", outcome.measured) + text(", allowed %.6g", stressCase.lowest) +
                    text(" to %.6g", stressCase.highest));
  }
  if (outcome.notFinite > 0) lines.push_back(text("%.0f not finite", static_cast<double>(outcome.notFinite)));
  if (outcome.escaped > 0) lines.push_back(text("%.0f escaped", static_cast<double>(outcome.escaped)));
  if (stressCase.highestEnergyRatio > 0.0 && !(outcome.energyRatio <= stressCase.highestEnergyRatio)) {
    lines.push_back(text("energy grew to %.6g of the start", outcome.energyRatio));
  }
  if (outcome.flags != stressCase.wantedFlags) {
    const std::string said = describe(outcome.flags);
    lines.push_back("reported: " + (said.empty() ? std::string("nothing") : said));
  }
  return lines;
}

std::vector<Case> allCases() {
  std::vector<Case> cases;
  addSteps(cases);
  addMasses(cases);
  addStarts(cases);
  addSpeeds(cases);
  addBeds(cases);
  return cases;
}

}  // namespace granular::stress

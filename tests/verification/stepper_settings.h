// SPDX-License-Identifier: MIT
// Every stepper, as the cases that hold for all of them run it.
#pragma once

#include <string>
#include <vector>

#include "granular/dynamics/integrator.h"

namespace granular::verification {

struct StepperSettings {
  std::string name;
  IntegratorDef integrator;
};

/// All of them. `fixedSubStep`, s: of those without error control; `tolerance`: of the others.
inline std::vector<StepperSettings> everyStepper(double fixedSubStep, double tolerance = 1e-4) {
  return {{"rkf45", {.stepper = Stepper::Rkf45, .tolerance = tolerance}},
          // Of second order: shorter sub-steps.
          {"leapfrog", {.stepper = Stepper::Leapfrog, .tolerance = tolerance, .contactTimeFraction = 0.03}},
          {"verlet", {.stepper = Stepper::Verlet, .fixedSubStep = fixedSubStep}},
          {"semi-implicit-euler", {.stepper = Stepper::SemiImplicitEuler, .fixedSubStep = fixedSubStep}},
          {"bogacki-shampine", {.stepper = Stepper::BogackiShampine, .tolerance = tolerance}}};
}

}  // namespace granular::verification

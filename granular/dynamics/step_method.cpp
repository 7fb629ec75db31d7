// SPDX-License-Identifier: MIT
#include "granular/dynamics/step_method.h"

#include "granular/dynamics/kick_drift.h"
#include "granular/dynamics/runge_kutta.h"

namespace granular {

void StepMethod::start(Equations& equations, const Moment& at, const std::vector<double>& y) {
  forget();
  firstRate_.resize(rateSize(equations, y));
  Moment moment = at;
  moment.poseRates = needsPoseRates();
  moment.memoryRates = needsMemoryRates();
  equations.evaluate(moment, y, firstRate_);
}

std::unique_ptr<StepMethod> makeStepMethod(Stepper stepper) {
  switch (stepper) {
    case Stepper::Rkf45:
      return std::make_unique<RungeKutta>(kRkf45);
    case Stepper::BogackiShampine:
      return std::make_unique<RungeKutta>(kBogackiShampine);
    case Stepper::Leapfrog:
      return std::make_unique<KickDrift>(kLeapfrog);
    case Stepper::Verlet:
      return std::make_unique<KickDrift>(kVerlet);
    case Stepper::SemiImplicitEuler:
      return std::make_unique<KickDrift>(kSemiImplicitEuler);
  }
  return nullptr;
}

}  // namespace granular

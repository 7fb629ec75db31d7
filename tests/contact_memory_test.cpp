// SPDX-License-Identifier: MIT
// The displacement that a contact remembers (Bell 2005, eq. 19), while its spring stiffens with the overlap.
#include <gtest/gtest.h>

#include <cmath>

#include "granular/contact/contact_kernel.h"
#include "granular/contact/hertz_viscoelastic.h"
#include "granular/contact/static_friction.h"

namespace granular {
namespace {

constexpr double kApproach = 0.01, kSlip = 0.02;  // m/s

/// Hertz, elastic; friction that never gives way.
ContactMemory memoryAt(double overlap, const Vector3& remembered, double stiffnessBefore) {
  ContactGeometry g;
  g.xi = overlap;
  g.N = Vector3::UnitX();
  g.V = {kApproach, kSlip, 0.0};
  g.stiffnessBefore = stiffnessBefore;
  ContactMemory memory;
  contactResult<HertzViscoelastic, StaticFriction>({.kr = 1e6}, {.mu = 1e6, .stiffnessRatio = 0.8}, g,
                                                   remembered, &memory);
  return memory;
}

TEST(ContactMemory, OfAContactPressedDeeperIsInStepWithTheClosedForm) {
  // xi = v t, kt ~ xi^(1/2), D' = Vt - D / (2 t): D = 2/3 Vt t, whatever came before. In one step by
  // Simpson's rule, which is off by (1/6)(4 sqrt(1/2) + 1) / (2/3) - 1 = -.043 for a root.
  for (const double begun : {1e-12, 1e-9, 1e-7}) {  // overlap when it was last accepted, m
    const double reached = 1e-5, step = (reached - begun) / kApproach;
    const ContactMemory start = memoryAt(begun, Vector3::Zero(), 0.0);
    const double before = start.stiffness;
    const Vector3 integrated =
        step / 6.0 *
        (start.nextRate + 4.0 * memoryAt(0.5 * (begun + reached), Vector3::Zero(), before).rate +
         memoryAt(reached, Vector3::Zero(), before).rate);
    const double D = memoryAt(reached, integrated, before).displacement.y();
    EXPECT_NEAR(D / (kSlip * step), 2.0 / 3.0, 0.045 * 2.0 / 3.0) << begun;
  }
}

TEST(ContactMemory, OfAContactPressedDeeperKeepsItsForce) {
  // Without slip the force stays while kt doubles: D halves.
  const Vector3 D(0.0, 1e-7, 0.0);
  const double before = memoryAt(1e-6, D, 0.0).stiffness;
  ContactGeometry g;
  g.xi = 4e-6;
  g.N = Vector3::UnitX();
  g.V = {kApproach, 0.0, 0.0};
  g.stiffnessBefore = before;
  ContactMemory memory;
  const ContactResult result = contactResult<HertzViscoelastic, StaticFriction>(
      {.kr = 1e6}, {.mu = 1e6, .stiffnessRatio = 0.8}, g, D, &memory);
  EXPECT_NEAR(memory.displacement.y(), 0.5 * D.y(), 1e-12 * D.y());
  EXPECT_NEAR(-result.force.y(), before * D.y(), 1e-12 * before * D.y());
}

TEST(ContactMemory, OfAContactThatLetsGoKeepsItsDisplacement) {
  const Vector3 D(0.0, 1e-7, 0.0);
  const double before = memoryAt(4e-6, D, 0.0).stiffness;
  EXPECT_NEAR(memoryAt(1e-6, D, before).displacement.y(), D.y(), 1e-12 * D.y());
}

}  // namespace
}  // namespace granular

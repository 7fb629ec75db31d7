// SPDX-License-Identifier: MIT
// The kernels for every processor that the library is compiled for.
#include "granular/system/detail/contact_kernels_body.h"
#include "granular/system/detail/drift_kernel_body.h"
#include "granular/system/detail/motion_kernels_body.h"
#include "granular/system/detail/row_kernels_body.h"

namespace granular::detail {

static constexpr ForceKernels kForces = allKernels<Pack>(NormalLaws{});

extern const ForceKernels kBaselineMixedForces;
extern const ContactKernels kBaselineKernels;
const ContactKernels kBaselineKernels = {.processor = "baseline",
                                         .findNear = granular::findNear,
                                         .drift = driftOwners,
                                         .carry = carryPositions,
                                         .placeSpheres = placeSpheres,
                                         .findContacts = findContacts,
                                         .addWrenches = addWrenches,
                                         .accelerateGrains = accelerateGrains,
                                         .errorsOfSpheres = errorsOfSpheres,
                                         .forces = &kForces,
                                         .mixedForces = &kBaselineMixedForces};

}  // namespace granular::detail

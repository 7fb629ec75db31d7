// SPDX-License-Identifier: MIT
// The kernels for processors with AVX-512.
#include "granular/system/detail/contact_kernels_body.h"
#include "granular/system/detail/drift_kernel_body.h"
#include "granular/system/detail/motion_kernels_body.h"
#include "granular/system/detail/row_kernels_body.h"
#include "granular/system/detail/search_kernel_body.h"

namespace granular::detail {

static constexpr ForceKernels kForces = allKernels<Pack>(NormalLaws{});

extern const ForceKernels kAvx512MixedForces;
extern const ContactKernels kAvx512Kernels;
const ContactKernels kAvx512Kernels = {.processor = "avx512",
                                       .findNear = findNearInPacks,
                                       .drift = driftOwners,
                                       .carry = carryPositions,
                                       .placeSpheres = placeSpheres,
                                       .findContacts = findContacts,
                                       .addWrenches = addWrenches,
                                       .accelerateGrains = accelerateGrains,
                                       .errorsOfSpheres = errorsOfSpheres,
                                       .forces = &kForces,
                                       .mixedForces = &kAvx512MixedForces};

}  // namespace granular::detail

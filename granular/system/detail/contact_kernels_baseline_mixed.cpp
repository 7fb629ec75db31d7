// SPDX-License-Identifier: MIT
// The kernels of contact forces in single precision (ContactPrecision::Mixed) for every processor that the
// library is compiled for.
#include "granular/system/detail/contact_kernels_body.h"

namespace granular::detail {

extern const ForceKernels kBaselineMixedForces;
const ForceKernels kBaselineMixedForces = allKernels<FloatPack>(NormalLaws{});

}  // namespace granular::detail

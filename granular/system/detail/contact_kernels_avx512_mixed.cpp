// SPDX-License-Identifier: MIT
// The kernels of contact forces in single precision (ContactPrecision::Mixed) for processors with AVX-512.
#include "granular/system/detail/contact_kernels_body.h"

namespace granular::detail {

extern const ForceKernels kAvx512MixedForces;
const ForceKernels kAvx512MixedForces = allKernels<FloatPack>(NormalLaws{});

}  // namespace granular::detail

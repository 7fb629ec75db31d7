// SPDX-License-Identifier: MIT
// The kernels of contact forces in single precision (ContactPrecision::Mixed) for processors with AVX2.
#include "granular/system/detail/contact_kernels_body.h"

namespace granular::detail {

extern const ForceKernels kAvx2MixedForces;
const ForceKernels kAvx2MixedForces = allKernels<FloatPack>(NormalLaws{});

}  // namespace granular::detail

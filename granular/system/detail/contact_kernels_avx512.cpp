// SPDX-License-Identifier: MIT
// The kernels for processors with AVX512.
#include "granular/system/detail/contact_kernels_body.h"

namespace granular::detail {

extern const ContactKernels kAvx512Kernels;
const ContactKernels kAvx512Kernels = {"avx512", findContacts, sumWrenches, allKernels(NormalLaws{})};

}  // namespace granular::detail

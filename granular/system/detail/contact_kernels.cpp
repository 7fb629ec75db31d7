// SPDX-License-Identifier: MIT
#include "granular/system/detail/contact_kernels.h"

#include <cstdlib>
#include <string_view>
#include <vector>

namespace granular::detail {

extern const ContactKernels kBaselineKernels;
#ifdef GRANULAR_DISPATCH
extern const ContactKernels kAvx2Kernels, kAvx512Kernels;
#endif

std::span<const ContactKernels* const> availableContactKernels() {
  static const std::vector<const ContactKernels*> kAvailable = [] {
    std::vector<const ContactKernels*> available = {&kBaselineKernels};
#ifdef GRANULAR_DISPATCH
    if (__builtin_cpu_supports("avx2")) available.push_back(&kAvx2Kernels);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
      available.push_back(&kAvx512Kernels);
    }
#endif
    return available;
  }();
  return kAvailable;
}

const ContactKernels& contactKernels() {
  const std::span<const ContactKernels* const> available = availableContactKernels();
  const char* asked = std::getenv("GRANULAR_PROCESSOR");
  for (const ContactKernels* kernels : available) {
    if (asked != nullptr && std::string_view(kernels->processor) == asked) return *kernels;
  }
  return *available.back();
}

}  // namespace granular::detail

// SPDX-License-Identifier: MIT
// Which particles of a run are near, several at a time; included once by the file for each processor that has
// the instructions.
#pragma once

#include <immintrin.h>

#include <cstdint>

#include "granular/search/candidate_list.h"

namespace granular::detail {
namespace {

/// As granular::findNear.
std::uint64_t* findNearInPacks(const SpatialHash& hash, const SpatialHash::Run& run, const Vector3& center,
                               double reach, std::uint64_t tag, std::uint64_t* hits) {
  const double *x = hash.x().data(), *y = hash.y().data(), *z = hash.z().data(), *r = hash.reach().data();
  const std::uint64_t* tags = hash.tag().data();
#ifdef __AVX512F__
  const __m512d cx = _mm512_set1_pd(center.x()), cy = _mm512_set1_pd(center.y()),
                cz = _mm512_set1_pd(center.z()), own = _mm512_set1_pd(reach);
  const __m512i ownTag = _mm512_set1_epi64(static_cast<long long>(tag));
  for (std::int32_t k = run.begin; k < run.end; k += 8) {
    const auto there = static_cast<__mmask8>(run.end - k >= 8 ? 0xff : (1 << (run.end - k)) - 1);
    const auto load = [&](const double* from) { return _mm512_maskz_loadu_pd(there, from + k); };
    const __m512i other = _mm512_maskz_loadu_epi64(there, tags + k);
    const __m512d dx = _mm512_sub_pd(load(x), cx), dy = _mm512_sub_pd(load(y), cy),
                  dz = _mm512_sub_pd(load(z), cz), sum = _mm512_add_pd(own, load(r));
    const __m512d square =
        _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dy, dy)), _mm512_mul_pd(dz, dz));
    const __mmask8 isHigher = _mm512_mask_cmp_epu64_mask(there, other, ownTag, _MM_CMPINT_NLE);
    const __mmask8 isNear = _mm512_mask_cmp_pd_mask(isHigher, square, _mm512_mul_pd(sum, sum), _CMP_LT_OQ);
    _mm512_storeu_si512(hits, _mm512_maskz_compress_epi64(isNear, other));
    hits += __builtin_popcount(isNear);
  }
#else
  const __m256d cx = _mm256_set1_pd(center.x()), cy = _mm256_set1_pd(center.y()),
                cz = _mm256_set1_pd(center.z()), own = _mm256_set1_pd(reach);
  const __m256i ownTag = _mm256_set1_epi64x(static_cast<long long>(tag));  // ranks are positive: tags too
  std::int32_t k = run.begin;
  for (; k + 4 <= run.end; k += 4) {
    const auto load = [&](const double* from) { return _mm256_loadu_pd(from + k); };
    const __m256i other = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(tags + k));
    const __m256d dx = _mm256_sub_pd(load(x), cx), dy = _mm256_sub_pd(load(y), cy),
                  dz = _mm256_sub_pd(load(z), cz), sum = _mm256_add_pd(own, load(r));
    const __m256d square =
        _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy)), _mm256_mul_pd(dz, dz));
    const __m256d isHigher = _mm256_castsi256_pd(_mm256_cmpgt_epi64(other, ownTag));
    const int isNear = _mm256_movemask_pd(
        _mm256_and_pd(isHigher, _mm256_cmp_pd(square, _mm256_mul_pd(sum, sum), _CMP_LT_OQ)));
    for (int lane = 0; lane < 4; ++lane) {
      *hits = tags[k + lane];
      hits += isNear >> lane & 1;
    }
  }
  if (k < run.end) hits = granular::findNear(hash, {k, run.end}, center, reach, tag, hits);
#endif
  return hits;
}

}  // namespace
}  // namespace granular::detail

// SPDX-License-Identifier: MIT
// Which candidates overlap, and what the forces of contacts add up to; included once by the file for each
// processor.
#pragma once

#include <algorithm>
#include <cstdint>

#include "granular/system/detail/contact_kernels.h"
#include "granular/system/detail/pack_rows.h"

namespace granular::detail {
namespace {

using FourIntegers = std::int32_t __attribute__((vector_size(16)));
FourIntegers loadFour(const std::int32_t* from) {
  FourIntegers four;
  std::memcpy(&four, from, sizeof(four));
  return four;
}

/// Tests candidates, four side by side where it can. kSlotsArePlaces: of what moves. Everything by value:
/// what is written could be any number, so that numbers elsewhere would be read again and again.
template <bool kSlotsArePlaces>
class CandidateTest {
 public:
  CandidateTest(const ContactArrays& arrays, const CandidateSpan& candidates, Contact* contacts,
                std::int32_t n)
      : particles_(arrays.particles),
        owners_(arrays.owners),
        placeOfSlot_(arrays.placeOfSlot),
        row_(candidates.row),
        partner_(candidates.partner),
        particleCount_(arrays.particleCount),
        contacts_(contacts),
        count_(n) {}

  /// Candidates [c, last) until one is on a surface; returns that one, or last.
  std::int32_t run(std::int32_t c, std::int32_t last) {
#ifdef __AVX512F__
    for (; c + 8 <= last; c += 8) {
      if (_mm256_cmpge_epi32_mask(loadEight(partner_ + c), _mm256_set1_epi32(particleCount_)) != 0) break;
      testEight(c);
    }
#endif
    for (; c + 4 <= last; c += 4) {
      const FourIntegers partner = loadFour(partner_ + c), surface = partner >= particleCount_;
      if ((surface[0] | surface[1] | surface[2] | surface[3]) != 0) break;
      testFour(c, partner);
    }
    for (; c < last && partner_[c] < particleCount_; ++c) {
      const Four q = squares(row_[c], partner_[c]);
      put(-std::int32_t{q[0] + q[1] + q[2] < q[3]}, FourIntegers{row_[c], partner_[c], c, 0}, partner_[c]);
    }
    return c;
  }
  std::int32_t count() const {
    return count_;
  }

 private:
  /// Squares of the way between centres, by axis, and of the sum of radii.
  Four squares(std::int32_t row, std::int32_t partner) const {
    // (x1, y1, z1, -R1), so that one difference gives the way and the sum.
    const Four plusOrMinus = {1.0, 1.0, 1.0, -1.0};
    const Four d = loadFour(&particles_[partner].x) - plusOrMinus * loadFour(&particles_[row].x);
    return d * d;
  }
#ifdef __AVX512F__
  static __m256i loadEight(const std::int32_t* from) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  }
  using Eight = double __attribute__((vector_size(64)));
  void testEight(std::int32_t c) {
    const auto squaresAt = [&](int k) { return squares(row_[c + k], partner_[c + k]); };
    const FourPacks<Eight> q = registersOf<Eight>(squaresAt);
    const __mmask8 touching = _mm512_cmp_pd_mask(static_cast<__m512d>(q.first + q.second + q.third),
                                                 static_cast<__m512d>(q.fourth), _CMP_LT_OQ);
    for (int k = 0; k < 8; ++k) prefetchOwner(partner_[c + k]);
    // Those that touch side by side, then as rows of Contact; what lies behind them is written over.
    const __m256i index = _mm256_add_epi32(_mm256_set1_epi32(c), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256i row = _mm256_maskz_compress_epi32(touching, loadEight(row_ + c));
    const __m256i partner = _mm256_maskz_compress_epi32(touching, loadEight(partner_ + c));
    const __m256i candidate = _mm256_maskz_compress_epi32(touching, index), none = _mm256_setzero_si256();
    const __m256i ends0 = _mm256_unpacklo_epi32(row, partner), ends1 = _mm256_unpackhi_epi32(row, partner);
    const __m256i rest0 = _mm256_unpacklo_epi32(candidate, none),
                  rest1 = _mm256_unpackhi_epi32(candidate, none);
    const __m256i a = _mm256_unpacklo_epi64(ends0, rest0),
                  b = _mm256_unpackhi_epi64(ends0, rest0);  // 0 4, 1 5
    const __m256i d = _mm256_unpacklo_epi64(ends1, rest1),
                  e = _mm256_unpackhi_epi64(ends1, rest1);  // 2 6, 3 7
    auto* to = reinterpret_cast<__m256i*>(contacts_ + count_);
    _mm256_storeu_si256(to, _mm256_permute2x128_si256(a, b, 0x20));
    _mm256_storeu_si256(to + 1, _mm256_permute2x128_si256(d, e, 0x20));
    _mm256_storeu_si256(to + 2, _mm256_permute2x128_si256(a, b, 0x31));
    _mm256_storeu_si256(to + 3, _mm256_permute2x128_si256(d, e, 0x31));
    count_ += __builtin_popcount(touching);
  }
#endif
  void testFour(std::int32_t c, const FourIntegers& partner) {
    const FourIntegers row = loadFour(row_ + c);
    const FourPacks<Four> q = transposed<Four>(squares(row[0], partner[0]), squares(row[1], partner[1]),
                                               squares(row[2], partner[2]), squares(row[3], partner[3]));
    const auto touches = __builtin_convertvector(q.first + q.second + q.third < q.fourth, FourIntegers);
    const FourIntegers index = c + FourIntegers{0, 1, 2, 3}, none = {};
    const FourIntegers ends01 = __builtin_shufflevector(row, partner, 0, 4, 1, 5),
                       ends23 = __builtin_shufflevector(row, partner, 2, 6, 3, 7),
                       rest01 = __builtin_shufflevector(index, none, 0, 4, 1, 5),
                       rest23 = __builtin_shufflevector(index, none, 2, 6, 3, 7);
    put(touches[0], __builtin_shufflevector(ends01, rest01, 0, 1, 4, 5), partner[0]);
    put(touches[1], __builtin_shufflevector(ends01, rest01, 2, 3, 6, 7), partner[1]);
    put(touches[2], __builtin_shufflevector(ends23, rest23, 0, 1, 4, 5), partner[2]);
    put(touches[3], __builtin_shufflevector(ends23, rest23, 2, 3, 6, 7), partner[3]);
  }
  /// A Contact, in one piece. No branch on who touches (-1, else 0): half of the candidates do, and no
  /// processor guesses which. What is written of the others is written over. The forces will want the owner.
  void put(std::int32_t touches, const FourIntegers& contact, std::int32_t partner) {
    std::memcpy(&contacts_[count_].slot1, &contact, sizeof(contact));
    count_ -= touches;
    prefetchOwner(partner);
  }
  void prefetchOwner(std::int32_t partner) const {
    __builtin_prefetch(owners_ + (kSlotsArePlaces ? partner : placeOfSlot_[partner]));
  }

  const ParticleRow* particles_;
  const OwnerRow* owners_;
  const std::int32_t *placeOfSlot_, *row_, *partner_;
  std::int32_t particleCount_;
  Contact* contacts_;
  std::int32_t count_;
};

template <bool kSlotsArePlaces>
std::int32_t findContactsOf(const ContactArrays& arrays, const CandidateSpan& candidates, std::int32_t begin,
                            std::int32_t end, Contact* contacts, std::int32_t& n) {
  CandidateTest<kSlotsArePlaces> test(arrays, candidates, contacts, n);
  const std::int32_t done = test.run(begin, end);
  n = test.count();
  return done;
}

GRANULAR_KERNEL std::int32_t findContacts(const ContactArrays& arrays, const CandidateSpan& candidates,
                                          std::int32_t begin, std::int32_t end, Contact* contacts,
                                          std::int32_t& n) {
  return arrays.movesOnlySpheres ? findContactsOf<true>(arrays, candidates, begin, end, contacts, n)
                                 : findContactsOf<false>(arrays, candidates, begin, end, contacts, n);
}

/// kSlotsArePatches: of what moves.
template <bool kSlotsArePatches>
void addWrenchesOf(const ContactArrays& arrays, const ContactChunk& chunk, std::int32_t firstPatch,
                   std::int32_t patchCount, PatchWrench* sums) {
  const std::int32_t* patchOfSlot = arrays.patchOfSlot;
  const Contact* contacts = chunk.contacts;
  const ContactForce* forces = chunk.forces;
  const VectorRow* torques = chunk.torques;
  const std::int32_t* position = chunk.position;
  const std::int32_t surfaceCount = chunk.surfaceCount, shift = chunk.shift;
  const auto most = static_cast<std::uint32_t>(patchCount);
  const auto sumOf = [=](std::int32_t slot) -> PatchWrench& {
    const std::int32_t patch = kSlotsArePatches ? slot : patchOfSlot[slot];
    return sums[std::min(static_cast<std::uint32_t>(patch - firstPatch), most)];
  };
  const std::int32_t count = chunk.count;
  for (std::int32_t n = 0; n < count; ++n) {
    const std::int32_t at = position[n];
    PatchWrench &first = sumOf(contacts[n].slot1), &second = sumOf(contacts[n].slot2);
    const Four force = loadFour(forces[at].force.data());  // and heat, which particle 1 has all of
    const std::int32_t torqueAt = at - (at >= surfaceCount ? shift : 0);
    const Four torque1 = loadFour(torques[torqueAt].vector.data()),
               torque2 = loadFour(forces[at].torque.data());
    storeFour(loadFour(first.force.data()) + force, first.force.data());
    storeFour(loadFour(first.torque.data()) + torque1, first.torque.data());
    storeFour(loadFour(second.force.data()) - withFourth(force, Four{}), second.force.data());
    storeFour(loadFour(second.torque.data()) - withFourth(torque2, -torque1), second.torque.data());
  }
}
GRANULAR_KERNEL void addWrenches(const ContactArrays& arrays, const ContactChunk& chunk,
                                 std::int32_t firstPatch, std::int32_t patchCount, PatchWrench* sums) {
  return arrays.movesOnlySpheres ? addWrenchesOf<true>(arrays, chunk, firstPatch, patchCount, sums)
                                 : addWrenchesOf<false>(arrays, chunk, firstPatch, patchCount, sums);
}

}  // namespace
}  // namespace granular::detail

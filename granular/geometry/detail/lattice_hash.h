// SPDX-License-Identifier: MIT
// A small hash table from places of an integer lattice to indices: blocks of the distance band, crossed edges
// of the tetrahedra, cells of a point grid. Open addressing with linear probing; entries are never removed.
#pragma once

#include <cstdint>
#include <vector>

namespace granular::detail {

// Lattice coordinates lie in [-kLatticeReach, kLatticeReach): 20 bits each leave 4 bits of a key for the
// caller.
constexpr std::int32_t kLatticeReach = 1 << 19;

inline std::uint64_t latticeKey(std::int32_t i, std::int32_t j, std::int32_t k) {
  const auto part = [](std::int32_t c) { return static_cast<std::uint64_t>(c + kLatticeReach) & 0xfffffu; };
  return part(i) << 40 | part(j) << 20 | part(k);
}

class LatticeHash {
 public:
  explicit LatticeHash(std::size_t expected = 16) {
    std::size_t slots = 32;
    while (slots < 2 * expected) slots *= 2;
    slots_.resize(slots);
  }

  /// Value of the key, or -1.
  std::int32_t find(std::uint64_t key) const { return slots_[slotOf(slots_, key)].value; }

  /// Value of the key; `value` (>= 0) is stored first if the key is new.
  std::int32_t findOrInsert(std::uint64_t key, std::int32_t value) {
    Slot* slot = &slots_[slotOf(slots_, key)];
    if (slot->value >= 0) return slot->value;
    *slot = {key, value};
    if (2 * ++used_ > slots_.size()) grow();
    return value;
  }

  std::size_t size() const { return used_; }
  std::size_t bytes() const { return slots_.size() * sizeof(Slot); }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t value = -1;  // -1: empty
  };

  /// Where the key is, or the empty slot where it belongs.
  static std::size_t slotOf(const std::vector<Slot>& slots, std::uint64_t key) {
    const std::size_t mask = slots.size() - 1;
    std::size_t s =
        (key * 0x9e3779b97f4a7c15ull >> 24) & mask;  // Fibonacci hashing: the high bits are the mixed ones
    while (slots[s].value >= 0 && slots[s].key != key) s = (s + 1) & mask;
    return s;
  }

  void grow() {
    std::vector<Slot> larger(2 * slots_.size());
    for (const Slot& slot : slots_) {
      if (slot.value >= 0) larger[slotOf(larger, slot.key)] = slot;
    }
    slots_ = std::move(larger);
  }

  std::vector<Slot> slots_;
  std::size_t used_ = 0;
};

}  // namespace granular::detail

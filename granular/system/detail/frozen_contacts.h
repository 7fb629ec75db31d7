// SPDX-License-Identifier: MIT
// Contacts between two owners that do not move, kept as they were. Each is in the lists of both its owners,
// so that what wakes, falls asleep or goes costs what it touches, however many sleep. What is summed of one
// owner's contacts is summed in the order of whom it touches: the same bits, whatever came and went before.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "granular/base/pose.h"
#include "granular/system/granular_system.h"

namespace granular::detail {

/// GrainId::index or BodyId::index, and which of them.
struct OwnerKey {
  OwnerKind kind = OwnerKind::Grain;
  std::int32_t index = -1;
  friend auto operator<=>(const OwnerKey&, const OwnerKey&) = default;
};

/// A sum from which terms are taken out again. What each addition rounds off is carried along (Neumaier
/// 1974).
class RunningSum {
 public:
  void add(double term);
  double value() const { return sum_ + rounding_; }

 private:
  double sum_ = 0.0, rounding_ = 0.0;
};

class FrozenContacts {
 public:
  /// A contact as one of its owners has it.
  struct Side {
    const FrozenContact* contact;
    int side;  ///< 0: its first owner
    OwnerKey other() const { return {contact->memory.kind[1 - side], contact->memory.index[1 - side]}; }
    Vector3 force() const { return side == 0 ? contact->force : Vector3(-contact->force); }  ///< on it, N
  };

  std::int64_t size() const { return std::ssize(rows_) - std::ssize(free_); }
  bool empty() const { return size() == 0; }
  void add(const FrozenContact& contact);
  /// All contacts of this owner, which are frozen no longer.
  std::vector<FrozenContact> takeOut(OwnerKey owner);
  /// Its contacts, in the order of whom it touches; good until the next change or call.
  const std::vector<Side>& of(OwnerKey owner) const;
  /// On a body about `center`.
  const Wrench& wrenchOn(std::int32_t body, const Vector3& center);
  /// In the order of first, then second owners.
  std::vector<FrozenContact> all() const;

  double elastic() const { return elastic_.value(); }        ///< J
  double overlapSum() const { return overlapSum_.value(); }  ///< in smaller radii of the pairs
  double largestOverlap();                                   ///< the same

 private:
  // A link is 2 row + side. -1: none.
  struct Row {
    FrozenContact contact;
    std::array<std::int32_t, 2> next{-1, -1}, previous{-1, -1};
    bool isUsed = false;
  };
  std::int32_t firstOf(OwnerKey owner) const;
  std::int32_t& headOf(OwnerKey owner);
  std::int32_t& nextOf(std::int32_t link) { return rows_[link / 2].next[link % 2]; }
  std::int32_t& previousOf(std::int32_t link) { return rows_[link / 2].previous[link % 2]; }
  static OwnerKey ownerOf(const FrozenContact& contact, int side) {
    return {contact.memory.kind[side], contact.memory.index[side]};
  }
  void noteChange(OwnerKey owner);
  void count(const FrozenContact& contact, double sign);

  std::vector<Row> rows_;
  std::vector<std::int32_t> free_;
  std::array<std::vector<std::int32_t>, 2> heads_;   // links, by kind and index
  std::vector<std::optional<Wrench>> wrenchOfBody_;  // none where it has to be summed
  RunningSum elastic_, overlapSum_;
  std::optional<double> largestOverlap_;  // none where it has to be looked for
  mutable std::vector<Side> sides_;
};

}  // namespace granular::detail

// SPDX-License-Identifier: MIT
#include "granular/system/detail/frozen_contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "granular/contact/contact_kernel.h"

namespace granular::detail {

void RunningSum::add(double term) {
  const double sum = sum_ + term;
  rounding_ += std::abs(sum_) >= std::abs(term) ? (sum_ - sum) + term : (term - sum) + sum_;
  sum_ = sum;
}

std::int32_t FrozenContacts::firstOf(OwnerKey owner) const {
  const std::vector<std::int32_t>& heads = heads_[static_cast<int>(owner.kind)];
  return owner.index < std::ssize(heads) ? heads[owner.index] : -1;
}

std::int32_t& FrozenContacts::headOf(OwnerKey owner) {
  std::vector<std::int32_t>& heads = heads_[static_cast<int>(owner.kind)];
  if (owner.index >= std::ssize(heads)) heads.resize(owner.index + 1, -1);
  return heads[owner.index];
}

void FrozenContacts::noteChange(OwnerKey owner) {
  if (owner.kind == OwnerKind::Body && owner.index < std::ssize(wrenchOfBody_)) {
    wrenchOfBody_[owner.index].reset();
  }
}

void FrozenContacts::count(const FrozenContact& contact, double sign) {
  const RememberedContact& c = contact.memory;
  elastic_.add(sign * (contact.normalEnergy + memoryEnergy(c.stiffness, c.displacement)));
  overlapSum_.add(sign * contact.relativeOverlap);
}

void FrozenContacts::add(const FrozenContact& contact) {
  if (free_.empty()) {
    free_.push_back(static_cast<std::int32_t>(rows_.size()));
    rows_.emplace_back();
  }
  const std::int32_t at = free_.back();
  free_.pop_back();
  rows_[at] = {.contact = contact, .isUsed = true};
  for (int side = 0; side < 2; ++side) {
    const std::int32_t link = 2 * at + side;
    std::int32_t& head = headOf(ownerOf(contact, side));
    nextOf(link) = head;
    if (head >= 0) previousOf(head) = link;
    head = link;
    noteChange(ownerOf(contact, side));
  }
  count(contact, 1.0);
  if (largestOverlap_) largestOverlap_ = std::max(*largestOverlap_, contact.relativeOverlap);
}

std::vector<FrozenContact> FrozenContacts::takeOut(OwnerKey owner) {
  std::vector<FrozenContact> taken;
  for (std::int32_t first = firstOf(owner); first >= 0; first = firstOf(owner)) {
    const std::int32_t at = first / 2;
    const FrozenContact& contact = taken.emplace_back(rows_[at].contact);
    for (const std::int32_t link : {2 * at, 2 * at + 1}) {
      const std::int32_t next = nextOf(link), previous = previousOf(link);
      if (next >= 0) previousOf(next) = previous;
      (previous >= 0 ? nextOf(previous) : headOf(ownerOf(contact, link % 2))) = next;
      noteChange(ownerOf(contact, link % 2));
    }
    count(contact, -1.0);
    if (largestOverlap_ && contact.relativeOverlap >= *largestOverlap_) largestOverlap_.reset();
    rows_[at] = {};
    free_.push_back(at);
  }
  if (empty()) elastic_ = overlapSum_ = {};
  return taken;
}

const std::vector<FrozenContacts::Side>& FrozenContacts::of(OwnerKey owner) const {
  sides_.clear();
  for (std::int32_t link = firstOf(owner); link >= 0; link = rows_[link / 2].next[link % 2]) {
    sides_.push_back({&rows_[link / 2].contact, link % 2});
  }
  const auto place = [](const Side& at) {
    const std::int32_t* local = at.contact->memory.local;
    return std::tuple(at.other(), local[at.side], local[1 - at.side]);
  };
  std::sort(sides_.begin(), sides_.end(), [&](const Side& a, const Side& b) { return place(a) < place(b); });
  return sides_;
}

const Wrench& FrozenContacts::wrenchOn(std::int32_t body, const Vector3& center) {
  if (body >= std::ssize(wrenchOfBody_)) wrenchOfBody_.resize(body + 1);
  std::optional<Wrench>& sum = wrenchOfBody_[body];
  if (sum) return *sum;
  sum.emplace();
  for (const Side& at : of({OwnerKind::Body, body})) {
    sum->force += at.force();
    sum->torque += (at.contact->point - center).cross(at.force());
  }
  return *sum;
}

std::vector<FrozenContact> FrozenContacts::all() const {
  std::vector<FrozenContact> contacts;
  for (const Row& row : rows_) {
    if (row.isUsed) contacts.push_back(row.contact);
  }
  const auto place = [](const FrozenContact& contact) {
    const std::int32_t* local = contact.memory.local;
    return std::tuple(ownerOf(contact, 0), local[0], ownerOf(contact, 1), local[1]);
  };
  std::sort(contacts.begin(), contacts.end(),
            [&](const FrozenContact& a, const FrozenContact& b) { return place(a) < place(b); });
  return contacts;
}

double FrozenContacts::largestOverlap() {
  if (!largestOverlap_) {
    largestOverlap_ = 0.0;
    for (const Row& row : rows_) {
      largestOverlap_ = std::max(*largestOverlap_, row.contact.relativeOverlap);
    }
  }
  return *largestOverlap_;
}

}  // namespace granular::detail

// SPDX-License-Identifier: MIT
// Room for arrays that have an entry for every particle, candidate or contact. std::vector doubles what it
// has whenever it is too small, and keeps the old array until the new one is filled: of arrays that make up
// most of what a program holds that is up to three times too much.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace granular {

/// Room for so many entries: an eighth more than asked for where there is too little, so that arrays that
/// grow a little now and then do not move every time.
template <class T>
void makeRoom(std::vector<T>& entries, std::size_t size) {
  if (size > entries.capacity()) entries.reserve(size + size / 8);
}

/// Makes them so many. What they were is of no use any more, nor is what they are: the caller fills them.
template <class T>
void resizeAnew(std::vector<T>& entries, std::size_t size) {
  if (size > entries.capacity()) std::vector<T>().swap(entries);
  makeRoom(entries, size);
  entries.resize(size);
}

}  // namespace granular

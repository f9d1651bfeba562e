// Which components of a product share a table, and where a packed product state keeps the state of each.
#pragma once

#include "explore.hpp"

namespace thenar {

// Neighbouring small components share one table: one look-up instead of many.
struct Group {
  std::vector<u32> members;  // components
  u32 word = 0, shift = 0, bits = 0;
};

struct Packing {
  Layout layout;
  std::vector<Group> groups;
};

// Components that share events come together; no group crosses a word.
Packing pack(const std::vector<Component>& components, u64 n_events);

}  // namespace thenar

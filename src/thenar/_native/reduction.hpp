// Supervisor reduction: few cells of states that can stand for one another.
#pragma once

#include "common.hpp"

namespace thenar {

// What a supervisor must say where: `moves` are its transitions in the closed loop, all states reachable, the first one
// initial; disabled[disabled_offsets[x] .. disabled_offsets[x + 1]] are the events that x must disable.
struct Duties {
  Graph moves;
  u64 n_events;
  const i64* disabled_offsets;
  const i32* disabled;
  const u8* mark;  // 0: it does not matter; 1: must be marked; 2: must not be
};

struct Cells {
  std::vector<i32> cell;  // of each state, numbered by their first states
  u64 lower_bound;        // no control cover has fewer cells
};

Cells reduce(const Duties& duties, Ticker& ticker);

}  // namespace thenar

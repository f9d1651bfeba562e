// Kernels on one automaton: distances, shortest paths, minimisation, projection.
#pragma once

#include "common.hpp"

namespace thenar {

// (n_states) length of a shortest path to a state of `goal`; -1 where there is none.
std::vector<i32> distance_to(const Graph& g, const u8* goal, Ticker& ticker);

// The transitions of a shortest path from `initial` to a state of `goal`; false if there is none.
bool shortest_path(const Graph& g, i64 initial, const u8* goal, Ticker& ticker, std::vector<i64>& transitions);

// (n_states) block of each state in the coarsest partition that keeps the marked and the closed behaviour.
std::vector<i32> minimize(const Graph& g, i64 n_events, const u8* marked, Ticker& ticker);

struct Projection {
  std::vector<i64> offsets, member_offsets, members;
  std::vector<i32> events, targets;
  std::vector<u8> marked;
};

// The subset construction with the events of `hidden` erased; states numbered breadth-first.
Projection project(const Graph& g, i64 n_events, i64 initial, const u8* marked, const u8* hidden, Ticker& ticker);

}  // namespace thenar

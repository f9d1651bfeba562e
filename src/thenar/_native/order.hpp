// Orders of variables in which those that depend on each other stand together.
#pragma once

#include "common.hpp"

namespace thenar {

// Edge k joins members[offsets[k]] .. members[offsets[k + 1] - 1], without repetition.
struct Hypergraph {
  u32 n_vertices;
  std::vector<i64> offsets;
  std::vector<u32> members;
  u64 n_edges() const { return offsets.size() - 1; }
};

using Order = std::vector<u32>;  // the vertices, first one first

// Sum over the edges of the distance between their first and last member.
double total_span(const Hypergraph& g, const Order& order);
// Sum over the edges of span times how far from the end they reach, both as shares (weighted event span).
double weighted_span(const Hypergraph& g, const Order& order);

Order force(const Hypergraph& g, Order order, Ticker& ticker);
Order cuthill_mckee(const Hypergraph& g);
Order sloan(const Hypergraph& g);
Order dissection(const Hypergraph& g, Ticker& ticker);
Order sliding_window(const Hypergraph& g, Order order, Ticker& ticker);

}  // namespace thenar

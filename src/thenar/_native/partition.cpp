// Minimisation: the coarsest partition of the states that keeps the marked and the closed behaviour.
#include <algorithm>
#include <numeric>

#include "graph.hpp"

namespace thenar {
namespace {

// A partition of 0 .. n-1 that is refined by marking elements and splitting the marked ones off.
// `I` holds a number below n: half the memory of 64 bits, where 32 are enough.
template <class I>
class Partition {
 public:
  // One block for each class that has an element; `class_of` is below `n_classes`.
  template <class F>
  Partition(u64 n, u64 n_classes, F&& class_of, Ticker& ticker) : elements_(n), place_(n), block_(n) {
    std::vector<u64> begin(n_classes + 1), number(n_classes);
    for (u64 k = 0; k < n; ++k, ticker.tick(1, n, 0)) ++begin[class_of(k) + 1];
    for (u64 c = 0; c < n_classes; ++c) {
      number[c] = n_blocks();
      begin[c + 1] += begin[c];
      if (begin[c] < begin[c + 1]) open(static_cast<I>(begin[c]), static_cast<I>(begin[c + 1]));
    }
    for (u64 k = 0; k < n; ++k, ticker.tick(1, n, 0)) {
      const u64 c = class_of(k), at = begin[c]++;
      elements_[at] = static_cast<I>(k);
      place_[k] = static_cast<I>(at);
      block_[k] = static_cast<I>(number[c]);
    }
  }
  u64 n_blocks() const { return first_.size(); }
  u64 block(u64 element) const { return block_[element]; }
  u64 first(u64 b) const { return first_[b]; }
  u64 end(u64 b) const { return end_[b]; }
  u64 element(u64 place) const { return elements_[place]; }

  void mark(u64 element) {
    const I b = block_[element], from = place_[element], to = first_[b] + marked_[b];
    if (from < to) return;  // marked already
    std::swap(elements_[from], elements_[to]);
    place_[elements_[from]] = from;
    place_[elements_[to]] = to;
    if (!marked_[b]++) touched_.push_back(b);
  }
  // Split each touched block into its marked and its other elements; the smaller part becomes the new block,
  // so that an element changes its block at most log n times. Return the work done.
  u64 split() {
    u64 work = touched_.size();
    for (const I b : touched_) {
      const I cut = first_[b] + marked_[b], fresh = static_cast<I>(n_blocks());
      marked_[b] = 0;
      if (cut == end_[b]) continue;
      if (cut - first_[b] <= end_[b] - cut) {
        open(first_[b], cut);
        first_[b] = cut;
      } else {
        open(cut, end_[b]);
        end_[b] = cut;
      }
      for (I k = first_[fresh]; k < end_[fresh]; ++k) block_[elements_[k]] = fresh;
      work += end_[fresh] - first_[fresh];
    }
    touched_.clear();
    return work;
  }

 private:
  void open(I first, I end) {
    first_.push_back(first);
    end_.push_back(end);
    marked_.push_back(0);
  }
  std::vector<I> elements_, place_, block_, first_, end_, marked_, touched_;
};

// Partition refinement over states and transitions at once, O(m log n).   [Valmari, IPL 112(6), 2012]
// A missing transition is not one to a dead state: the closed behaviour is kept as well.
template <class I>
std::vector<i32> refine(const Graph& g, u64 n_events, const u8* marked, Ticker& ticker) {
  const u64 n = static_cast<u64>(g.n_states), m = static_cast<u64>(g.offsets[n]);
  ticker.check(n, m, ((n + m) * 7 + n + m * 2) * sizeof(I));  // if every block had one element
  std::vector<I> source(m), offsets(n + 2), incoming(m);
  for (u64 q = 0; q < n; ++q) {
    for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k) {
      source[k] = static_cast<I>(q);
      ++offsets[g.targets[k] + 2];
    }
    ticker.tick(static_cast<u64>(g.offsets[q + 1] - g.offsets[q]) + 1, n, m);
  }
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
  for (u64 k = 0; k < m; ++k, ticker.tick(1, n, m)) incoming[offsets[g.targets[k] + 1]++] = static_cast<I>(k);

  Partition<I> states(n, 2, [&](u64 q) { return marked[q] != 0; }, ticker);
  // `edges` groups transitions by event, and by block of their target as far as blocks have been processed. The first
  // block need not be: what leads to it is what leads to no other.
  Partition<I> edges(m, n_events, [&](u64 k) { return static_cast<u64>(g.events[k]); }, ticker);
  for (u64 c = 0, b = 1; c < edges.n_blocks(); ++c) {
    for (u64 k = edges.first(c); k < edges.end(c); ++k, ticker.tick(1, n, m)) states.mark(source[edges.element(k)]);
    ticker.tick(states.split(), n, m);
    for (; b < states.n_blocks(); ++b) {
      for (u64 p = states.first(b); p < states.end(b); ++p) {
        const u64 q = states.element(p);
        for (I k = offsets[q]; k < offsets[q + 1]; ++k) edges.mark(incoming[k]);
        ticker.tick(offsets[q + 1] - offsets[q] + 1, n, m);
      }
      ticker.tick(edges.split(), n, m);
    }
  }
  std::vector<i32> block(n);
  for (u64 q = 0; q < n; ++q) block[q] = static_cast<i32>(states.block(q));
  return block;
}

}  // namespace

std::vector<i32> minimize(const Graph& g, i64 n_events, const u8* marked, Ticker& ticker) {
  const bool small = std::max(g.n_states + 2, g.offsets[g.n_states] + 1) < i64{kNone};
  return (small ? refine<u32> : refine<u64>)(g, static_cast<u64>(n_events), marked, ticker);
}

}  // namespace thenar

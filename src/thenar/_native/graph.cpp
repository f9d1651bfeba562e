#include "graph.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace thenar {

std::vector<i32> distance_to(const Graph& g, const u8* goal, Ticker& ticker) {
  const i64 n = g.n_states, m = g.offsets[n];
  std::vector<i64> offsets(n + 2);
  std::vector<i32> sources(m);
  for (i64 k = 0; k < m; ++k) ++offsets[g.targets[k] + 2];
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
  for (i64 q = 0; q < n; ++q)
    for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k) sources[offsets[g.targets[k] + 1]++] = static_cast<i32>(q);
  std::vector<i32> distance(n, -1), queue;
  for (i64 q = 0; q < n; ++q)
    if (goal[q]) distance[q] = 0, queue.push_back(static_cast<i32>(q));
  for (u64 head = 0; head < queue.size(); ++head) {
    const i32 t = queue[head];
    ticker.tick(offsets[t + 1] - offsets[t] + 1, n, m);
    for (i64 k = offsets[t]; k < offsets[t + 1]; ++k)
      if (distance[sources[k]] < 0) distance[sources[k]] = distance[t] + 1, queue.push_back(sources[k]);
  }
  return distance;
}

bool shortest_path(const Graph& g, i64 initial, const u8* goal, Ticker& ticker, std::vector<i64>& transitions) {
  struct Step {
    i64 state, parent, transition;
  };
  std::vector<Step> queue{{initial, 0, -1}};
  Bits seen(g.n_states);
  seen.set(initial);
  for (u64 head = 0; head < queue.size(); ++head) {
    const i64 q = queue[head].state;
    if (goal[q]) {
      for (u64 i = head; i; i = queue[i].parent) transitions.push_back(queue[i].transition);
      std::reverse(transitions.begin(), transitions.end());
      return true;
    }
    ticker.tick(g.offsets[q + 1] - g.offsets[q] + 1, g.n_states, g.offsets[g.n_states]);
    for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k)
      if (const i64 t = g.targets[k]; !seen[t]) seen.set(t), queue.push_back({t, static_cast<i64>(head), k});
  }
  return false;
}

namespace {

// A partition of 0 .. n-1 that is refined by marking elements and splitting the marked ones off.
class Partition {
 public:
  explicit Partition(i64 n) : elements_(n), place_(n), block_(n), first_{0}, end_{n}, marked_{0} {
    std::iota(elements_.begin(), elements_.end(), 0);
    std::iota(place_.begin(), place_.end(), 0);
    if (n == 0) first_.clear(), end_.clear(), marked_.clear();
  }
  i64 n_blocks() const { return static_cast<i64>(first_.size()); }
  i64 block(i64 element) const { return block_[element]; }
  i64 first(i64 b) const { return first_[b]; }
  i64 end(i64 b) const { return end_[b]; }
  i64 element(i64 place) const { return elements_[place]; }

  void mark(i64 element) {
    const i64 b = block_[element], from = place_[element], to = first_[b] + marked_[b];
    if (from < to) return;  // marked already
    std::swap(elements_[from], elements_[to]);
    place_[elements_[from]] = from;
    place_[elements_[to]] = to;
    if (!marked_[b]++) touched_.push_back(b);
  }
  // Split each touched block into its marked and its other elements; the smaller part becomes the new block.
  void split() {
    for (const i64 b : touched_) {
      const i64 cut = first_[b] + marked_[b];
      marked_[b] = 0;
      if (cut == end_[b]) continue;
      const i64 fresh = n_blocks();
      if (cut - first_[b] <= end_[b] - cut) {
        first_.push_back(first_[b]), end_.push_back(cut), first_[b] = cut;
      } else {
        first_.push_back(cut), end_.push_back(end_[b]), end_[b] = cut;
      }
      marked_.push_back(0);
      for (i64 k = first_[fresh]; k < end_[fresh]; ++k) block_[elements_[k]] = fresh;
    }
    touched_.clear();
  }

 private:
  std::vector<i64> elements_, place_, block_, first_, end_, marked_, touched_;
};

}  // namespace

// Partition refinement over states and transitions at once, O(m log n).   [Valmari, IPL 112(6), 2012]
// A missing transition is not one to a dead state: the closed behaviour is kept as well.
std::vector<i32> minimize(const Graph& g, i64 n_events, const u8* marked, Ticker& ticker) {
  const i64 n = g.n_states, m = g.offsets[n];
  std::vector<i32> source(m);
  for (i64 q = 0; q < n; ++q) std::fill(source.begin() + g.offsets[q], source.begin() + g.offsets[q + 1], static_cast<i32>(q));

  Partition states(n), edges(m);
  for (i64 q = 0; q < n; ++q)
    if (marked[q]) states.mark(q);
  states.split();
  std::vector<std::vector<i64>> by_event(n_events);
  for (i64 k = 0; k < m; ++k) by_event[g.events[k]].push_back(k);
  for (const auto& group : by_event) {
    for (const i64 k : group) edges.mark(k);
    edges.split();
  }
  std::vector<i64> offsets(n + 2), incoming(m);
  for (i64 k = 0; k < m; ++k) ++offsets[g.targets[k] + 2];
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
  for (i64 k = 0; k < m; ++k) incoming[offsets[g.targets[k] + 1]++] = k;

  // `edges` groups transitions by event and by block of their target, as far as blocks have been processed.
  for (i64 c = 0, b = 0; c < edges.n_blocks(); ++c) {
    for (i64 k = edges.first(c); k < edges.end(c); ++k) states.mark(source[edges.element(k)]);
    states.split();
    ticker.tick(edges.end(c) - edges.first(c) + 1, n, m);
    for (; b < states.n_blocks(); ++b) {
      ticker.tick(states.end(b) - states.first(b) + 1, n, m);
      for (i64 p = states.first(b); p < states.end(b); ++p) {
        const i64 q = states.element(p);
        for (i64 k = offsets[q]; k < offsets[q + 1]; ++k) edges.mark(incoming[k]);
      }
      edges.split();
    }
  }
  std::vector<i32> block(n);
  for (i64 q = 0; q < n; ++q) block[q] = static_cast<i32>(states.block(q));
  return block;
}

namespace {

using Set = std::vector<i32>;

struct SetHash {
  u64 operator()(const Set& set) const {
    u64 h = 0xcbf29ce484222325u;  // FNV-1a over the members
    for (const i32 q : set) h = (h ^ static_cast<u64>(q)) * 0x100000001b3u;
    return h ^ h >> 29;
  }
};

}  // namespace

Projection project(const Graph& g, i64 n_events, i64 initial, const u8* marked, const u8* hidden, Ticker& ticker) {
  std::vector<u32> stamp(g.n_states, 0);
  u32 now = 0;
  auto close = [&](Set& set) {  // add what hidden events reach
    ++now;
    for (const i32 q : set) stamp[q] = now;
    for (u64 k = 0; k < set.size(); ++k)
      for (i64 i = g.offsets[set[k]]; i < g.offsets[set[k] + 1]; ++i)
        if (const i32 t = g.targets[i]; hidden[g.events[i]] && stamp[t] != now) stamp[t] = now, set.push_back(t);
    std::sort(set.begin(), set.end());
  };
  Projection out;
  out.offsets.push_back(0);
  out.member_offsets.push_back(0);
  std::unordered_map<Set, i32, SetHash> number;
  std::vector<const Set*> queue;
  auto visit = [&](Set&& set) {
    const auto [place, fresh] = number.try_emplace(std::move(set), static_cast<i32>(number.size()));
    if (fresh) queue.push_back(&place->first);  // keys of an unordered_map stay where they are
    return place->second;
  };
  Set start{static_cast<i32>(initial)};
  close(start);
  visit(std::move(start));
  std::vector<Set> successors(n_events);
  for (u64 head = 0; head < queue.size(); ++head) {
    const Set& set = *queue[head];
    u8 any_marked = 0;
    u64 work = set.size();
    for (const i32 q : set) {
      any_marked |= marked[q];
      for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k, ++work)
        if (!hidden[g.events[k]]) successors[g.events[k]].push_back(g.targets[k]);
    }
    for (i64 e = 0; e < n_events; ++e) {
      Set next = std::move(successors[e]);
      successors[e].clear();
      if (next.empty()) continue;
      std::sort(next.begin(), next.end());
      next.erase(std::unique(next.begin(), next.end()), next.end());
      close(next);
      work += next.size();
      out.events.push_back(static_cast<i32>(e));
      out.targets.push_back(visit(std::move(next)));
    }
    out.members.insert(out.members.end(), set.begin(), set.end());
    out.member_offsets.push_back(static_cast<i64>(out.members.size()));
    out.offsets.push_back(static_cast<i64>(out.events.size()));
    out.marked.push_back(any_marked);
    ticker.check(number.size(), out.events.size(), out.members.size() * (sizeof(i64) + sizeof(i32)));
    ticker.tick(work, number.size(), out.events.size());
  }
  return out;
}

}  // namespace thenar

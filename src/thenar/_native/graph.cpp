#include "graph.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace thenar {

std::vector<i32> distance_to(const Graph& g, const u8* goal, Ticker& ticker) {
  const i64 n = g.n_states, m = g.offsets[n];
  std::vector<i64> offsets(n + 2);
  std::vector<i32> sources(m);
  for (i64 k = 0; k < m; ++k, ticker.tick(1, n, m)) ++offsets[g.targets[k] + 2];
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
  for (i64 q = 0; q < n; ++q) {
    for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k) sources[offsets[g.targets[k] + 1]++] = static_cast<i32>(q);
    ticker.tick(g.offsets[q + 1] - g.offsets[q] + 1, n, m);
  }
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

using Set = std::vector<i32>;

struct SetHash {
  u64 operator()(const Set& set) const {
    u64 h = 0xcbf29ce484222325u;  // FNV-1a over the members
    for (const i32 q : set) h = (h ^ static_cast<u64>(q)) * 0x100000001b3u;
    return h ^ h >> 29;
  }
};

// The subset construction of one automaton: closes sets of states under hidden events, keeps them sorted.
class Subsets {
 public:
  Subsets(const Graph& g, const u8* hidden, Ticker& ticker)
      : g_(g), hidden_(hidden), ticker_(ticker), stamp_(static_cast<u64>(g.n_states)) {}

  // Drop what is there twice, add what hidden events reach, and sort.
  void close(Set& set, u64 n_sets, u64 n_transitions) {
    auto did = [&](u64 steps) { ticker_.tick(steps, n_sets, n_transitions); };
    if (++now_ == 0) std::fill(stamp_.begin(), stamp_.end(), 0), now_ = 1;
    u64 kept = 0;
    for (u64 k = 0; k < set.size(); ++k, did(1))
      if (const i32 q = set[k]; stamp_[q] != now_) stamp_[q] = now_, set[kept++] = q;
    set.resize(kept);
    for (u64 k = 0; k < set.size(); ++k) {
      const i64 begin = g_.offsets[set[k]], end = g_.offsets[set[k] + 1];
      for (i64 i = begin; i < end; ++i)
        if (const i32 t = g_.targets[i]; hidden_[g_.events[i]] && stamp_[t] != now_) stamp_[t] = now_, set.push_back(t);
      did(static_cast<u64>(end - begin) + 1);
    }
    if (set.size() < kManyStates) {
      std::sort(set.begin(), set.end());
      return;
    }
    set.clear();  // a large set is read off the stamps, which can be interrupted
    for (i64 q = 0; q < g_.n_states; ++q, did(1))
      if (stamp_[q] == now_) set.push_back(static_cast<i32>(q));
  }

 private:
  static constexpr u64 kManyStates = 1 << 18;  // milliseconds of sorting
  const Graph& g_;
  const u8* hidden_;
  Ticker& ticker_;
  std::vector<u32> stamp_;  // the last set that had each state
  u32 now_ = 0;
};

}  // namespace

Projection project(const Graph& g, i64 n_events, i64 initial, const u8* marked, const u8* hidden, Ticker& ticker) {
  constexpr u64 kNode = 64;  // bytes of an entry of `number`, about, besides the members
  Subsets subsets(g, hidden, ticker);
  Projection out;
  out.offsets.push_back(0);
  out.member_offsets.push_back(0);
  std::unordered_map<Set, i32, SetHash> number;
  std::vector<const Set*> queue;
  u64 n_members = 0;  // of all sets
  auto visit = [&](Set&& set) {
    const auto [place, fresh] = number.try_emplace(std::move(set), static_cast<i32>(number.size()));
    if (fresh) {
      queue.push_back(&place->first);  // keys of an unordered_map stay where they are
      n_members += place->first.size();
      const u64 bytes = n_members * (sizeof(i64) + sizeof(i32)) + number.size() * kNode +
                        out.events.size() * 2 * sizeof(i32) + static_cast<u64>(g.n_states) * sizeof(u32);
      ticker.check(number.size(), out.events.size(), bytes);
    }
    return place->second;
  };
  Set start{static_cast<i32>(initial)};
  subsets.close(start, 0, 0);
  visit(std::move(start));
  std::vector<Set> successors(static_cast<u64>(n_events));
  std::vector<i32> met;  // the events with successors
  for (u64 head = 0; head < queue.size(); ++head) {
    const Set& set = *queue[head];
    u8 any_marked = 0;
    met.clear();
    for (const i32 q : set) {
      any_marked |= marked[q];
      for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k) {
        const i32 e = g.events[k];
        if (hidden[e]) continue;
        if (successors[e].empty()) met.push_back(e);
        successors[e].push_back(g.targets[k]);
      }
      ticker.tick(static_cast<u64>(g.offsets[q + 1] - g.offsets[q]) + 1, number.size(), out.events.size());
    }
    std::sort(met.begin(), met.end());
    for (const i32 e : met) {
      Set next;
      next.swap(successors[e]);
      subsets.close(next, number.size(), out.events.size());
      next.shrink_to_fit();
      out.events.push_back(e);
      out.targets.push_back(visit(std::move(next)));
    }
    out.members.insert(out.members.end(), set.begin(), set.end());
    out.member_offsets.push_back(static_cast<i64>(out.members.size()));
    out.offsets.push_back(static_cast<i64>(out.events.size()));
    out.marked.push_back(any_marked != 0);
    ticker.check(number.size(), out.events.size(), 0);
  }
  return out;
}

}  // namespace thenar

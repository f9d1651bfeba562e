// Relations: what events do, as identity-reduced diagrams over (before, after).
#include <stdexcept>

#include "diagrams.hpp"

namespace thenar {

Relation Forest::step(u32 level, std::vector<Pair> pairs) {
  std::erase_if(pairs, [](const Pair& p) { return p.next == kNever; });
  if (pairs.empty()) return kNever;
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  // The identity on this level: skip it.
  bool identity = pairs.size() == sizes_[level];
  for (u32 k = 0; identity && k < pairs.size(); ++k)
    identity = pairs[k].from == k && pairs[k].to == k && pairs[k].next == pairs[0].next;
  if (identity) return pairs[0].next;
  u64 h = level * 0x9e3779b97f4a7c15ull;
  for (const Pair& p : pairs)
    h = ((h ^ h >> 31 ^ p.next) * 0xbf58476d1ce4e5b9ull ^ (static_cast<u64>(p.from) << 32 | p.to)) * 0x94d049bb133111ebull;
  for (auto [at, stop] = known_steps_.equal_range(h); at != stop; ++at) {
    const Step& s = steps_[at->second];
    if (s.level == level && s.count == pairs.size() && std::equal(pairs.begin(), pairs.end(), &pairs_[s.first]))
      return at->second;
  }
  const Relation made = static_cast<Relation>(steps_.size());
  steps_.push_back({level, static_cast<u32>(pairs_.size()), static_cast<u32>(pairs.size())});
  pairs_.insert(pairs_.end(), pairs.begin(), pairs.end());
  known_steps_.emplace(h, made);
  return made;
}

// Pairs of r at `level`; where r skips the level, the identity's.
static std::vector<Pair> pairs_at(const Forest& f, Relation r, u32 level) {
  if (f.relation_level(r) == level) return {f.begin(r), f.end(r)};
  std::vector<Pair> pairs(f.size(level));
  for (u32 i = 0; i < pairs.size(); ++i) pairs[i] = {i, i, r};
  return pairs;
}

namespace {

u64 both(u32 a, u32 b) { return static_cast<u64>(a) << 32 | b; }

}  // namespace

Relation Forest::join(Relation a, Relation b) {
  Memo memo;
  return join(a, b, memo);
}

Relation Forest::join(Relation a, Relation b, Memo& memo) {
  if (a == kNever || b == kNever) return kNever;
  if (a == kIdentity) return b;
  if (b == kIdentity) return a;
  if (relation_level(a) < relation_level(b)) std::swap(a, b);
  if (relation_level(a) == relation_level(b)) throw std::invalid_argument("relations to be joined move the same level");
  if (auto known = memo.find(both(a, b)); known != memo.end()) return known->second;
  tick();
  std::vector<Pair> pairs{begin(a), end(a)};
  for (Pair& p : pairs) p.next = join(p.next, b, memo);
  return memo[both(a, b)] = step(relation_level(a), std::move(pairs));
}

Relation Forest::either(Relation a, Relation b) {
  Memo memo;
  return either(a, b, memo);
}

Relation Forest::either(Relation a, Relation b, Memo& memo) {
  if (a == b || b == kNever) return a;
  if (a == kNever) return b;
  if (a > b) std::swap(a, b);
  if (auto known = memo.find(both(a, b)); known != memo.end()) return known->second;
  tick();
  const u32 level = std::max(relation_level(a), relation_level(b));
  std::vector<Pair> pairs = pairs_at(*this, a, level), others = pairs_at(*this, b, level), merged;
  pairs.insert(pairs.end(), others.begin(), others.end());
  std::sort(pairs.begin(), pairs.end());
  for (const Pair& p : pairs) {
    if (!merged.empty() && merged.back().from == p.from && merged.back().to == p.to)
      merged.back().next = either(merged.back().next, p.next, memo);
    else
      merged.push_back(p);
  }
  return memo[both(a, b)] = step(level, std::move(merged));
}

Relation Forest::restrict(Relation r, Node before) {
  Memo memo;
  return restrict(r, before, memo);
}

Relation Forest::restrict(Relation r, Node before, Memo& memo) {
  if (r == kNever || before == kNothing) return kNever;
  if (before == kEverything) return r;
  if (auto known = memo.find(both(r, before)); known != memo.end()) return known->second;
  tick();
  const u32 level = std::max(relation_level(r), level_[before]);
  std::vector<Pair> pairs = pairs_at(*this, r, level);
  for (Pair& p : pairs) p.next = restrict(p.next, child(before, level, p.from), memo);
  return memo[both(r, before)] = step(level, std::move(pairs));
}

Relation Forest::inverse(Relation r) {
  if (r <= kIdentity) return r;
  if (auto known = inverses_.find(r); known != inverses_.end()) return known->second;
  tick();
  std::vector<Pair> pairs{begin(r), end(r)};
  for (Pair& p : pairs) {
    std::swap(p.from, p.to);
    p.next = inverse(p.next);
  }
  return inverses_[r] = step(relation_level(r), std::move(pairs));
}

Relation Forest::rows(const std::vector<u32>& levels, const u32* before_after, u64 n_rows) {
  std::vector<const u32*> pointers(n_rows);
  for (u64 k = 0; k < n_rows; ++k) pointers[k] = before_after + k * 2 * levels.size();
  std::sort(pointers.begin(), pointers.end(), [&](const u32* a, const u32* b) {
    return std::lexicographical_compare(a, a + 2 * levels.size(), b, b + 2 * levels.size());
  });
  return rows(levels, 0, pointers, 0, n_rows);
}

// A row is (before, after) of each level in turn; rows lo .. hi agree on the levels before `depth`.
Relation Forest::rows(const std::vector<u32>& levels, u32 depth, std::vector<const u32*>& pointers, u64 lo, u64 hi) {
  if (lo == hi) return kNever;
  if (depth == levels.size()) return kIdentity;
  tick();
  std::vector<Pair> pairs;
  while (lo < hi) {
    const u32 from = pointers[lo][2 * depth], to = pointers[lo][2 * depth + 1];
    u64 next = lo;
    while (next < hi && pointers[next][2 * depth] == from && pointers[next][2 * depth + 1] == to) ++next;
    pairs.push_back({from, to, rows(levels, depth + 1, pointers, lo, next)});
    lo = next;
  }
  return step(levels[depth], std::move(pairs));
}

std::vector<u32> Forest::relation_support(Relation r) {
  std::vector<u32> levels;
  std::vector<Relation> open{r};
  std::unordered_map<Relation, bool> seen;
  while (!open.empty()) {
    const Relation next = open.back();
    open.pop_back();
    if (next <= kIdentity || !seen.emplace(next, true).second) continue;
    tick();
    levels.push_back(relation_level(next));
    for (const Pair* p = begin(next); p != end(next); ++p) open.push_back(p->next);
  }
  std::sort(levels.rbegin(), levels.rend());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

Node Forest::domain(Relation r) {
  if (r <= kIdentity) return r;  // never: nothing; the identity: everything
  if (auto known = domains_.find(r); known != domains_.end()) return known->second;
  tick();
  const u32 level = relation_level(r);
  std::vector<Node> kids(sizes_[level], kNothing);
  for (u64 k = 0; k < steps_[r].count; ++k) {
    const Pair p = begin(r)[k];
    kids[p.from] = unite(kids[p.from], domain(p.next));
  }
  return domains_[r] = make(level, kids.data());
}

Node Forest::image(Node set, Relation r) {
  if (set == kNothing || r == kNever) return kNothing;
  if (r == kIdentity) return set;
  Node result;
  if (cache_.find(kImage, set, r, 0, result)) return result;
  tick();
  const u32 level = std::max(level_[set], relation_level(r));
  std::vector<Node> kids(sizes_[level], kNothing);
  if (relation_level(r) == level) {
    for (const Pair *p = begin(r), *stop = end(r); p != stop; ++p)
      kids[p->to] = unite(kids[p->to], image(child(set, level, p->from), p->next));
  } else {
    for (u32 i = 0; i < sizes_[level]; ++i) kids[i] = image(child(set, level, i), r);
  }
  result = make(level, kids.data());
  cache_.store(kImage, set, r, 0, result);
  return result;
}

bool Forest::contains(Node set, const State& state) const {
  while (set > kEverything) set = child(set, level_[set], state[level_[set]]);
  return set == kEverything;
}

// From one state into a set: above the topmost level of a relation the way is that of the state itself, and where it
// comes back to that one below, the end is known.
struct Forest::Way {
  const Forest& f;
  const State& state;
  std::vector<Node> at;  // where the state itself is on its way down, at each level or the next one below

  Way(const Forest& f, Node set, const State& state) : f(f), state(state), at(f.n_levels() + 1) {
    for (u32 level = f.n_levels(); level > 0; --level) {
      at[level] = set;
      set = f.child(set, level, state[level]);
    }
    at[0] = set;
  }
  bool leads(Node n, Relation r) const {
    while (n != kNothing && r != kNever) {
      if (r == kIdentity && (n == kEverything || at[f.level_[n]] == n)) return n == kEverything || at[0] == kEverything;
      const u32 moved = f.relation_level(r), level = std::max(f.level_[n], moved);
      if (moved == level) {
        for (const Pair* p = f.begin(r); p != f.end(r); ++p)
          if (p->from == state[level] && leads(f.child(n, level, p->to), p->next)) return true;
        return false;
      }
      n = f.child(n, level, state[level]);
    }
    return false;
  }
};

std::vector<u8> Forest::lead_into(Node set, const State& state, const std::vector<Relation>& relations) const {
  const Way way(*this, set, state);
  std::vector<u8> found;
  for (Relation r : relations) found.push_back(way.leads(way.at[relation_level(r)], r));
  return found;
}

// One way down through a set twice (before and after), a part of it and a relation, counting what lies to the left.
struct Forest::Walk {
  Forest& f;
  std::unordered_map<Node, u64> sizes;  // vectors over the levels up to the node's own
  std::vector<u32>&sources, &targets;

  u64 count(Node n, u32 level) const {
    if (n == kNothing) return 0;
    u64 size = n == kEverything ? 1 : sizes.at(n);
    for (u32 k = f.level_[n] + 1; k <= level; ++k) size *= f.sizes_[k];
    return size;
  }
  void down(u32 level, Node from, Node before, Relation r, Node after, u64 source, u64 target) {
    if (from == kNothing || after == kNothing || r == kNever) return;
    f.tick();
    if (level == 0) {
      sources.push_back(static_cast<u32>(source));
      targets.push_back(static_cast<u32>(target));
      return;
    }
    std::vector<u64> left_before(f.sizes_[level] + 1, source), left_after(f.sizes_[level] + 1, target);
    for (u32 i = 0; i < f.sizes_[level]; ++i) {
      left_before[i + 1] = left_before[i] + count(f.child(before, level, i), level - 1);
      left_after[i + 1] = left_after[i] + count(f.child(after, level, i), level - 1);
    }
    auto step = [&](u32 i, u32 j, Relation next) {
      down(level - 1, f.child(from, level, i), f.child(before, level, i), next, f.child(after, level, j), left_before[i],
           left_after[j]);
    };
    if (r != kIdentity && f.relation_level(r) == level) {
      for (const Pair* p = f.begin(r); p != f.end(r); ++p) step(p->from, p->to, p->next);
    } else {
      for (u32 i = 0; i < f.sizes_[level]; ++i) step(i, i, r);
    }
  }
};

void Forest::steps(Node set, Node from, Relation r, std::vector<u32>& sources, std::vector<u32>& targets) {
  Walk walk{*this, {}, sources, targets};
  for (Node n : bottom_up(set)) {
    u64 size = 0;
    for (u32 i = 0; i < sizes_[level_[n]]; ++i) size += walk.count(child(n, level_[n], i), level_[n] - 1);
    walk.sizes[n] = size;
  }
  walk.down(n_levels(), from, set, r, set, 0, 0);
}

}  // namespace thenar

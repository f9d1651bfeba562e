// Exact numbers of states and steps, however large.
#include <algorithm>

#include "diagrams.hpp"

namespace thenar {
namespace {

using Big = std::vector<u64>;  // little-endian

void times(Big& x, u32 factor) {
  u64 carry = 0;
  for (u64& word : x) {
    const unsigned __int128 product = static_cast<unsigned __int128>(word) * factor + carry;
    word = static_cast<u64>(product);
    carry = static_cast<u64>(product >> 64);
  }
  if (carry) x.push_back(carry);
}

void add(Big& x, const Big& y) {
  if (x.size() < y.size()) x.resize(y.size(), 0);
  u64 carry = 0;
  for (u64 k = 0; k < x.size() && (carry || k < y.size()); ++k) {
    const unsigned __int128 sum = static_cast<unsigned __int128>(x[k]) + (k < y.size() ? y[k] : 0) + carry;
    x[k] = static_cast<u64>(sum);
    carry = static_cast<u64>(sum >> 64);
  }
  if (carry) x.push_back(carry);
}

Big product(const Big& x, const Big& y) {
  Big z(x.size() + y.size(), 0);
  for (u64 i = 0; i < x.size(); ++i) {
    u64 carry = 0;
    for (u64 j = 0; j < y.size(); ++j) {
      const unsigned __int128 sum = static_cast<unsigned __int128>(x[i]) * y[j] + z[i + j] + carry;
      z[i + j] = static_cast<u64>(sum);
      carry = static_cast<u64>(sum >> 64);
    }
    z[i + y.size()] = carry;
  }
  while (!z.empty() && z.back() == 0) z.pop_back();
  return z;
}

}  // namespace

std::vector<u64> Forest::count(Node set) {
  std::unordered_map<Node, Big> counts;
  // The count of a node at the given level: levels in between may take any value.
  auto lifted = [&](Node n, u32 level) {
    Big x = counts[n];
    for (u32 k = level_[n] + 1; k <= level && !x.empty(); ++k) times(x, sizes_[k]);
    return x;
  };
  Big everything{1};  // over the levels below that of the node in hand, which rises
  u32 below = 0;
  auto rise = [&](u32 level) {
    while (below < level) times(everything, sizes_[++below]);
  };
  for (Node n : bottom_up(set)) {
    rise(level_[n] - 1);
    Big sum;
    for (u32 i = 0; i < sizes_[level_[n]]; ++i) {
      const Node kid = child(n, level_[n], i);
      tick();
      if (kid == kEverything) add(sum, everything);
      else if (kid != kNothing) add(sum, lifted(kid, level_[n] - 1));
    }
    counts[n] = std::move(sum);
  }
  if (set > kEverything) return lifted(set, n_levels());
  rise(n_levels());
  return set == kEverything ? everything : Big{};
}

// Steps are counted from the topmost level of their relation down; above it nothing moves, and it is enough to know how
// many ways lead from the top to each node, which is found out once for all relations.
class Forest::StepCounter {
 public:
  StepCounter(Forest& forest, Node set) : f_(forest), ways_(forest.n_levels() + 1) {
    counts_[kNothing] = {};
    counts_[kEverything] = {1};
    std::vector<Node> nodes = f_.bottom_up(set);
    std::unordered_map<Node, Big> from_top{{set, {1}}};
    for (u32 k = f_.n_levels(); k > f_.level_[set]; --k) times(from_top[set], f_.sizes_[k]);
    // An edge over several levels crosses the cut above each of them.
    auto cross = [&](Node kid, u32 from, Big weight) {
      for (u32 k = from - 1;; --k) {
        f_.tick();
        add(ways_[k][kid], weight);
        if (k == f_.level_[kid]) break;
        times(weight, f_.sizes_[k]);
      }
      if (kid > kEverything) add(from_top[kid], weight);
    };
    Big above{1};
    for (u32 k = f_.n_levels(); k > f_.level_[set]; --k) {
      ways_[k][set] = above;
      times(above, f_.sizes_[k]);
    }
    if (set > kEverything) ways_[f_.level_[set]][set] = above;
    for (auto n = nodes.rbegin(); n != nodes.rend(); ++n)
      for (u32 i = 0; i < f_.sizes_[f_.level_[*n]]; ++i)
        if (const Node kid = f_.child(*n, f_.level_[*n], i); kid != kNothing) cross(kid, f_.level_[*n], from_top[*n]);
  }

  Big operator()(Relation r) {
    Big sum;
    if (r == kNever) return sum;
    pairs_.clear();
    if (f_.n_levels() == 0) return {1};
    const u32 level = std::max<u32>(f_.relation_level(r), 1);
    for (const auto& [n, ways] : ways_[level]) add(sum, product(ways, pairs(level, n, r, n)));
    return sum;
  }

 private:
  struct Key {
    u32 level, before, after;
    Relation r;
    bool operator==(const Key&) const = default;
  };
  struct Hash {
    u64 operator()(const Key& k) const {
      u64 h = (static_cast<u64>(k.before) << 32 | k.after) * 0x9e3779b97f4a7c15ull;
      return (h ^ h >> 29 ^ (static_cast<u64>(k.r) << 32 | k.level)) * 0xbf58476d1ce4e5b9ull;
    }
  };

  const Big& count(Node n) {  // over the levels up to its own
    if (auto known = counts_.find(n); known != counts_.end()) return known->second;
    Big sum;
    const u32 level = f_.level_[n];
    for (u32 i = 0; i < f_.sizes_[level]; ++i) add(sum, lifted(f_.child(n, level, i), level - 1));
    return counts_[n] = std::move(sum);
  }
  Big lifted(Node n, u32 level) {
    Big x = count(n);
    for (u32 k = f_.level_[n] + 1; k <= level && !x.empty(); ++k) times(x, f_.sizes_[k]);
    return x;
  }
  // Pairs (x, y) over levels 1 .. level with x before, y after and r between them.
  Big pairs(u32 level, Node before, Relation r, Node after) {
    if (before == kNothing || after == kNothing || r == kNever) return {};
    if (r == kIdentity) return lifted(f_.intersect(before, after), level);
    const Key key{level, before, after, r};
    if (auto known = pairs_.find(key); known != pairs_.end()) return known->second;
    f_.tick();
    Big sum;
    if (f_.relation_level(r) == level) {
      for (u64 k = 0; k < f_.steps_[r].count; ++k) {
        const Pair p = f_.begin(r)[k];
        add(sum, pairs(level - 1, f_.child(before, level, p.from), p.next, f_.child(after, level, p.to)));
      }
    } else {
      for (u32 i = 0; i < f_.sizes_[level]; ++i)
        add(sum, pairs(level - 1, f_.child(before, level, i), r, f_.child(after, level, i)));
    }
    return pairs_[key] = sum;
  }

  Forest& f_;
  std::vector<std::unordered_map<Node, Big>> ways_;  // of each cut: the nodes at or below it, and the ways to them
  std::unordered_map<Node, Big> counts_;
  std::unordered_map<Key, Big, Hash> pairs_;
};

std::vector<u64> Forest::count_steps(Node set, const std::vector<Relation>& relations) {
  Big sum;
  if (set == kNothing) return sum;
  StepCounter steps(*this, set);
  for (Relation r : relations) add(sum, steps(r));
  return sum;
}

}  // namespace thenar

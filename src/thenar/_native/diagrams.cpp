// Sets: unique table, Boolean operations, garbage collection, counting.
#include "diagrams.hpp"

#include <stdexcept>

namespace thenar {

void OperationCache::grow() {
  std::vector<Entry> old(entries_.size() * 2);
  old.swap(entries_);
  stored_ = 0;
  for (const Entry& e : old)
    if (e.a) entries_[slot(e.a, e.b, e.c, e.d)] = e;
}

Forest::Forest(std::vector<u32> sizes, u64 max_bytes, u64 cache_bytes, u64 collect_at)
    : max_bytes(max_bytes), free_(sizes.size() + 1), threshold_(collect_at), cache_(cache_bytes) {
  if (std::find(sizes.begin(), sizes.end(), 0u) != sizes.end()) throw std::invalid_argument("a level without values");
  sizes_.push_back(0);
  sizes_.insert(sizes_.end(), sizes.begin(), sizes.end());
  for (int terminal = 0; terminal < 2; ++terminal) {
    first_.push(0);
    level_.push(0);
    steps_.push_back({0, 0, 0});
  }
  unique_.assign(1 << 12, 0);
}

u64 Forest::hash(u32 level, const Node* kids) const {
  u64 h = level * 0x9e3779b97f4a7c15ull;
  for (u32 i = 0; i < sizes_[level]; ++i) h = (h ^ h >> 31 ^ kids[i]) * 0xbf58476d1ce4e5b9ull;
  return h ^ h >> 32;
}

void Forest::rehash(u64 capacity) {
  unique_.assign(capacity, 0);
  for (Node n = 2; n < first_.size(); ++n) {
    if (level_[n] == 0) continue;
    u64 slot = hash(level_[n], &kids_[first_[n]]) & (capacity - 1);
    while (unique_[slot]) slot = (slot + 1) & (capacity - 1);
    unique_[slot] = n;
  }
}

Node Forest::make(u32 level, const Node* kids) {
  const u32 size = sizes_[level];
  if (std::all_of(kids + 1, kids + size, [&](Node kid) { return kid == kids[0]; })) return kids[0];
  u64 mask = unique_.size() - 1, slot = hash(level, kids) & mask;
  for (; unique_[slot]; slot = (slot + 1) & mask) {
    const Node n = unique_[slot];
    if (level_[n] == level && std::equal(kids, kids + size, &kids_[first_[n]])) return n;
  }
  Node made;
  if (!free_[level].empty()) {
    made = free_[level].back();
    free_[level].pop_back();
    level_[made] = level;
  } else {
    if (kids_.size() + size > kNone || first_.size() >= kNone) throw LimitHit{"bytes", 17e9, n_alive_, work};
    made = static_cast<Node>(first_.size());
    first_.push(static_cast<u32>(kids_.size()));
    level_.push(level);
    kids_.extend(size);
  }
  std::copy(kids, kids + size, &kids_[first_[made]]);
  unique_[slot] = made;
  n_peak_ = std::max(n_peak_, ++n_alive_);
  if (n_alive_ * 3 > unique_.size() * 2) rehash(unique_.size() * 2);
  return made;
}

u64 Forest::bytes() const {
  return kids_.bytes() + first_.bytes() + level_.bytes() + unique_.size() * sizeof(u32) + cache_.bytes() +
         pairs_.capacity() * sizeof(Pair) + seen_.size() * sizeof(u32);
}

void Forest::check_bytes() const {
  if (bytes() > max_bytes) throw LimitHit{"bytes", static_cast<double>(max_bytes), n_alive_, work};
}

void Forest::collect() {
  std::vector<u8> alive(first_.size(), 0);
  std::vector<Node> open;
  auto reach = [&](Node n) {
    if (n > 1 && !alive[n]) alive[n] = 1, open.push_back(n);
  };
  for (const auto& [n, count] : held_) reach(n);
  for (const auto& [r, n] : domains_) reach(n);
  for (Node n : stack_) reach(n);
  while (!open.empty()) {
    const Node n = open.back();
    open.pop_back();
    for (u32 i = 0; i < sizes_[level_[n]]; ++i) reach(kids_[first_[n] + i]);
  }
  n_alive_ = 0;
  for (Node n = 2; n < first_.size(); ++n) {
    if (alive[n]) {
      ++n_alive_;
    } else if (level_[n]) {
      free_[level_[n]].push_back(n);
      level_[n] = 0;
    }
  }
  auto lives = [&](u32 n) { return n < 2 || (n < alive.size() && alive[n]); };
  cache_.sweep([&](const OperationCache::Entry& e) {
    if (e.a >= kFamily) return lives(e.c) && lives(e.d) && lives(e.result);  // Saturation: (kind, relation, set, within)
    if (e.a == kImage) return lives(e.b) && lives(e.result);
    return lives(e.b) && lives(e.c) && lives(e.result);
  });
  rehash(unique_.size());
  ++n_collections_;
  // What is collected is forgotten by the cache too, and found again at a cost: the more often, the rarer.
  threshold_ = std::max<u64>(2 * n_alive_, std::min<u64>(2 * threshold_, kManyNodes));
}

u32 Forest::join_family() {
  const u32 family = static_cast<u32>(std::countr_one(families_));
  if (family >= kMaxFamilies) throw std::length_error("more than 60 saturations of one forest at a time");
  families_ |= u64{1} << family;
  return family;
}

void Forest::leave_families(u64 which) {
  families_ &= ~which;
  cache_.sweep([&](const OperationCache::Entry& e) {
    const u32 key = e.a & 255;
    return key < kFamily || !(which >> (key - kFamily) / 4 & 1);
  });
}

template <class F>
Node Forest::apply(u32 level, Node a, Node b, F combine) {
  // The stack, not the frame: these operations collect no garbage, so their results need no protection.
  Node small[32];
  std::vector<Node> large;
  Node* kids = small;
  if (sizes_[level] > 32) {
    large.resize(sizes_[level]);
    kids = large.data();
  }
  for (u32 i = 0; i < sizes_[level]; ++i) kids[i] = combine(child(a, level, i), child(b, level, i));
  return make(level, kids);
}

Node Forest::unite(Node a, Node b) {
  if (a == b || b == kNothing || a == kEverything) return a;
  if (a == kNothing || b == kEverything) return b;
  if (a > b) std::swap(a, b);
  Node result;
  if (cache_.find(kUnite, a, b, 0, result)) return result;
  tick();
  result = apply(top(a, b), a, b, [&](Node x, Node y) { return unite(x, y); });
  cache_.store(kUnite, a, b, 0, result);
  return result;
}

Node Forest::intersect(Node a, Node b) {
  if (a == b || b == kEverything || a == kNothing) return a;
  if (a == kEverything || b == kNothing) return b;
  if (a > b) std::swap(a, b);
  Node result;
  if (cache_.find(kIntersect, a, b, 0, result)) return result;
  tick();
  result = apply(top(a, b), a, b, [&](Node x, Node y) { return intersect(x, y); });
  cache_.store(kIntersect, a, b, 0, result);
  return result;
}

Node Forest::subtract(Node a, Node b) {
  if (a == b || a == kNothing || b == kEverything) return kNothing;
  if (b == kNothing) return a;
  Node result;
  if (cache_.find(kSubtract, a, b, 0, result)) return result;
  tick();
  result = apply(top(a, b), a, b, [&](Node x, Node y) { return subtract(x, y); });
  cache_.store(kSubtract, a, b, 0, result);
  return result;
}

Node Forest::literal(u32 level, const u8* mask) {
  std::vector<Node> kids(sizes_[level]);
  for (u32 i = 0; i < sizes_[level]; ++i) kids[i] = mask[i] ? kEverything : kNothing;
  return make(level, kids.data());
}

Node Forest::table(const std::vector<u32>& levels, const u8* truth) {
  u64 n = 1;
  for (u32 level : levels) n *= sizes_[level];
  std::vector<Node> row(n);
  for (u64 k = 0; k < n; ++k) row[k] = truth[k] ? kEverything : kNothing;
  for (auto level = levels.rbegin(); level != levels.rend(); ++level) {
    const u32 size = sizes_[*level];
    n /= size;
    for (u64 k = 0; k < n; ++k) row[k] = make(*level, &row[k * size]);
  }
  return row[0];
}

// Coudert and Madre's restrict: where one value is outside the care set, it takes over what another value says.
Node Forest::simplify(Node set, Node care) {
  if (care == kNothing) return kNothing;
  if (set <= kEverything || care == kEverything) return set;
  if (set == care) return kEverything;
  Node result;
  if (cache_.find(kSimplify, set, care, 0, result)) return result;
  tick();
  if (level_[care] > level_[set]) {
    Node any = kNothing;
    for (u32 i = 0; i < sizes_[level_[care]]; ++i) any = unite(any, child(care, level_[care], i));
    result = simplify(set, any);
  } else {
    const u32 level = level_[set];
    std::vector<Node> kids(sizes_[level], kNone);
    Node last = kNone;
    for (u32 i = 0; i < sizes_[level]; ++i) {
      const Node allowed = child(care, level, i);
      if (allowed != kNothing) last = kids[i] = simplify(child(set, level, i), allowed);
    }
    for (Node& kid : kids)
      if (kid == kNone) kid = last;
      else last = kid;
    result = make(level, kids.data());
  }
  cache_.store(kSimplify, set, care, 0, result);
  return result;
}

std::vector<Node> Forest::factors(Node set) {
  std::vector<Node> found;
  if (set == kNothing) found.push_back(set);
  if (set <= kEverything) return found;
  const std::vector<Node> nodes = bottom_up(set);
  // How far up a node is referred to from; between there and its own level it is one of the ways through.
  std::unordered_map<Node, u32> reach;
  for (Node n : nodes)
    for (u32 i = 0; i < sizes_[level_[n]]; ++i)
      if (const Node kid = child(n, level_[n], i); kid != kNothing) {
        u32& highest = reach[kid];
        highest = std::max(highest, level_[n]);
      }
  std::vector<i64> ways(n_levels() + 2, 0);  // between level k + 1 and level k
  for (const auto& [n, highest] : reach) {
    ++ways[level_[n]];
    --ways[highest];
  }
  for (u32 k = 1; k < ways.size(); ++k) ways[k] += ways[k - 1];
  Node top = set;
  for (auto next = nodes.rbegin(); next != nodes.rend(); ++next) {
    const Node n = *next;
    if (n == set || ways[level_[n]] != 1) continue;
    std::unordered_map<Node, Node> memo;
    found.push_back(replace(top, n, memo));
    top = n;
  }
  found.push_back(top);
  return found;
}

// n with everything in place of `old`.
Node Forest::replace(Node n, Node old, std::unordered_map<Node, Node>& memo) {
  if (n == old) return kEverything;
  if (n <= kEverything || level_[n] <= level_[old]) return n;
  if (auto known = memo.find(n); known != memo.end()) return known->second;
  tick();
  const u32 level = level_[n];
  std::vector<Node> kids(sizes_[level]);
  for (u32 i = 0; i < sizes_[level]; ++i) kids[i] = replace(child(n, level, i), old, memo);
  return memo[n] = make(level, kids.data());
}

bool Forest::products(Node low, Node high, u64 limit, std::vector<Product>& out) {
  Product prefix;
  cover(low, high, limit, prefix, out);
  return out.size() <= limit;
}

// Minato and Morreale, with sets of values for literals: first what holds whatever this level's value is, then the
// rest, values with the same bound together. Returns what the products put out cover.
Node Forest::cover(Node low, Node high, u64 limit, Product& prefix, std::vector<Product>& out) {
  if (low == kNothing || out.size() > limit) return kNothing;
  if (high == kEverything) {
    out.push_back(prefix);
    return kEverything;
  }
  tick();
  const u32 level = top(low, high), size = sizes_[level];
  Node common = kEverything, needed = kNothing;
  for (u32 i = 0; i < size; ++i) common = intersect(common, child(high, level, i));
  for (u32 i = 0; i < size; ++i) needed = unite(needed, intersect(child(low, level, i), common));
  const Node always = cover(needed, common, limit, prefix, out);
  std::vector<Node> kids(size, always);
  std::vector<u8> done(size, 0);
  for (u32 i = 0; i < size; ++i) {
    const Node bound = child(high, level, i);
    if (done[i]) continue;
    Node rest = kNothing;
    for (u32 j = i; j < size; ++j)
      if (child(high, level, j) == bound) {
        done[j] = 1;
        rest = unite(rest, subtract(child(low, level, j), kids[j]));
      }
    if (rest == kNothing) continue;
    const u64 first = out.size(), depth = prefix.size();
    prefix.push_back({level, {}});
    const Node covered = cover(rest, bound, limit, prefix, out);
    prefix.pop_back();
    // Other values that allow the same products join in: the more there are, the shorter the literal reads.
    std::vector<u32> values;
    for (u32 j = 0; j < size; ++j)
      if (subtract(covered, child(high, level, j)) == kNothing) {
        values.push_back(j);
        kids[j] = unite(kids[j], covered);
      }
    for (u64 k = first; k < out.size(); ++k) out[k][depth].values = values;
  }
  return make(level, kids.data());
}

Node Forest::forget(Node set, const std::vector<u8>& levels) {
  std::unordered_map<Node, Node> memo;
  return forget(set, levels, memo);
}

Node Forest::forget(Node set, const std::vector<u8>& levels, std::unordered_map<Node, Node>& memo) {
  if (set <= kEverything) return set;
  if (auto known = memo.find(set); known != memo.end()) return known->second;
  tick();
  const u32 level = level_[set];
  std::vector<Node> kids(sizes_[level]);
  for (u32 i = 0; i < sizes_[level]; ++i) kids[i] = forget(child(set, level, i), levels, memo);
  Node result;
  if (levels[level]) {
    result = kNothing;
    for (Node kid : kids) result = unite(result, kid);
  } else {
    result = make(level, kids.data());
  }
  return memo[set] = result;
}

std::vector<Node> Forest::bottom_up(Node set) {
  std::vector<Node> found, open;
  if (++walk_ == 0) seen_.clear(), walk_ = 1;
  seen_.resize(first_.size(), 0);
  auto reach = [&](Node n) {
    if (n > 1 && seen_[n] != walk_) seen_[n] = walk_, open.push_back(n), found.push_back(n);
  };
  reach(set);
  while (!open.empty()) {
    tick();
    const Node n = open.back();
    open.pop_back();
    for (u32 i = 0; i < sizes_[level_[n]]; ++i) reach(kids_[first_[n] + i]);
  }
  std::stable_sort(found.begin(), found.end(), [&](Node a, Node b) { return level_[a] < level_[b]; });
  return found;
}

u64 Forest::n_nodes(Node set) { return bottom_up(set).size(); }

std::vector<u32> Forest::support(Node set) {
  std::vector<u8> used(sizes_.size(), 0);
  for (Node n : bottom_up(set)) used[level_[n]] = 1;
  std::vector<u32> levels;
  for (u32 level = n_levels(); level > 0; --level)
    if (used[level]) levels.push_back(level);
  return levels;
}

std::vector<u32> Forest::vectors(Node set, u64 limit) {
  std::vector<u32> out, now(n_levels(), 0);
  if (set == kNothing || limit == 0) return out;
  const u32 n = n_levels();
  std::vector<Node> at(n + 1);
  at[n] = set;
  u32 level = n;
  std::vector<u32> next(n + 1, 0);
  u64 found = 0;
  while (true) {
    if (level == 0) {
      tick();
      out.insert(out.end(), now.begin(), now.end());
      if (++found == limit || n == 0) return out;
      ++level;
      continue;
    }
    u32& value = next[level];
    while (value < sizes_[level] && child(at[level], level, value) == kNothing) ++value;
    if (value == sizes_[level]) {
      value = 0;
      if (level == n) return out;
      ++level;
      continue;
    }
    now[n - level] = value;
    at[level - 1] = child(at[level], level, value);
    ++value;
    --level;
  }
}

std::vector<u32> Forest::dump(Node set, std::vector<u32>& order) {
  std::vector<u32> out;
  std::unordered_map<Node, u32> number{{kNothing, 0}, {kEverything, 1}};
  for (Node n : bottom_up(set)) {
    number.emplace(n, static_cast<u32>(number.size()));
    order.push_back(level_[n]);
    for (u32 i = 0; i < sizes_[level_[n]]; ++i) out.push_back(number[child(n, level_[n], i)]);
  }
  return out;
}

}  // namespace thenar

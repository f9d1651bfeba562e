// Supervisor reduction by merging cells greedily, in several orders.   [Su and Wonham, Disc. Event Dyn. Sys. 14, 2004]
#include "reduction.hpp"

#include <numeric>

namespace thenar {
namespace {

// Work is counted in steps of some nanoseconds, so that the same input gives the same cells on every machine.
constexpr u64 kCliqueWork = u64{1} << 30;
constexpr u64 kFreeWork = u64{1} << 25;  // that merging may take in any case; some tenths of a second
constexpr u64 kTimes = 16;               // the work of the first pass, that all passes may take
constexpr u64 kMostPasses = 1000;

// A square matrix of bits.
class Matrix {
 public:
  explicit Matrix(u64 n) : n_words_((n + 63) / 64), words_(n * n_words_) {}
  u64 n_words() const { return n_words_; }
  u64* row(u64 x) { return words_.data() + x * n_words_; }
  const u64* row(u64 x) const { return words_.data() + x * n_words_; }
  bool at(u64 x, u64 y) const { return row(x)[y >> 6] >> (y & 63) & 1; }

 private:
  u64 n_words_;
  std::vector<u64> words_;
};

// For each state what it enables and what it forbids, as bits; marking is one more event.
struct Patterns {
  u64 n_words;
  std::vector<u64> enabled, forbidden;

  explicit Patterns(const Duties& d) : n_words(d.n_events / 64 + 1) {
    const u64 n = static_cast<u64>(d.moves.n_states);
    enabled.resize(n * n_words);
    forbidden.resize(n * n_words);
    auto set = [&](std::vector<u64>& bits, u64 x, u64 e) { bits[x * n_words + e / 64] |= u64{1} << e % 64; };
    for (u64 x = 0; x < n; ++x) {
      for (i64 k = d.moves.offsets[x]; k < d.moves.offsets[x + 1]; ++k)
        set(enabled, x, static_cast<u64>(d.moves.events[k]));
      for (i64 k = d.disabled_offsets[x]; k < d.disabled_offsets[x + 1]; ++k)
        set(forbidden, x, static_cast<u64>(d.disabled[k]));
      if (d.mark[x]) set(d.mark[x] == 1 ? enabled : forbidden, x, d.n_events);
    }
  }
};

// The pairs of states that no cell of any control cover holds, both ways: one enables what the other forbids, or the
// same string leads to such a pair.
Matrix conflicts(const Duties& d, const Patterns& p, Ticker& ticker) {
  const u64 n = static_cast<u64>(d.moves.n_states), m = static_cast<u64>(d.moves.offsets[n]);
  Matrix apart(n);
  const u64 words = apart.n_words();
  std::vector<u64> can(words), must_not(words);
  for (u64 e = 0; e <= d.n_events; ++e) {
    auto bit = [&](const std::vector<u64>& bits, u64 x) { return bits[x * p.n_words + e / 64] >> e % 64 & 1; };
    std::fill(can.begin(), can.end(), 0), std::fill(must_not.begin(), must_not.end(), 0);
    bool any = false;
    for (u64 x = 0; x < n; ++x) {
      can[x / 64] |= bit(p.enabled, x) << x % 64;
      must_not[x / 64] |= bit(p.forbidden, x) << x % 64;
      any |= bit(p.forbidden, x);
    }
    ticker.tick(n, n, m);
    for (u64 x = 0; any && x < n; ++x) {
      const bool here = bit(p.enabled, x);
      if (!here && !bit(p.forbidden, x)) continue;
      for (u64 w = 0; w < words; ++w) apart.row(x)[w] |= here ? must_not[w] : can[w];
      ticker.tick(words, n, m);
    }
  }
  // Backwards, row by row: if x and y are apart, then so are those that one event leads to them.
  const u64 k = d.n_events;
  std::vector<u32> first(n * k + 1), source(m);  // the sources of the transitions into y by e: from first[y * k + e] on
  auto slot = [&](i64 edge) {
    return static_cast<u64>(d.moves.targets[edge]) * k + static_cast<u64>(d.moves.events[edge]);
  };
  for (u64 edge = 0; edge < m; ++edge) ++first[slot(static_cast<i64>(edge)) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<u32> next(first.begin(), first.end() - 1);
  std::vector<u64> entered(k * words);  // by each event
  for (u64 x = 0; x < n; ++x)
    for (i64 edge = d.moves.offsets[x]; edge < d.moves.offsets[x + 1]; ++edge) {
      source[next[slot(edge)]++] = static_cast<u32>(x);
      const u64 y = static_cast<u64>(d.moves.targets[edge]);
      entered[static_cast<u64>(d.moves.events[edge]) * words + y / 64] |= u64{1} << y % 64;
    }
  Matrix done(n);
  std::vector<u8> waits(n, 1);
  std::vector<u32> queue(n), later;
  std::iota(queue.begin(), queue.end(), 0);
  std::vector<u64> fresh(words);
  for (; !queue.empty(); queue.swap(later), later.clear())
    for (const u32 x : queue) {
      waits[x] = 0;
      for (u64 w = 0; w < words; ++w) {
        fresh[w] = apart.row(x)[w] & ~done.row(x)[w];
        done.row(x)[w] |= fresh[w];
      }
      u64 work = words;
      for (u64 e = 0; e < k; ++e)
        for (u64 i = first[x * k + e]; i < first[x * k + e + 1]; ++i) {
          const u32 a = source[i];
          u64* row = apart.row(a);
          bool more = false;
          for (u64 w = 0; w < words; ++w)
            for (u64 left = fresh[w] & entered[e * words + w]; left; left &= left - 1) {
              const u64 y = w * 64 + static_cast<u64>(std::countr_zero(left));
              for (u64 j = first[y * k + e]; j < first[y * k + e + 1]; ++j, ++work) {
                const u32 b = source[j];
                const u64 bit = u64{1} << (b & 63);
                more |= !(row[b >> 6] & bit);
                row[b >> 6] |= bit;
              }
            }
          work += words;
          if (more && !waits[a]) waits[a] = 1, later.push_back(a);
        }
      ticker.tick(work, n, m);
    }
  return apart;
}

// States no two of which fit into one cell, as many as a greedy search finds from each state in turn.
std::vector<u32> clique(const Matrix& apart, u64 n, Ticker& ticker) {
  const u64 words = apart.n_words();
  std::vector<u64> degree(n);
  for (u64 x = 0; x < n; ++x)
    for (u64 w = 0; w < words; ++w) degree[x] += count_ones(apart.row(x)[w]);
  std::vector<u32> order(n), best, found;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](u32 x, u32 y) { return degree[x] > degree[y]; });
  std::vector<u64> left(words);
  u64 work = 0;
  for (const u32 seed : order) {
    if (degree[seed] < best.size() || work > kCliqueWork) break;  // no larger clique holds it, nor any after it
    found.assign(1, seed);
    std::copy(apart.row(seed), apart.row(seed) + words, left.begin());
    for (const u32 x : order) {
      if (!(left[x >> 6] >> (x & 63) & 1)) continue;
      found.push_back(x);
      for (u64 w = 0; w < words; ++w) left[w] &= apart.row(x)[w];
    }
    work += n + found.size() * words;
    ticker.tick(n + found.size() * words, n, 0);
    if (found.size() > best.size()) best = found;
  }
  return best;
}

// A partition of the states into cells that is a right congruence, made coarser by merging two cells at a time.
class Partition {
 public:
  Partition(const Duties& d, const Patterns& p, const Matrix& apart)
      : n_(static_cast<u64>(d.moves.n_states)),
        n_events_(d.n_events),
        patterns_(p),
        conflicts_(apart),
        parent_(n_),
        next_(n_),
        size_(n_, 1),
        first_(n_),
        target_(n_ * n_events_, kNone) {
    std::iota(parent_.begin(), parent_.end(), 0);
    std::iota(next_.begin(), next_.end(), 0);
    for (u64 x = 0; x < n_; ++x)
      for (i64 k = d.moves.offsets[x]; k < d.moves.offsets[x + 1]; ++k)
        target_[x * n_events_ + static_cast<u64>(d.moves.events[k])] = static_cast<u32>(d.moves.targets[k]);
  }
  u64 work = 0;

  // For each two cells in the order of their first states: merge them, and what must be merged then, if that can be.
  // Return the number of cells.
  u64 merge_all(const std::vector<u32>& order, Ticker& ticker) {
    for (u64 k = 0; k < n_; ++k) first_[order[k]] = static_cast<u32>(k);
    std::vector<u32> heads(order), later;  // the first state of each cell
    u64 done = 0;
    while (done < heads.size()) {
      const u32 x = heads[done];
      later.assign(heads.begin(), heads.begin() + static_cast<i64>(done) + 1);
      for (u64 k = done + 1; k < heads.size(); ++k) {
        const u32 y = heads[k];
        if (order[first_[find(y)]] != y) continue;  // has been merged with an earlier one
        const u64 before = work;
        if (!merge(x, y)) later.push_back(y);
        ticker.tick(work - before + 1, n_, 0);
      }
      work += heads.size() - done;
      heads.swap(later);
      ++done;
      std::erase_if(heads, [&](u32 y) { return order[first_[find(y)]] != y; });
    }
    return heads.size();
  }
  u32 find(u32 x) const {
    while (parent_[x] != x) x = parent_[x];
    return x;
  }
  // The cell of each state, numbered by their first states.
  std::vector<i32> cells() const {
    std::vector<i32> cell(n_), number(n_, -1);
    i32 count = 0;
    for (u32 x = 0; x < n_; ++x) {
      i32& k = number[find(x)];
      if (k < 0) k = count++;
      cell[x] = k;
    }
    return cell;
  }

 private:
  struct Union {
    u32 kept, absorbed, first;  // `first` of the kept one before
    u64 n_targets;              // on the trail, before
  };

  bool fit(u32 a, u32 b) {
    const u64 w = patterns_.n_words;
    const u64 *ea = &patterns_.enabled[a * w], *da = &patterns_.forbidden[a * w];
    const u64 *eb = &patterns_.enabled[b * w], *db = &patterns_.forbidden[b * w];
    for (u64 k = 0; k < w; ++k)
      if ((ea[k] & db[k]) | (eb[k] & da[k])) return false;
    u32 x = b;  // the smaller one
    do {
      if (conflicts_.at(a, x)) return false;
      x = next_[x];
      ++work;
    } while (x != b);
    return true;
  }

  bool merge(u32 x, u32 y) {
    stack_.assign(1, {x, y});
    while (!stack_.empty()) {
      auto [a, b] = stack_.back();
      stack_.pop_back();
      a = find(a), b = find(b);
      if (a == b) continue;
      if (size_[a] < size_[b]) std::swap(a, b);
      if (!fit(a, b)) {
        stack_.clear();
        while (!unions_.empty()) undo();
        return false;
      }
      unite(a, b);
    }
    for (const Union& u : unions_) {
      u64 *row = conflicts_.row(u.kept), *other = conflicts_.row(u.absorbed);
      for (u64 w = 0; w < conflicts_.n_words(); ++w) row[w] |= other[w];
      work += conflicts_.n_words();
    }
    unions_.clear(), trail_.clear(), words_.clear();
    return true;
  }

  void unite(u32 a, u32 b) {
    const u64 w = patterns_.n_words;
    unions_.push_back({a, b, first_[a], trail_.size()});
    parent_[b] = a;
    size_[a] += size_[b];
    std::swap(next_[a], next_[b]);
    first_[a] = std::min(first_[a], first_[b]);
    for (u64 k = 0; k < w; ++k) {
      for (u64 left = patterns_.enabled[b * w + k]; left; left &= left - 1) {
        const u64 e = k * 64 + static_cast<u64>(std::countr_zero(left));
        if (e == n_events_) continue;  // marking leads nowhere
        u32 &mine = target_[a * n_events_ + e], theirs = target_[b * n_events_ + e];
        if (mine == kNone) {
          mine = theirs;
          trail_.push_back(a * n_events_ + e);
        } else {
          stack_.emplace_back(mine, theirs);
        }
        ++work;
      }
      for (auto* bits : {&patterns_.enabled, &patterns_.forbidden}) {
        words_.push_back((*bits)[a * w + k]);
        (*bits)[a * w + k] |= (*bits)[b * w + k];
      }
    }
  }

  void undo() {
    const Union u = unions_.back();
    unions_.pop_back();
    const u64 w = patterns_.n_words;
    for (; trail_.size() > u.n_targets; trail_.pop_back()) target_[trail_.back()] = kNone;
    for (u64 k = w; k-- > 0;)
      for (auto* bits : {&patterns_.forbidden, &patterns_.enabled}) {
        (*bits)[u.kept * w + k] = words_.back();
        words_.pop_back();
      }
    first_[u.kept] = u.first;
    std::swap(next_[u.kept], next_[u.absorbed]);
    size_[u.kept] -= size_[u.absorbed];
    parent_[u.absorbed] = u.absorbed;
  }

  u64 n_, n_events_;
  Patterns patterns_;  // of each cell, at its root
  Matrix conflicts_;   // row r: the states that no member of the cell with root r fits
  std::vector<u32> parent_, next_, size_, first_, target_;
  std::vector<std::pair<u32, u32>> stack_;
  std::vector<Union> unions_;
  std::vector<u64> trail_, words_;
};

// The states in the order of a depth-first search.
std::vector<u32> depth_first(const Graph& g) {
  const u64 n = static_cast<u64>(g.n_states);
  std::vector<u32> order, stack{0};
  std::vector<u8> seen(n);
  while (!stack.empty()) {
    const u32 x = stack.back();
    stack.pop_back();
    if (seen[x]) continue;
    seen[x] = 1;
    order.push_back(x);
    for (i64 k = g.offsets[x + 1]; k-- > g.offsets[x];) stack.push_back(static_cast<u32>(g.targets[k]));
  }
  return order;
}

// `first` before all others, which keep their order.
std::vector<u32> beginning_with(const std::vector<u32>& first, const std::vector<u32>& order) {
  std::vector<u32> out(first);
  std::vector<u8> seen(order.size());
  for (const u32 x : first) seen[x] = 1;
  for (const u32 x : order)
    if (!seen[x]) out.push_back(x);
  return out;
}

// The same numbers on every machine.
struct Chance {
  u64 state = 0x9e3779b97f4a7c15u;
  u64 below(u64 n) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return (state >> 11) % n;
  }
  void shuffle(std::vector<u32>& values) {
    for (u64 k = values.size(); k > 1; --k) std::swap(values[k - 1], values[below(k)]);
  }
};

}  // namespace

Cells reduce(const Duties& d, Ticker& ticker) {
  const u64 n = static_cast<u64>(d.moves.n_states), m = static_cast<u64>(d.moves.offsets[n]);
  if (n == 0) return {{}, 0};
  ticker.check(n, m, 2 * n * (n / 8) + n * d.n_events * sizeof(u32));
  const Patterns patterns(d);
  const Matrix apart = conflicts(d, patterns, ticker);
  const std::vector<u32> distinct = clique(apart, n, ticker);

  std::vector<u32> given(n);  // breadth-first: the order of TCT
  std::iota(given.begin(), given.end(), 0);
  Cells best{{}, distinct.size()};
  std::vector<u32> best_order;
  u64 fewest = n + 1, work = 0;
  auto attempt = [&](const std::vector<u32>& order) {
    Partition partition(d, patterns, apart);
    const u64 count = partition.merge_all(order, ticker);
    work += partition.work + n * apart.n_words();
    if (count < fewest) best.cell = partition.cells();
    if (count <= fewest) fewest = count, best_order = order;
  };
  attempt(given);
  const u64 most = std::max(kTimes * work, kFreeWork);
  auto open = [&] { return fewest > best.lower_bound && work < most; };
  if (open()) attempt(beginning_with(distinct, given));
  if (open()) attempt({given.rbegin(), given.rend()});
  if (open()) attempt(depth_first(d.moves));
  Chance chance;
  for (u64 pass = 0; pass < kMostPasses && open(); ++pass) {
    std::vector<u32> order(best_order);
    if (pass % 2) {  // keep the best cells together, and take them in another order
      std::vector<u32> rank(fewest);
      std::iota(rank.begin(), rank.end(), 0);
      chance.shuffle(rank);
      std::stable_sort(order.begin(), order.end(),
                       [&](u32 x, u32 y) { return rank[best.cell[x]] < rank[best.cell[y]]; });
    } else {  // change places, few or many
      for (u64 left = 1 + n / (4 + chance.below(200)); left; --left)
        std::swap(order[chance.below(n)], order[chance.below(n)]);
    }
    attempt(order);
  }
  return best;
}

}  // namespace thenar

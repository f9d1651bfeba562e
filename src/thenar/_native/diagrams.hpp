// Multi-valued decision diagrams: sets of state vectors, and relations between them.
//
// Level n is the top, level 1 the bottom. A set is fully reduced: a node whose children are all equal does not exist,
// so a level that a set skips may have any value. A relation is identity-reduced: a level that it skips keeps its value.
#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common.hpp"

namespace thenar {

using Node = u32;      // a set
using Relation = u32;  // a set of pairs (before, after)
constexpr Node kNothing = 0, kEverything = 1;
constexpr Relation kNever = 0, kIdentity = 1;
constexpr u32 kFamily = 16, kMaxFamilies = 60;  // keys of the cache from 16 to 255 are those of Saturation

// Results of operations, found again by up to four keys; an entry may be overwritten at any time.
class OperationCache {
 public:
  explicit OperationCache(u64 max_bytes) : max_entries_(std::bit_floor(std::max<u64>(max_bytes / sizeof(Entry), 1024))) {
    entries_.resize(std::min<u64>(1 << 12, max_entries_));
  }
  bool find(u32 a, u32 b, u32 c, u32 d, u32& result) const {
    const Entry& e = entries_[slot(a, b, c, d)];
    if (e.a != a || e.b != b || e.c != c || e.d != d) return false;
    result = e.result;
    return true;
  }
  void store(u32 a, u32 b, u32 c, u32 d, u32 result) {
    entries_[slot(a, b, c, d)] = {a, b, c, d, result};
    if (++stored_ > 2 * entries_.size() && entries_.size() < max_entries_) grow();
  }
  // Forget what mentions a dead node; `alive` answers for operation a, its keys and its result.
  template <class Alive>
  void sweep(Alive alive) {
    for (Entry& e : entries_)
      if (e.a && !alive(e)) e = {};
  }
  u64 bytes() const { return entries_.size() * sizeof(Entry); }

  struct Entry {
    u32 a = 0, b = 0, c = 0, d = 0, result = 0;  // a = 0: empty
  };

 private:
  u64 slot(u64 a, u64 b, u64 c, u64 d) const {
    u64 h = (a << 32 | b) * 0x9e3779b97f4a7c15ull;
    h = (h ^ h >> 29 ^ (c << 32 | d)) * 0xbf58476d1ce4e5b9ull;
    return (h ^ h >> 32) & (entries_.size() - 1);
  }
  void grow();
  std::vector<Entry> entries_;
  u64 max_entries_, stored_ = 0;
};

// Thrown where an operation has taken all the steps that it was given.
struct OutOfSteps {};

struct Pair {
  u32 from, to;
  Relation next;
  auto operator<=>(const Pair&) const = default;
};

// The nodes of all sets and relations over one tuple of finite domains.
class Forest {
 public:
  // sizes[k]: number of values of level k + 1.
  // `collect_at`: nodes from which on garbage is looked for.
  Forest(std::vector<u32> sizes, u64 max_bytes, u64 cache_bytes, u64 collect_at);

  u32 n_levels() const { return static_cast<u32>(sizes_.size()) - 1; }
  u32 size(u32 level) const { return sizes_[level]; }
  u32 level(Node n) const { return level_[n]; }
  Node child(Node n, u32 level, u32 value) const { return level_[n] == level ? kids_[first_[n] + value] : n; }
  // Whether only one level matters.
  bool is_literal(Node n) const {
    if (n <= kEverything) return true;
    const Node* kids = &kids_[first_[n]];
    return std::all_of(kids, kids + sizes_[level_[n]], [](Node kid) { return kid <= kEverything; });
  }
  Node make(u32 level, const Node* kids);

  Node unite(Node a, Node b);
  Node intersect(Node a, Node b);
  Node subtract(Node a, Node b);
  // The vectors whose value at `level` is one of those with mask[value] != 0.
  Node literal(u32 level, const u8* mask);
  // A set over `levels` (falling), given by its characteristic table in row-major order.
  Node table(const std::vector<u32>& levels, const u8* truth);
  // Any set between `set` and the complement of `care` minus it that has few nodes: equal to `set` within `care`.
  Node simplify(Node set, Node care);
  // Sets over separate levels whose intersection is `set`, the topmost first: the diagram cut wherever all of it
  // passes through one node.
  std::vector<Node> factors(Node set);
  // A sum of few products between `low` and `high` (low ⊆ high); stops with false at more than `limit` products.
  struct Literal {
    u32 level;
    std::vector<u32> values;
  };
  using Product = std::vector<Literal>;
  bool products(Node low, Node high, u64 limit, std::vector<Product>& out);
  // Let the levels with levels[k] != 0 take any value.
  Node forget(Node set, const std::vector<u8>& levels);

  // Relations.
  Relation step(u32 level, std::vector<Pair> pairs);
  Relation join(Relation a, Relation b);            // both, on disjoint levels
  Relation either(Relation a, Relation b);          // one or the other
  Relation restrict(Relation r, Node before);       // where `before` holds before
  Relation inverse(Relation r);
  Relation rows(const std::vector<u32>& levels, const u32* before_after, u64 n_rows);  // explicit pairs; levels falling
  std::vector<u32> relation_support(Relation r);
  Node domain(Relation r);
  Node image(Node set, Relation r);
  bool has_relation(Relation r) const { return r < steps_.size(); }
  u32 relation_level(Relation r) const { return steps_[r].level; }
  const Pair* begin(Relation r) const { return pairs_.data() + steps_[r].first; }
  const Pair* end(Relation r) const { return begin(r) + steps_[r].count; }

  // |set| over levels 1 .. n, as little-endian words.
  std::vector<u64> count(Node set);
  // How many steps each of `relations` has from `set` to `set`, all together.
  std::vector<u64> count_steps(Node set, const std::vector<Relation>& relations);
  std::vector<u32> support(Node set);
  // The value of each level, levels rising, level 0 unused.
  using State = std::vector<u32>;
  bool contains(Node set, const State& state) const;
  // Which of `relations` have a step from the state into `set`.
  std::vector<u8> lead_into(Node set, const State& state, const std::vector<Relation>& relations) const;
  u64 n_nodes(Node set);
  // The vectors of `set` in lexicographic order from the top level, at most `limit` of them: row by row, top first.
  std::vector<u32> vectors(Node set, u64 limit);
  // The steps of r that leave `from` (a part of `set`) and enter `set`, as numbers of the vectors of `set` in the
  // order of vectors(); `set` has fewer than 2^32 of them.
  void steps(Node set, Node from, Relation r, std::vector<u32>& sources, std::vector<u32>& targets);
  // Nodes of `set` bottom-up: (level, kids...) each; what explanations, guards and files are made of.
  std::vector<u32> dump(Node set, std::vector<u32>& order);

  // Results of different sets of relations are kept apart in the cache by a small number.
  u32 join_family();
  void leave_families(u64 which);  // a bit for each

  // Nodes that are referred to from outside, or by an operation in progress, survive a collection.
  void hold(Node n) { if (n > 1) ++held_[n]; }
  void drop(Node n) { if (n > 1 && --held_[n] == 0) held_.erase(n); }
  std::vector<Node>& stack() { return stack_; }
  OperationCache& cache() { return cache_; }
  bool collection_is_due() const { return n_alive_ > threshold_; }
  void collect();
  u64 n_alive() const { return n_alive_; }
  u64 n_peak() const { return n_peak_; }
  u64 n_collections() const { return n_collections_; }
  u64 bytes() const;
  void check_bytes() const;
  u64 max_bytes;
  Ticker* ticker = nullptr;       // of the operation in progress
  std::shared_ptr<Ticker> watch;  // of operations that are given none
  bool busy = false;              // at work on a thread of its own; guarded by the GIL
  std::vector<Node> dropped_meanwhile;
  u64 left_meanwhile = 0;  // a bit for each family
  static constexpr u64 kCostOfStep = 8;  // in what a ticker counts
  u64 work = 0, told = 0, last_step = ~u64{0};
  void tick() {
    if (++work & 255) return;
    if (work > last_step) throw OutOfSteps();
    check_bytes();
    if (ticker) ticker->tick(256 * kCostOfStep, n_alive_, work);
  }

 private:
  enum Operation : u32 { kUnite = 1, kIntersect, kSubtract, kImage, kSimplify, kForget };
  static constexpr u64 kManyNodes = 1 << 25;  // about a gigabyte
  u32 top(Node a, Node b) const { return std::max(level_[a], level_[b]); }
  template <class F>
  Node apply(u32 level, Node a, Node b, F combine);
  void rehash(u64 capacity);
  u64 hash(u32 level, const Node* kids) const;
  Node forget(Node set, const std::vector<u8>& levels, std::unordered_map<Node, Node>& memo);
  Relation rows(const std::vector<u32>& levels, u32 depth, std::vector<const u32*>& pointers, u64 lo, u64 hi);
  std::vector<Node> bottom_up(Node set);
  struct Walk;
  class StepCounter;
  struct Way;
  Node replace(Node n, Node old, std::unordered_map<Node, Node>& memo);
  Node cover(Node low, Node high, u64 limit, Product& prefix, std::vector<Product>& out);

  std::vector<u32> sizes_;  // sizes_[0] unused
  Buffer<Node> kids_;
  Buffer<u32> first_, level_;  // of each node
  std::vector<std::vector<Node>> free_;  // of each level
  std::vector<u32> unique_;
  u64 n_alive_ = 0, n_peak_ = 0, n_collections_ = 0, threshold_;
  OperationCache cache_;
  std::unordered_map<Node, u32> held_;
  std::vector<Node> stack_;
  std::vector<u32> seen_;  // of each node the last walk that came by
  u32 walk_ = 0;
  u64 families_ = 0;

  struct Step {
    u32 level, first, count;
  };
  std::vector<Step> steps_;
  std::vector<Pair> pairs_;
  std::unordered_multimap<u64, Relation> known_steps_;
  std::unordered_map<Relation, Node> domains_;
  std::unordered_map<Relation, Relation> inverses_;
  using Memo = std::unordered_map<u64, Relation>;  // by two numbers, the second one below
  Relation join(Relation a, Relation b, Memo& memo);
  Relation either(Relation a, Relation b, Memo& memo);
  Relation restrict(Relation r, Node before, Memo& memo);
};

// Gives operations a number of steps, or what is left of those they have, as long as it lives.
class StepBudget {
 public:
  StepBudget(Forest& forest, u64 steps) : forest_(forest), before_(forest.last_step) {
    if (steps < before_ - forest.work) forest.last_step = forest.work + steps;
  }
  ~StepBudget() { forest_.last_step = before_; }
  StepBudget(const StepBudget&) = delete;
  StepBudget& operator=(const StepBudget&) = delete;

 private:
  Forest& forest_;
  const u64 before_;
};

// Keeps nodes alive while an operation is at work on them.
class Frame {
 public:
  Frame(Forest& forest, std::initializer_list<Node> nodes, u32 extra = 0)
      : stack_(forest.stack()), base_(stack_.size()), first_(base_ + nodes.size()) {
    stack_.insert(stack_.end(), nodes);
    stack_.resize(first_ + extra, kNothing);
  }
  ~Frame() { stack_.resize(base_); }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  Node& operator[](u32 k) { return stack_[first_ + k]; }
  const Node* data() const { return stack_.data() + first_; }

 private:
  std::vector<Node>& stack_;
  u64 base_, first_;
};

}  // namespace thenar

// Tables that answer, for a packed product state: which events are enabled, and where does one lead.
#pragma once

#include <algorithm>

#include "groups.hpp"

namespace thenar {

template <class Word_, int W>
struct Key {
  using Word = Word_;
  static constexpr int kWords = W;
  Word w[W];
  bool operator==(const Key&) const = default;
};

template <class K>
inline u64 hash(const K& key) {
  u64 h = 0;
  for (const u64 word : key.w) {  // multiply, fold, multiply: the upper bits depend on all bits of the key
    h = (h ^ word) * 0x9e3779b97f4a7c15u;
    h = (h ^ h >> 32) * 0xd6e8feb86659fd93u;
  }
  return h;
}

inline u64 low_bits(u32 n) { return n == 64 ? ~u64{0} : (u64{1} << n) - 1; }

// What one look at a state says, besides the events that are enabled.
struct Look {
  bool plants_marked, specs_marked;
  u32 index;  // once make_index() has numbered the states
};

template <class K>
class Product {
  using Word = typename K::Word;

 public:
  Product(const std::vector<Component>& components, const std::vector<u8>& uncontrollable, const Packing& packing)
      : n_events_(uncontrollable.size()), n_words_(n_events_ / 64 + 1), uncontrollable_(n_words_), valid_(n_words_) {
    for (u64 e = 0; e < n_events_; ++e)
      if (uncontrollable[e]) set(uncontrollable_, e);
    for (const Component& c : components)  // an event that no component has never happens
      for (u64 e = 0; e < n_events_; ++e)
        if (c.own[e]) set(valid_, e);
    set(valid_, marker());
    std::vector<std::vector<Move>> moves(n_events_);
    parts_.reserve(packing.groups.size());
    for (const Group& g : packing.groups) add(components, g, packing.layout, moves);
    // Most events are padded to the same number of moves, which a branch predictor learns.
    u64 usual = 0;
    for (const auto& own : moves) usual = std::min<u64>(std::max<u64>(usual, own.size()), 2);
    first_.push_back(0);
    for (auto& own : moves) {
      own.resize(std::max<u64>(own.size(), usual), Move{&nothing_, 0, 0, 0, 0, 0, nullptr});
      moves_.insert(moves_.end(), own.begin(), own.end());
      first_.push_back(static_cast<u32>(moves_.size()));
    }
  }
  Product(const Product&) = delete;
  Product& operator=(const Product&) = delete;

  u64 event_words() const { return n_words_; }
  u64 bytes() const {
    u64 total = moves_.size() * sizeof(Move);
    for (const Part& t : parts_)
      total += t.rows.size() * sizeof(u64) + t.entries.size() * sizeof(Entry) + t.base.size() * sizeof(u32);
    return total;
  }
  const K& initial() const { return initial_; }
  const u64* uncontrollable() const { return uncontrollable_.data(); }

  // Write the events that the plants can do and those that the specifications allow, one bit an event.
  // `Narrow` promises that event_words() is 1, `Indexed` that make_index() came before.
  template <bool Narrow = false, bool Indexed = false>
  Look enabled(const K& key, u64* plant, u64* spec) const {
    u32 index = 0;
    if constexpr (Narrow) {
      u64 can = valid_[0], may = valid_[0];
      for (const Part& t : parts_) {
        const u64 code = t.code(key);
        can &= t.rows[code * 2];
        may &= t.rows[code * 2 + 1];
        if constexpr (Indexed) index += t.base[code];
      }
      *plant = can;
      *spec = may;
    } else {
      for (u64 w = 0; w < n_words_; ++w) plant[w] = spec[w] = valid_[w];
      for (const Part& t : parts_) {
        const u64 code = t.code(key), n = t.words.size();
        const u64* row = t.rows.data() + code * 2 * n;
        for (u64 w = 0; w < n; ++w) {
          plant[t.words[w]] &= row[w];
          spec[t.words[w]] &= row[n + w];
        }
        if constexpr (Indexed) index += t.base[code];
      }
    }
    const u64 top = Narrow ? 0 : marker() / 64, bit = u64{1} << marker() % 64;
    const Look look{(plant[top] & bit) != 0, (spec[top] & bit) != 0, index};
    plant[top] &= ~bit;
    spec[top] &= ~bit;
    return look;
  }

  // The state after an enabled event; `index` goes along.
  K after(const K& key, u64 event, u32& index) const {
    K next = key;
    for (u32 k = first_[event], end = first_[event + 1]; k < end; ++k) {
      const Move& m = moves_[k];
      const u32 word = K::kWords == 1 ? 0 : m.word;
      const u64 code = key.w[word] >> m.shift & m.mask;
      const Entry entry = m.entries ? m.entries[code * m.n_local] : search(m, code, event);
      next.w[word] ^= static_cast<Word>(entry.flip) << m.shift;
      index += entry.step;
    }
    return next;
  }

  // The number of a state, once make_index() has made them.
  u32 index(const K& key) const {
    u32 index = 0;
    for (const Part& t : parts_) index += t.base[t.code(key)];
    return index;
  }

  // Number the states by mixed radix, a digit a group: the states that it can be in, were it for it alone.
  // Return how many numbers there are; 0 if they are more than an index can tell apart.
  u64 make_index() {
    std::vector<Bits> reached;
    u64 span = 1;
    for (const Part& t : parts_) {
      u64 count = 0;
      reached.push_back(this->reached(t));
      for (u64 w = 0; w < reached.back().n_words(); ++w) count += count_ones(reached.back().word(w));
      if (count > kNone / span) return 0;
      span *= count;
    }
    u32 stride = 1;
    for (u64 i = 0; i < parts_.size(); ++i) {
      Part& t = parts_[i];
      t.base.assign(t.n_codes, 0);
      u32 count = 0;
      for (u64 code = 0; code < t.n_codes; ++code)
        if (reached[i][code]) t.base[code] = stride * count++;
      for (u64 code = 0; code < t.n_codes; ++code)
        for (u64 k = 0; reached[i][code] && !t.entries.empty() && k < t.local.size(); ++k) {
          Entry& entry = t.entries[code * t.local.size() + k];
          entry.step = t.base[code ^ entry.flip] - t.base[code];
        }
      stride *= count;
    }
    return span;
  }

 private:
  struct Entry {
    u32 flip = 0;  // the bits of the code that change
    u32 step = 0;  // what is added to the index
  };
  struct Move {
    const Entry* entries;  // (codes, n_local); null: search the row
    u64 mask;
    u32 n_local, word, shift, part;
    const Graph* graph;
  };
  struct Part {
    u32 word, shift;
    u64 mask, n_codes;
    std::vector<u32> words;      // the event words that its components have a say in
    std::vector<u64> rows;       // (codes, 2, words): what its plants can do, what its specifications allow
    std::vector<u32> local;      // the events that move it
    std::vector<Entry> entries;  // (codes, local)
    std::vector<u64> closed;     // (n_words) the events of no plant outside
    std::vector<u32> base;       // (codes) its part of the index
    u64 code(const K& key) const { return key.w[K::kWords == 1 ? 0 : word] >> shift & mask; }
  };

  // The bit after the last event says whether every component is in a marked state.
  u64 marker() const { return n_events_; }
  static void set(std::vector<u64>& bits, u64 k) { bits[k / 64] |= u64{1} << k % 64; }
  static bool has(const std::vector<u64>& bits, u64 k) { return bits[k / 64] >> k % 64 & 1; }

  Entry search(const Move& m, u64 q, u64 event) const {
    const Graph& g = *m.graph;
    const i32* lo = g.events + g.offsets[q];
    const i32* hi = g.events + g.offsets[q + 1];
    const u64 t = static_cast<u64>(g.targets[std::lower_bound(lo, hi, static_cast<i32>(event)) - g.events]);
    const auto& base = parts_[m.part].base;
    return {static_cast<u32>(q ^ t), base.empty() ? 0 : base[t] - base[q]};
  }

  // The bits in which one component has a say: its alphabet, and the marker unless all its states are marked.
  std::vector<u64> say(const Component& c) const {
    std::vector<u64> own(n_words_);
    for (u64 e = 0; e < n_events_; ++e)
      if (c.own[e]) set(own, e);
    if (!std::all_of(c.marked, c.marked + c.graph.n_states, [](u8 m) { return m != 0; })) set(own, marker());
    return own;
  }

  // Call f for the codes of a group in which the component at `shift` of `bits` is in state q.
  template <class F>
  static void for_codes(u64 n_codes, u32 shift, u32 bits, u64 q, F&& f) {
    const u64 stride = u64{1} << shift, period = stride << bits;
    for (u64 high = q * stride; high < n_codes; high += period)
      for (u64 code = high; code < std::min(high + stride, n_codes); ++code) f(code);
  }

  void add(const std::vector<Component>& components, const Group& group, const Layout& layout,
           std::vector<std::vector<Move>>& moves) {
    const bool alone = group.members.size() == 1;
    const Component& first = components[group.members[0]];
    Part& t = parts_.emplace_back();
    t.word = group.word;
    t.shift = group.shift;
    t.mask = low_bits(group.bits);
    t.n_codes = alone ? static_cast<u64>(first.graph.n_states) : u64{1} << group.bits;

    std::vector<u64> any(n_words_), moved(n_words_);
    for (const u32 c : group.members) {
      const auto own = say(components[c]);
      for (u64 w = 0; w < n_words_; ++w) any[w] |= own[w];
      const Graph& g = components[c].graph;  // an event that only loops never moves
      for (i64 q = 0; q < g.n_states; ++q)
        for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k)
          if (g.targets[k] != q) set(moved, g.events[k]);
      initial_.w[t.word] |= static_cast<Word>(static_cast<u64>(components[c].initial) << layout.shifts[c]);
    }
    for (u64 w = 0; w < n_words_; ++w)
      if (any[w] || n_words_ == 1) t.words.push_back(static_cast<u32>(w));
    const u64 n = t.words.size();
    t.rows.assign(t.n_codes * 2 * n, ~u64{0});

    std::vector<u32> place(n_events_);
    for (u64 e = 0; e < n_events_; ++e)
      if (has(moved, e)) place[e] = static_cast<u32>(t.local.size()), t.local.push_back(static_cast<u32>(e));
    const u64 n_local = t.local.size();
    const bool dense = !alone || t.n_codes * n_local <= kDenseEntries;
    if (dense) t.entries.resize(t.n_codes * n_local);
    for (const u32 e : t.local)
      moves[e].push_back({dense ? t.entries.data() + place[e] : nullptr, t.mask, static_cast<u32>(n_local), t.word,
                          t.shift, static_cast<u32>(parts_.size() - 1), &first.graph});

    std::vector<u64> enabled(n_words_);
    for (const u32 c : group.members) {
      const Component& part = components[c];
      const auto own = say(part);
      const u32 bits = layout.bits[c], within = bits ? layout.shifts[c] - t.shift : 0;
      for (i64 q = 0; q < part.graph.n_states; ++q) {
        for (u64 w = 0; w < n_words_; ++w) enabled[w] = ~own[w];
        for (i64 k = part.graph.offsets[q]; k < part.graph.offsets[q + 1]; ++k) {
          const i32 e = part.graph.events[k], target = part.graph.targets[k];
          set(enabled, e);
          if (!dense || target == q) continue;
          const u32 flip = static_cast<u32>(q ^ target) << within;
          for_codes(t.n_codes, within, bits, q, [&](u64 code) { t.entries[code * n_local + place[e]].flip |= flip; });
        }
        if (part.marked[q]) set(enabled, marker());
        for_codes(t.n_codes, within, bits, q, [&](u64 code) {
          for (u64 w = 0; w < n; ++w) t.rows[(code * 2 + !part.plant) * n + w] &= enabled[t.words[w]];
        });
      }
    }
    // make_index() asks which events the plants of this group can do whatever the others do.
    t.closed.assign(n_words_, ~u64{0});
    if (alone) return;
    std::vector<u8> inside(components.size());
    for (const u32 c : group.members) inside[c] = 1;
    for (u64 c = 0; c < components.size(); ++c)
      for (u64 e = 0; e < n_events_ && components[c].plant && !inside[c]; ++e)
        if (components[c].own[e]) t.closed[e / 64] &= ~(u64{1} << e % 64);
  }

  // The codes that a group reaches if nothing outside hinders it; illegal ones are not expanded.
  Bits reached(const Part& t) const {
    constexpr u64 kMostCodes = 1 << 12;
    if (t.n_codes > kMostCodes || t.entries.size() != t.n_codes * t.local.size()) return Bits(t.n_codes, true);
    Bits seen(t.n_codes);
    std::vector<u64> stack{t.code(initial_)};
    seen.set(stack[0]);
    const u64 n = t.words.size();
    std::vector<u64> both(n_words_);
    while (!stack.empty()) {
      const u64 code = stack.back();
      stack.pop_back();
      std::fill(both.begin(), both.end(), ~u64{0});
      bool illegal = false;
      for (u64 w = 0; w < n; ++w) {
        const u64 plant = t.rows[code * 2 * n + w], spec = t.rows[(code * 2 + 1) * n + w], word = t.words[w];
        illegal |= (plant & ~spec & uncontrollable_[word] & t.closed[word]) != 0;
        both[word] = plant & spec;
      }
      for (u64 k = 0; !illegal && k < t.local.size(); ++k) {
        if (!has(both, t.local[k])) continue;
        const u64 next = code ^ t.entries[code * t.local.size() + k].flip;
        if (!seen[next]) seen.set(next), stack.push_back(next);
      }
    }
    return seen;
  }

  static constexpr u64 kDenseEntries = 1 << 22;  // 32 to 64 MiB a component; beyond that a row is searched

  u64 n_events_, n_words_;
  std::vector<u64> uncontrollable_, valid_;
  std::vector<Move> moves_;
  std::vector<u32> first_;  // (n_events + 1) where the moves of each event begin
  std::vector<Part> parts_;
  Entry nothing_;
  K initial_{};
};

}  // namespace thenar

// Tables that answer, for a packed product state: which events are enabled, and where does one lead.
#pragma once

#include <algorithm>

#include "explore.hpp"

namespace thenar {

template <int W>
struct Key {
  u64 w[W];
  bool operator==(const Key&) const = default;
};

template <int W>
inline u64 hash(const Key<W>& key) {
  u64 h = 0;
  for (int i = 0; i < W; ++i) {  // the finaliser of splitmix64, chained over the words
    h ^= key.w[i];
    h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 27) * 0x94d049bb133111ebu;
    h ^= h >> 31;
  }
  return h;
}

inline Layout pack(const std::vector<Component>& components) {
  Layout layout;
  u32 word = 0, used = 0;
  for (const auto& c : components) {
    const u32 bits = static_cast<u32>(std::bit_width(static_cast<u64>(c.graph.n_states - 1)));  // 0 for one state
    if (used + bits > 64) ++word, used = 0;  // no field crosses a word
    layout.words.push_back(word);
    layout.shifts.push_back(used % 64);  // a field of no bits may lie anywhere
    layout.bits.push_back(bits);
    used += bits;
  }
  layout.n_words = word + 1;
  return layout;
}

inline u64 low_bits(u32 n) { return n == 64 ? ~u64{0} : (u64{1} << n) - 1; }

template <int W>
class Product {
 public:
  Product(const std::vector<Component>& components, const std::vector<u8>& uncontrollable, const Layout& layout)
      : n_events_(uncontrollable.size()), n_words_(n_events_ / 64 + 1), uncontrollable_(n_words_), moves_(n_events_) {
    for (u64 e = 0; e < n_events_; ++e)
      if (uncontrollable[e]) uncontrollable_[e / 64] |= u64{1} << e % 64;
    valid_.assign(n_words_, 0);  // an event that no component has never happens
    for (const Component& c : components)
      for (u64 e = 0; e < n_events_; ++e)
        if (c.own[e]) valid_[e / 64] |= u64{1} << e % 64;
    valid_.back() |= u64{1} << marker() % 64;
    for (u64 c = 0; c < components.size(); ++c) {
      const Field field{layout.words[c], layout.shifts[c], low_bits(layout.bits[c])};
      add_moves(components[c], field);
      initial_.w[field.word] |= static_cast<u64>(components[c].initial) << field.shift;
    }
    // Neighbouring small components share one table: one look-up instead of many.
    constexpr u32 kGroupBits = 10;
    for (u64 first = 0, last; first < components.size(); first = last) {
      u32 bits = layout.bits[first];
      for (last = first + 1; last < components.size() && layout.words[last] == layout.words[first] &&
                             layout.shifts[last] >= layout.shifts[first] && bits + layout.bits[last] <= kGroupBits;)
        bits += layout.bits[last++];
      add_group(components, layout, first, last, bits);
    }
  }

  u64 event_words() const { return n_words_; }
  u64 bytes() const {
    u64 words = 0;
    for (const Group& g : groups_) words += g.rows.size();
    for (const auto& table : dense_) words += table.size();
    return words * sizeof(u64);
  }
  const Key<W>& initial() const { return initial_; }
  const u64* uncontrollable() const { return uncontrollable_.data(); }
  struct Marked {
    bool plants, specs;
  };
  // Write the events that the plants can do and those that the specifications allow, one bit an event; return who
  // is in a marked state.
  Marked enabled(const Key<W>& key, u64* plant, u64* spec) const {
    for (u64 w = 0; w < n_words_; ++w) plant[w] = spec[w] = valid_[w];
    for (const Group& g : groups_) {
      const u64 n = g.words.size();
      const u64* row = g.rows.data() + (key.w[g.field.word] >> g.field.shift & g.field.mask) * 2 * n;
      for (u64 w = 0; w < n; ++w) {
        plant[g.words[w]] &= row[w];
        spec[g.words[w]] &= row[n + w];
      }
    }
    const u64 top = marker() / 64, bit = u64{1} << marker() % 64;
    const Marked marked{(plant[top] & bit) != 0, (spec[top] & bit) != 0};
    plant[top] &= ~bit;
    spec[top] &= ~bit;
    return marked;
  }

  // The state after an enabled event.
  Key<W> after(Key<W> key, u64 event) const {
    for (const Move& m : moves_[event]) {
      u64 q = key.w[m.field.word] >> m.field.shift & m.field.mask;
      u64 flip = m.dense ? m.dense[q * m.stride + m.local] : (q ^ search(*m.graph, q, event)) << m.field.shift;
      key.w[m.field.word] ^= flip;
    }
    return key;
  }

 private:
  struct Field {
    u32 word, shift;
    u64 mask;
  };
  struct Group {
    Field field;
    std::vector<u32> words;  // the event words that its components have a say in
    std::vector<u64> rows;   // (states, 2, words): what its plants can do, what its specifications allow
  };
  struct Move {
    Field field;
    const u64* dense;  // (n_states, stride): the bits that flip; null: search the row
    u64 stride, local;
    const Graph* graph;
  };

  // The bit after the last event says whether every component is in a marked state.
  u64 marker() const { return n_events_; }

  static u64 search(const Graph& g, u64 q, u64 event) {
    const i32* lo = g.events + g.offsets[q];
    const i32* hi = g.events + g.offsets[q + 1];
    return static_cast<u64>(g.targets[std::lower_bound(lo, hi, static_cast<i32>(event)) - g.events]);
  }

  // The bits in which one component has a say: its alphabet, and the marker unless all its states are marked.
  std::vector<u64> say(const Component& c) const {
    std::vector<u64> own(n_words_);
    for (u64 e = 0; e < n_events_; ++e)
      if (c.own[e]) own[e / 64] |= u64{1} << e % 64;
    if (!std::all_of(c.marked, c.marked + c.graph.n_states, [](u8 m) { return m != 0; }))
      own[marker() / 64] |= u64{1} << marker() % 64;
    return own;
  }

  void add_group(const std::vector<Component>& components, const Layout& layout, u64 first, u64 last, u32 bits) {
    const u32 base = layout.shifts[first];
    Group g{{layout.words[first], base, low_bits(bits)}, {}, {}};
    std::vector<u64> any(n_words_);
    for (u64 c = first; c < last; ++c) {
      const auto own = say(components[c]);
      for (u64 w = 0; w < n_words_; ++w) any[w] |= own[w];
    }
    for (u64 w = 0; w < n_words_; ++w)
      if (any[w]) g.words.push_back(static_cast<u32>(w));
    const u64 n = g.words.size();
    const u64 n_rows = last - first == 1 ? static_cast<u64>(components[first].graph.n_states) : u64{1} << bits;
    g.rows.assign(n_rows * 2 * n, ~u64{0});
    std::vector<u64> enabled(n_words_);
    for (u64 c = first; c < last && n; ++c) {
      const Component& part = components[c];
      const auto own = say(part);
      const u64 stride = u64{1} << (layout.shifts[c] - base);  // rows that differ in this component's state only
      for (i64 q = 0; q < part.graph.n_states; ++q) {
        for (u64 w = 0; w < n_words_; ++w) enabled[w] = ~own[w];
        for (i64 k = part.graph.offsets[q]; k < part.graph.offsets[q + 1]; ++k)
          enabled[part.graph.events[k] / 64] |= u64{1} << part.graph.events[k] % 64;
        if (part.marked[q]) enabled[marker() / 64] |= u64{1} << marker() % 64;
        const u64 period = stride << layout.bits[c];
        for (u64 high = static_cast<u64>(q) * stride; high < n_rows; high += period)
          for (u64 row = high; row < std::min(high + stride, n_rows); ++row)
            for (u64 w = 0; w < n; ++w) g.rows[(row * 2 + !part.plant) * n + w] &= enabled[g.words[w]];
      }
    }
    groups_.push_back(std::move(g));
  }

  void add_moves(const Component& c, const Field& field) {
    constexpr u64 kDenseEntries = 1 << 22;  // 32 MiB a component; beyond that a row is searched
    std::vector<u64> local(n_events_);
    u64 stride = 0;
    for (u64 e = 0; e < n_events_; ++e)
      if (c.own[e]) local[e] = stride++;
    u64* dense = nullptr;
    if (static_cast<u64>(c.graph.n_states) * stride <= kDenseEntries)
      dense = dense_.emplace_back(static_cast<u64>(c.graph.n_states) * stride).data();
    std::vector<u8> moves(n_events_);  // an event that only loops here never changes this field
    for (i64 q = 0; q < c.graph.n_states; ++q)
      for (i64 k = c.graph.offsets[q]; k < c.graph.offsets[q + 1]; ++k) {
        const i32 e = c.graph.events[k], t = c.graph.targets[k];
        if (t != q) moves[e] = 1;
        if (dense) dense[static_cast<u64>(q) * stride + local[e]] = static_cast<u64>(q ^ t) << field.shift;
      }
    for (u64 e = 0; e < n_events_; ++e)
      if (moves[e]) moves_[e].push_back({field, dense, stride, local[e], &c.graph});
  }

  u64 n_events_, n_words_;
  std::vector<u64> uncontrollable_, valid_;
  std::vector<std::vector<Move>> moves_;
  std::vector<Group> groups_;
  std::vector<std::vector<u64>> dense_;
  Key<W> initial_{};
};

}  // namespace thenar

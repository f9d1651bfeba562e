// Tables that answer, for a packed product state: which events are enabled, and where does one lead.
#pragma once

#include <algorithm>
#include <stdexcept>

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
    const u32 bits = std::max<u32>(1, static_cast<u32>(std::bit_width(static_cast<u64>(c.graph.n_states - 1))));
    if (used + bits > 64) ++word, used = 0;  // no field crosses a word
    layout.words.push_back(word);
    layout.shifts.push_back(used);
    layout.bits.push_back(bits);
    used += bits;
  }
  layout.n_words = word + 1;
  return layout;
}

template <int W>
class Product {
 public:
  Product(const std::vector<Component>& components, const std::vector<u8>& uncontrollable, const Layout& layout)
      : n_events_(uncontrollable.size()), n_words_(n_events_ / 64 + 1), uncontrollable_(n_words_), moves_(n_events_) {
    for (u64 e = 0; e < n_events_; ++e)
      if (uncontrollable[e]) uncontrollable_[e / 64] |= u64{1} << e % 64;
    valid_.assign(n_words_, ~u64{0});
    valid_.back() = n_events_ % 64 == 63 ? ~u64{0} : (u64{2} << n_events_ % 64) - 1;
    masks_.reserve(components.size());
    fields_.reserve(components.size());
    for (u64 c = 0; c < components.size(); ++c) {
      fields_.push_back({layout.words[c], layout.shifts[c], (u64{1} << layout.bits[c]) - 1});
      if (layout.bits[c] == 64) fields_.back().mask = ~u64{0};
      add_masks(components[c]);
      add_moves(components[c], c);
      initial_.w[layout.words[c]] |= static_cast<u64>(components[c].initial) << layout.shifts[c];
    }
  }

  u64 event_words() const { return n_words_; }
  const Key<W>& initial() const { return initial_; }
  const u64* uncontrollable() const { return uncontrollable_.data(); }
  // The bit after the last event says whether every component is in a marked state.
  u64 marker() const { return n_events_; }

  // Write the events that the plants can do and those that the specifications allow, one bit an event.
  void enabled(const Key<W>& key, u64* plant, u64* spec) const {
    for (u64 w = 0; w < n_words_; ++w) plant[w] = spec[w] = valid_[w];
    for (u64 c = 0; c < masks_.size(); ++c) {
      const Mask& m = masks_[c];
      const u64* row = m.rows.data() + state(key, c) * m.words.size();
      u64* out = m.plant ? plant : spec;
      for (u64 w = 0; w < m.words.size(); ++w) out[m.words[w]] &= row[w];
    }
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
  struct Mask {
    bool plant;
    std::vector<u32> words;  // the event words that the component has a say in
    std::vector<u64> rows;   // (n_states, words): enabled or foreign events
  };
  struct Move {
    Field field;
    const u64* dense;  // (n_states, stride): the bits that flip; null: search the row
    u64 stride, local;
    const Graph* graph;
  };

  u64 state(const Key<W>& key, u64 c) const { return key.w[fields_[c].word] >> fields_[c].shift & fields_[c].mask; }

  static u64 search(const Graph& g, u64 q, u64 event) {
    const i32* lo = g.events + g.offsets[q];
    const i32* hi = g.events + g.offsets[q + 1];
    return static_cast<u64>(g.targets[std::lower_bound(lo, hi, static_cast<i32>(event)) - g.events]);
  }

  void add_masks(const Component& c) {
    bool all_marked = std::all_of(c.marked, c.marked + c.graph.n_states, [](u8 m) { return m != 0; });
    std::vector<u64> foreign(valid_);  // what a component has no say in is always enabled
    for (u64 e = 0; e < n_events_; ++e)
      if (c.own[e]) foreign[e / 64] &= ~(u64{1} << e % 64);
    if (!all_marked) foreign[marker() / 64] &= ~(u64{1} << marker() % 64);
    Mask m{c.plant, {}, {}};
    std::vector<u64> place(n_words_);
    for (u64 w = 0; w < n_words_; ++w)
      if (foreign[w] != valid_[w]) place[w] = m.words.size(), m.words.push_back(static_cast<u32>(w));
    const u64 n = m.words.size();
    m.rows.resize(static_cast<u64>(c.graph.n_states) * n);
    for (i64 q = 0; q < c.graph.n_states && n; ++q) {
      u64* row = m.rows.data() + static_cast<u64>(q) * n;
      for (u64 w = 0; w < n; ++w) row[w] = foreign[m.words[w]];
      for (i64 k = c.graph.offsets[q]; k < c.graph.offsets[q + 1]; ++k) {
        u64 e = static_cast<u64>(c.graph.events[k]);
        row[place[e / 64]] |= u64{1} << e % 64;
      }
      if (!all_marked && c.marked[q]) row[place[marker() / 64]] |= u64{1} << marker() % 64;
    }
    masks_.push_back(std::move(m));
  }

  void add_moves(const Component& c, u64 index) {
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
        if (dense) dense[static_cast<u64>(q) * stride + local[e]] = static_cast<u64>(q ^ t) << fields_[index].shift;
      }
    for (u64 e = 0; e < n_events_; ++e)
      if (moves[e]) moves_[e].push_back({fields_[index], dense, stride, local[e], &c.graph});
  }

  u64 n_events_, n_words_;
  std::vector<u64> uncontrollable_, valid_;
  std::vector<std::vector<Move>> moves_;
  std::vector<Field> fields_;
  std::vector<Mask> masks_;
  std::vector<std::vector<u64>> dense_;
  Key<W> initial_{};
};

}  // namespace thenar

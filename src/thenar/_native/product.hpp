// Tables that answer, for a product state in one number: which events are enabled, and where does one lead.
#pragma once

#include <algorithm>

#include "groups.hpp"

namespace thenar {

// A product state: the codes of its groups, in a mixed radix where 32 bits are enough, in fields of bits otherwise.
template <class Word_, int W>
struct Key {
  using Word = Word_;
  static constexpr int kWords = W;
  static constexpr bool kMixed = sizeof(Word) == 4;
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

inline u64 low_bits(u32 n) { return n >= 64 ? ~u64{0} : (u64{1} << n) - 1; }

// How many bits tell the codes of a group apart.
inline u32 code_bits(const Group& g) { return static_cast<u32>(std::bit_width(g.n_codes - 1)); }

// What one look at a state says, besides the events that are enabled.
struct Look {
  bool plants_marked, specs_marked;
};

template <class K>
class Product {
  using Word = typename K::Word;
  struct Part;

 public:
  Product(const std::vector<Component>& components, const std::vector<u8>& uncontrollable, std::vector<Group> groups,
          u64 first_radix)
      : n_events_(uncontrollable.size()), n_words_(n_events_ / 64 + 1), uncontrollable_(n_words_), valid_(n_words_) {
    for (u64 e = 0; e < n_events_; ++e)
      if (uncontrollable[e]) set(uncontrollable_, e);
    for (const Component& c : components)  // an event that no component has never happens
      for (u64 e = 0; e < n_events_; ++e)
        if (c.own[e]) set(valid_, e);
    set(valid_, n_events_);
    place_.resize(components.size());
    std::vector<std::vector<Move>> moves(n_events_);
    u64 unit = 1;
    u32 word = 0, shift = 0;
    for (Group& g : groups) {
      for (u32 k = 0; k < g.members.size(); ++k) place_[g.members[k]] = {static_cast<u32>(parts_.size()), k};
      Part& t = parts_.emplace_back();
      if (K::kMixed) {
        t.scale(unit);
        unit *= parts_.size() == 1 ? first_radix : g.n_codes;
      } else {
        if (shift + code_bits(g) > 64) ++word, shift = 0;
        t.word = word;
        t.shift = code_bits(g) ? shift : 0;  // a field of no bits may lie anywhere
        t.mask = low_bits(code_bits(g));
        shift += code_bits(g);
      }
      const u64 n_local = g.local.size();
      t.steps.resize(g.next.size());
      for (u64 code = 0; !g.next.empty() && code < g.n_codes; ++code)
        for (u64 k = code * n_local; k < (code + 1) * n_local; ++k) t.steps[k] = t.step(code, g.next[k]);
      g.next = {};
      for (u32 k = 0; k < n_local; ++k)
        moves[g.local[k]].push_back({static_cast<u32>(parts_.size() - 1), k, t.word, t.steps.empty()});
      t.component = g.members.empty() ? nullptr : &components[g.members[0]];
      t.group = std::move(g);
    }
    span_ = unit;
    // Most events are padded to the same number of moves, which a branch predictor learns.
    u64 usual = 0;
    for (const auto& own : moves) usual = std::min<u64>(std::max<u64>(usual, own.size()), 2);
    first_.push_back(0);
    for (auto& own : moves) {
      own.resize(std::max<u64>(own.size(), usual), Move{static_cast<u32>(parts_.size()), 0, 0, false});
      moves_.insert(moves_.end(), own.begin(), own.end());
      first_.push_back(static_cast<u32>(moves_.size()));
    }
  }
  // Puts the states of the components where a layout wants them.
  class Packer {
   public:
    // For n states: tables are made for many only.
    Packer(const Product& product, const Layout& layout, u64 n) : product_(product), layout_(layout) {
      for (const Part& t : product.parts_) {
        const Group& g = t.group;
        Table& table = tables_.emplace_back();
        if (g.members.empty()) continue;
        table.first = layout.words[g.members[0]];
        table.n_words = layout.words[g.members.back()] - table.first + 1;
        if (g.states.empty() || g.n_codes > n) continue;
        table.words.resize(g.n_codes * table.n_words);
        u64* words = table.words.data();
        for (u64 code = 0; code < g.n_codes; ++code, words += table.n_words) put(t, code, words, table.first);
      }
    }
    void operator()(const At& at, u64* out) const {
      for (u64 k = 0; k < tables_.size(); ++k) {
        const Table& table = tables_[k];
        if (table.words.empty()) {
          put(product_.parts_[k], at.code[k], out, 0);
        } else {
          for (u64 w = 0; w < table.n_words; ++w)
            out[table.first + w] |= table.words[at.code[k] * table.n_words + w];
        }
      }
    }

   private:
    struct Table {
      std::vector<u64> words;  // (codes, n_words), of the words from `first` on
      u64 first = 0, n_words = 0;
    };
    void put(const Part& t, u64 code, u64* out, u64 first) const {
      for (u64 k = 0; k < t.group.members.size(); ++k) {
        const u32 c = t.group.members[k];
        out[layout_.words[c] - first] |= static_cast<u64>(t.state(code, k)) << layout_.shifts[c];
      }
    }
    const Product& product_;
    const Layout& layout_;
    std::vector<Table> tables_;
  };

  Product(const Product&) = delete;
  Product& operator=(const Product&) = delete;

  u64 n_events() const { return n_events_; }
  u64 event_words() const { return n_words_; }
  u64 bytes() const {
    u64 total = moves_.size() * sizeof(Move);
    for (const Part& t : parts_)
      total += t.group.rows.size() * sizeof(u64) + t.steps.size() * sizeof(Word) + t.group.states.size() * sizeof(u32);
    return total;
  }
  const u64* uncontrollable() const { return uncontrollable_.data(); }
  void prepare(At& at) const {
    at.code.resize(parts_.size());
    at.steps.resize(parts_.size() + 1, &still_);  // one more for moves that are none
  }
  // The keys of product states are less than this, if they are of one word; the initial state is 0.
  u64 span() const { return span_; }

  // Write the events that the plants can do and those that the specifications allow, one bit an event.
  // `Narrow` promises that event_words() is 1.
  template <bool Narrow = false>
  Look enabled(const K& key, At& at, u64* plant, u64* spec) const {
    split(key, at);
    const u32* code = at.code.data();
    if constexpr (Narrow) {
      u64 can = valid_[0], may = valid_[0];
      for (const Part& t : parts_) {
        const u64* row = t.group.rows.data() + *code++ * 2;
        can &= row[0];
        may &= row[1];
      }
      *plant = can;
      *spec = may;
    } else {
      for (u64 w = 0; w < n_words_; ++w) plant[w] = spec[w] = valid_[w];
      for (const Part& t : parts_) narrow(t, *code++, plant, spec);
    }
    return take_marker<Narrow>(plant, spec);
  }

  // The state after an enabled event; `at` is what enabled() has found.
  K after(const K& key, const At& at, u64 event) const {
    K next = key;
    for (u32 k = first_[event], end = first_[event + 1]; k < end; ++k) {
      const Move& m = moves_[k];
      next.w[K::kWords == 1 ? 0 : m.word] += m.searched ? search(m, at, event) : listed(m, at);
    }
    return next;
  }

  // What enabled(), but for take_marker(), and after() say were it not for the first part; what that says, and adds.
  void enabled_above(const K& key, At& at, u64* plant, u64* spec) const {
    split(key, at);
    for (u64 w = 0; w < n_words_; ++w) plant[w] = spec[w] = valid_[w];
    for (u64 k = 1; k < parts_.size(); ++k) narrow(parts_[k], at.code[k], plant, spec);
  }
  // The bit after the last event says whether every component is in a marked state.
  template <bool Narrow = false>
  Look take_marker(u64* plant, u64* spec) const {
    const u64 top = Narrow ? 0 : n_events_ / 64, bit = u64{1} << n_events_ % 64;
    const Look look{(plant[top] & bit) != 0, (spec[top] & bit) != 0};
    plant[top] &= ~bit;
    spec[top] &= ~bit;
    return look;
  }
  Word step_above(const At& at, u64 event) const {
    Word step = 0;
    for (u32 k = first_[event], end = first_[event + 1]; k < end; ++k) {
      const Move& m = moves_[k];
      if (m.part) step += m.searched ? search(m, at, event) : listed(m, at);
    }
    return step;
  }
  const Group& first() const { return parts_[0].group; }
  bool first_steps_known() const { return !parts_[0].steps.empty() || first().local.empty(); }
  u64 first_code(const At& at) const { return at.code[0]; }
  Word first_step(u64 code, u64 column) const { return parts_[0].steps[code * first().local.size() + column]; }
  void first_narrows(u64 code, u64* plant, u64* spec) const { narrow(parts_[0], code, plant, spec); }

  // The state of a component, when the product is where `at` has been looked up.
  u32 state(const At& at, u64 component) const {
    const auto [part, member] = place_[component];
    return parts_[part].state(at.code[part], member);
  }
  void split(const K& key, At& at) const {
    u64 rest = key.w[0];
    for (u64 k = parts_.size(); k-- > 0;) {
      const Part& t = parts_[k];
      const u64 code = K::kMixed ? t.split(rest) : key.w[K::kWords == 1 ? 0 : t.word] >> t.shift & t.mask;
      at.code[k] = static_cast<u32>(code);
      at.steps[k] = t.steps.data() + code * t.group.local.size();
    }
  }

 private:
  struct Move {
    u32 part, place, word;
    bool searched;
  };
  struct Part {
    Group group;
    std::vector<Word> steps;     // (codes, local) what is added to the key, modulo its range
    const Component* component;  // the first
    u32 word = 0, shift = 0;
    u64 mask = 0;
    u64 unit = 1, inverse = 0;  // what a code counts for, and 2^64 by that

    void scale(u64 by) {
      unit = by;
      inverse = by > 1 ? ~u64{0} / by + 1 : 0;
    }
    // The code in `rest`, which becomes what the codes of smaller units make up. [Lemire, Kaser, Kurz 2019, Faster
    // remainder by direct computation: exact for 32 bits by 32 bits]
    u64 split(u64& rest) const {
      if (!inverse) return std::exchange(rest, 0);
      const u64 code = static_cast<u64>(static_cast<Wide>(rest) * inverse >> 64);
      rest -= code * unit;
      return code;
    }
    Word step(u64 from, u64 to) const {
      return K::kMixed ? static_cast<Word>((to - from) * unit) : static_cast<Word>((to - from) << shift);
    }
    u32 state(u64 code, u64 member) const {
      return group.states.empty() ? ring_state(*component, code) : group.states[code * group.members.size() + member];
    }
  };
  __extension__ using Wide = unsigned __int128;

  static void set(std::vector<u64>& bits, u64 k) { bits[k / 64] |= u64{1} << k % 64; }

  static void narrow(const Part& t, u64 code, u64* plant, u64* spec) {
    const u64 n = t.group.words.size();
    const u64* row = t.group.rows.data() + code * 2 * n;
    for (u64 w = 0; w < n; ++w) {
      plant[t.group.words[w]] &= row[w];
      spec[t.group.words[w]] &= row[n + w];
    }
  }

  static Word listed(const Move& m, const At& at) { return static_cast<const Word*>(at.steps[m.part])[m.place]; }
  Word search(const Move& m, const At& at, u64 event) const {
    const Part& t = parts_[m.part];
    const Graph& g = t.component->graph;
    const u64 code = at.code[m.part], q = t.state(code, 0);
    const i32* lo = g.events + g.offsets[q];
    const i32* hi = g.events + g.offsets[q + 1];
    const u64 target = static_cast<u64>(g.targets[std::lower_bound(lo, hi, static_cast<i32>(event)) - g.events]);
    const u64 initial = static_cast<u64>(t.component->initial), n = t.group.n_codes;
    return t.step(code, target < initial ? target + n - initial : target - initial);
  }

  u64 n_events_, n_words_, span_ = 0;
  std::vector<u64> uncontrollable_, valid_;
  std::vector<Move> moves_;
  std::vector<u32> first_;  // (n_events + 1) where the moves of each event begin
  std::vector<Part> parts_;
  std::vector<std::pair<u32, u32>> place_;  // of each component: its part, and which member of that it is
  Word still_ = 0;
};

}  // namespace thenar

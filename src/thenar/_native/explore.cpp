#include "explore.hpp"

#include <string>

#include "runs.hpp"

namespace thenar {
namespace {

template <class K>
class Explorer final : public Exploration {
 public:
  Explorer(std::vector<Component> components, std::vector<u8> uncontrollable, Layout layout, std::vector<Group> groups,
           u64 first_radix)
      : Exploration(std::move(layout), std::move(uncontrollable)),
        components_(std::move(components)),
        product_(components_, uncontrollable_, std::move(groups), first_radix) {
    product_.prepare(at_);
  }

  // Breadth-first. Of very many states those that are met are marked first, in a set of bits, and numbered by their
  // rank in it; only then the transitions are listed. To look twice costs less than to look in much memory.
  bool run(bool small, Ticker& ticker) override {
    const u64 most = kBlock + uncontrollable_.size();  // states that a block can add
    successors_.resize(most);
    masks_.resize(2 * product_.event_words());
    slots_.find_or_insert(K{}, slots_.place(K{}), 0);
    keys_.push(K{});
    bool addressed = false, ranked = false;
    while (n_states() < keys_.size()) {
      const u64 n_keys = keys_.size(), m = n_transitions(), needed = Slots<K>::bytes_for(n_keys + most);
      u64 growth = 0;
      if (!addressed && !slots_.has_room(n_keys + most)) {
        if (small && needed >= kLarge) return false;
        const u64 all = K::kMixed && !small ? product_.span() * sizeof(u32) : kNone;
        addressed = all <= std::min(kNear, 4 * needed);
        ranked = all > kNear && needed >= kLarge && ranks_fit() && Ranked::bytes_for(product_.span()) <= needed;
        growth = addressed ? all : ranked ? 0 : needed;
      }
      ticker.check(n_keys, m, bytes() + slots_.bytes() + ids_.size() * sizeof(u32) + growth);
      if (ranked) break;
      if (growth && addressed) {
        ids_ = Table<u32>(product_.span());
        for (u64 x = 0; x < n_keys; ++x) ids_[keys_[x].w[0]] = static_cast<u32>(x + 1);
        slots_ = Slots<K>();
      } else if (growth) {
        rehash(n_keys + most, ticker);
      }
      const Done done = addressed ? step<Way::address>(n_states()) : step<Way::hash>(n_states());
      ticker.tick(done.states + done.transitions, keys_.size(), n_transitions());
    }
    slots_ = Slots<K>();
    ids_ = Table<u32>();
    if constexpr (K::kMixed)
      if (ranked) run_ranked(ticker);
    successors_ = {};
    keys_.fit();
    rows_.fit();
    ticker.check(n_states(), n_transitions(), bytes());
    return true;
  }

  void row(u32 state, Scratch& scratch) const override {
    scratch.row.clear();
    if (illegal_[state]) return;
    scratch.plant.resize(product_.event_words());
    scratch.spec.resize(product_.event_words());
    product_.prepare(scratch.at);
    product_.enabled(keys_[state], scratch.at, scratch.plant.data(), scratch.spec.data());
    u64 next_free = rows_.begin(state), next = rows_.free_end(state);
    for (u64 w = 0; w < scratch.plant.size(); ++w)
      for (u64 events = scratch.plant[w] & scratch.spec[w]; events; events &= events - 1) {
        const u64 bit = static_cast<u64>(std::countr_zero(events));
        const bool free = product_.uncontrollable()[w] >> bit & 1;
        scratch.row.push_back({static_cast<i32>(w * 64 + bit), rows_.targets[free ? next_free++ : next++]});
      }
  }

  void pack(const i64* states, u64 n, u64* out) const override {
    At at;
    product_.prepare(at);
    const u64 n_words = layout_.n_words;
    const typename Product<K>::Packer packer(product_, layout_, n);
    std::fill(out, out + n * n_words, 0);
    for (u64 k = 0; k < n; ++k) {
      product_.split(keys_[static_cast<u64>(states[k])], at);
      packer(at, out + k * n_words);
    }
  }
  u64 bytes() const override { return Exploration::bytes() + product_.bytes() + keys_.bytes(); }

  std::vector<u8> conflict(Ticker& ticker) const override {
    std::vector<u8> needed(components_.size());
    // Note a specification for which `guilty` holds, if possible one that is needed already.
    auto blame = [&](auto&& guilty) {
      u64 chosen = components_.size();
      for (u64 c = 0; c < components_.size(); ++c) {
        if (components_[c].plant || !guilty(c)) continue;
        if (needed[c]) return;
        if (chosen == components_.size()) chosen = c;
      }
      needed[chosen] = 1;
    };
    Scratch scratch;
    scratch.plant.resize(product_.event_words());
    scratch.spec.resize(product_.event_words());
    At where;
    product_.prepare(where);
    auto at = [&](u64 c) { return product_.state(where, c); };
    Bits seen(n_states());
    std::vector<u32> stack{0};
    seen.set(0);
    auto follow = [&](u32 y) {
      if (!seen[y]) seen.set(y), stack.push_back(y);
    };
    while (!stack.empty()) {
      const u32 x = stack.back();
      stack.pop_back();
      const auto why = static_cast<Reason>(reason[x]);
      if (why == Reason::uncontrollable) {
        const u64 end = rows_.free_end(x);
        for (u64 k = rows_.begin(x); k < end; ++k)
          if (const u32 y = rows_.targets[k]; rank[y] >= 0 && rank[y] < rank[x]) {
            follow(y);
            break;
          }
        continue;
      }
      const Look look = product_.enabled(keys_[x], where, scratch.plant.data(), scratch.spec.data());
      auto forbid = [&](u64 w, u64 events) {
        const u64 event = w * 64 + static_cast<u64>(std::countr_zero(events));
        blame([&](u64 c) { return components_[c].own[event] && !defined(components_[c].graph, at(c), event); });
      };
      for (u64 w = 0; w < scratch.plant.size(); ++w) {
        const u64 forbidden = scratch.plant[w] & ~scratch.spec[w];
        if (why == Reason::illegal) {
          if (const u64 breaks = forbidden & product_.uncontrollable()[w]) {
            forbid(w, breaks);
            break;  // one event is enough to break a specification
          }
        } else {
          for (u64 events = forbidden; events; events &= events - 1) forbid(w, events);
        }
      }
      if (why == Reason::blocking) {
        if (look.plants_marked) blame([&](u64 c) { return !components_[c].marked[at(c)]; });
        for (u64 k = rows_.begin(x); k < rows_.end(x); ++k) follow(rows_.targets[k]);
      }
      ticker.tick(rows_.end(x) - rows_.begin(x) + 1, n_states(), n_transitions());
    }
    return needed;
  }

 protected:
  void disabled(u32 state, const Bits& alive, const Scratch& scratch, std::vector<i32>& out) const override {
    u64 next = rows_.free_end(state);
    for (u64 w = 0; w < scratch.plant.size(); ++w)
      for (u64 events = scratch.plant[w] & ~product_.uncontrollable()[w]; events; events &= events - 1) {
        const u64 bit = static_cast<u64>(std::countr_zero(events));
        const bool allowed = scratch.spec[w] >> bit & 1;
        if (!allowed || !alive[rows_.targets[next++]]) out.push_back(static_cast<i32>(w * 64 + bit));
      }
  }

 private:
  static bool defined(const Graph& g, u64 state, u64 event) {
    return std::binary_search(g.events + g.offsets[state], g.events + g.offsets[state + 1], static_cast<i32>(event));
  }

  // How a target is found: by hash; in an array of all keys; by its rank among the marked.
  enum class Way { hash, address, rank };
  struct Successor {
    K key;
    u32 slot;   // of its target in the block
    u32 place;  // where to look for it
  };
  struct Done {
    u64 states, transitions;
  };
  static constexpr u64 kBlock = 256;           // successors in flight, enough to hide the latency of memory
  static constexpr u64 kLarge = u64{1} << 19;  // bytes of slots that stay in a near cache anyway
  static constexpr u64 kNear = u64{1} << 24;   // bytes of an array of all keys that stays in some cache

  bool ranks_fit() const {
    if constexpr (K::kMixed) return Runs::fit(product_);
    return false;
  }

  // Mark all states; then list their transitions in the order of ranks.
  void run_ranked(Ticker& ticker) {
    rows_.clear(), keys_.clear();
    illegal_ = Bits(), marked_ = Bits();
    ranked_ = Ranked(product_.span());
    runs_ = std::make_unique<Runs>(product_);
    runs_->mark(ranked_, ticker, bytes() + ranked_.bytes());
    const u64 n = runs_->n_states(), m = runs_->n_transitions();
    const u64 held = bytes() + runs_->bytes() + ranked_.bytes() + n * sizeof(K);
    ticker.check(n, m, held + Rows::bytes_for(n, m) + n / 4);
    ranked_.count([key = keys_.extend(n)](u32 x) mutable { *key++ = {{x}}; });
    rows_.room(n, m + successors_.size());
    while (n_states() < n) {
      const Done done = step<Way::rank>(n_states());
      ticker.tick(done.states + done.transitions, n, m);
    }
    ranked_ = Ranked();
    runs_.reset();
  }

  void rehash(u64 n, Ticker& ticker) {
    constexpr u64 kAhead = 32;
    slots_ = Slots<K>::for_number(n);
    u64 places[kAhead];
    for (u64 k = 0; k < keys_.size() + kAhead; ++k) {
      u64& place = places[k % kAhead];
      if (k >= kAhead) slots_.find_or_insert(keys_[k - kAhead], place, static_cast<u32>(k - kAhead));
      if (k < keys_.size()) slots_.prefetch(place = slots_.place(keys_[k]));
      ticker.tick(1, keys_.size(), n_transitions());
    }
  }

  template <Way way>
  Done step(u64 first) {
    const bool narrow = K::kWords == 1 && product_.event_words() == 1;  // the common case is worth code of its own
    return narrow ? block<K::kWords == 1, way>(first) : block<false, way>(first);
  }

  // Expand some states: generate successors and prefetch, then look them up.
  template <bool Narrow, Way way>
  Done block(u64 first) {
    const u64 n_words = Narrow ? 1 : product_.event_words(), begin = n_transitions();
    const u64* const uncontrollable = product_.uncontrollable();
    if (way != Way::rank) keys_.room(successors_.size());
    u32* const targets = rows_.targets.room(successors_.size());
    K* const keys = keys_.data();
    u64 narrow[2];
    u64* const plant = Narrow ? narrow : masks_.data();
    u64* const spec = plant + n_words;
    const u64 last = std::min(keys_.size(), first + kBlock);
    Successor* successor = successors_.data();
    u64 n = 0, x = first;
    for (; x < last && n < kBlock; ++x) {
      const K key = keys[x];
      Look look;
      if constexpr (way == Way::rank) look = runs_->template enabled<Narrow>(key.w[0], plant, spec);
      else look = product_.template enabled<Narrow>(key, at_, plant, spec);
      u64 breaks = 0, degree = 0, n_free = 0;
      for (u64 w = 0; w < n_words; ++w) {
        const u64 free = uncontrollable[w], both = plant[w] & spec[w];
        breaks |= plant[w] & ~spec[w] & free;
        degree += count_ones(both);
        n_free += count_ones(both & free);
      }
      if (breaks) degree = n_free = 0;
      illegal_.push(breaks != 0);
      marked_.push(look.plants_marked && look.specs_marked);
      rows_.push(begin + n, n_free);
      u32 slot[2] = {static_cast<u32>(n + n_free), static_cast<u32>(n)};  // of the next target, by who controls it
      n += degree;
      for (u64 w = 0; w < n_words; ++w) {
        const u64 free = uncontrollable[w];
        for (u64 events = breaks ? 0 : plant[w] & spec[w]; events; events &= events - 1) {
          const u64 bit = static_cast<u64>(std::countr_zero(events));
          successor->slot = slot[free >> bit & 1]++;
          if constexpr (way == Way::hash) {
            successor->key = product_.after(key, at_, w * 64 + bit);
            successor->place = static_cast<u32>(slots_.place(successor->key));
            slots_.prefetch(successor->place);
          } else if constexpr (way == Way::address) {
            successor->key = product_.after(key, at_, w * 64 + bit);
            __builtin_prefetch(&ids_[successor->key.w[0]]);
          } else {
            successor->key = {{runs_->after(key.w[0], w * 64 + bit)}};
            ranked_.prefetch(static_cast<u32>(successor->key.w[0]));
          }
          ++successor;
        }
      }
    }
    rows_.targets.take(n);
    u64 fresh = keys_.size();
    const Successor* const end = successor;
    for (const Successor* s = successors_.data(); s < end; ++s) {
      if constexpr (way == Way::hash) {  // in this order: it numbers breadth-first
        const u32 id = slots_.find_or_insert(s->key, s->place, static_cast<u32>(fresh));
        if (id == fresh) keys[fresh++] = s->key;
        targets[s->slot] = id;
      } else if constexpr (way == Way::address) {
        u32& id = ids_[s->key.w[0]];
        if (!id) keys[fresh] = s->key, id = static_cast<u32>(++fresh);
        targets[s->slot] = id - 1;
      } else {
        targets[s->slot] = ranked_.rank(static_cast<u32>(s->key.w[0]));
      }
    }
    keys_.take(fresh - keys_.size());
    return {x - first, n};
  }

  std::vector<Component> components_;
  Product<K> product_;
  At at_;
  Buffer<K> keys_;
  Slots<K> slots_;  // while it runs, one of these
  Table<u32> ids_;  // one more than the number of each state; 0: not met
  Ranked ranked_;
  std::unique_ptr<Runs> runs_;
  std::vector<Successor> successors_;
  std::vector<u64> masks_;
};

constexpr u64 kFew = 1 << 6;    // codes of a group; small products are explored before larger groups are made
constexpr u64 kMany = 1 << 10;  // the tables of a few groups of so many stay in a near cache

std::unique_ptr<Exploration> make(std::vector<Component> components, std::vector<u8> uncontrollable, u64 most_codes) {
  std::vector<Group> groups = thenar::groups(components, uncontrollable, most_codes);
  const auto larger = [](const Group& a, const Group& b) { return a.n_codes < b.n_codes; };
  std::iter_swap(groups.begin(), std::max_element(groups.begin(), groups.end(), larger));
  const u64 first_radix = Runs::padded(groups[0].n_codes);
  u64 span = 1;  // numbers that a mixed radix needs, or too many
  u32 n = 1, used = 0;
  for (const Group& g : groups) {
    const u64 radix = &g == &groups[0] ? first_radix : g.n_codes;
    span = radix <= kNone / span ? span * radix : u64{kNone} + 1;
    if (used + code_bits(g) > 64) ++n, used = 0;
    used += code_bits(g);
  }
  auto build = [&]<class Word, int W>() -> std::unique_ptr<Exploration> {
    Layout layout = thenar::layout(components, groups);
    return std::make_unique<Explorer<Key<Word, W>>>(std::move(components), std::move(uncontrollable),
                                                    std::move(layout), std::move(groups), first_radix);
  };
  if (span <= kNone) return build.operator()<u32, 1>();
  if (n <= 1) return build.operator()<u64, 1>();
  if (n <= 2) return build.operator()<u64, 2>();
  if (n <= 4) return build.operator()<u64, 4>();
  if (n <= 16) return build.operator()<u64, 16>();
  if (n <= 64) return build.operator()<u64, 64>();
  throw TooWide("a product state needs " + std::to_string(n * 64) + " bits; the explicit engine packs 4096");
}

}  // namespace

std::unique_ptr<Exploration> Exploration::explore(const std::vector<Component>& components,
                                                  const std::vector<u8>& uncontrollable, Ticker& ticker) {
  auto found = make(components, uncontrollable, kFew);
  if (!found->run(true, ticker)) {
    found = make(components, uncontrollable, kMany);
    found->run(false, ticker);
  }
  return found;
}

}  // namespace thenar

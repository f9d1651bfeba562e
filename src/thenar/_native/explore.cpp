#include "explore.hpp"

#include <string>

#include "visited.hpp"

namespace thenar {
namespace {

template <class K>
class Explorer final : public Exploration {
 public:
  Explorer(std::vector<Component> components, std::vector<u8> uncontrollable, Packing packing)
      : Exploration(packing.layout, std::move(uncontrollable)),
        components_(std::move(components)),
        product_(components_, uncontrollable_, packing) {}

  void run(Ticker& ticker) override {
    const u64 most = kBlock + uncontrollable_.size();  // states that a block can add
    Visited<K> visited(product_);
    const K& start = product_.initial();
    visited.template find_or_insert<By::key>(start, 0, visited.template prefetch<By::key>(start, 0), 0);
    keys_.push(start);
    successors_.resize(most);
    masks_.resize(2 * product_.event_words());
    while (n_states() < keys_.size()) {
      const u64 n_keys = keys_.size(), m = n_transitions();
      const u64 growth = visited.growth(n_keys + most);
      ticker.check(n_keys, m, bytes() + visited.bytes() + growth);
      if (growth) visited.grow(n_keys + most, keys_.data(), n_keys, m, ticker);
      const u64 done = step(visited);
      ticker.tick(done, keys_.size(), n_transitions());
    }
    successors_ = {};
    keys_.fit();
    rows_.fit();
    ticker.check(n_states(), n_transitions(), bytes());
  }

  void row(u32 state, Scratch& scratch) const override {
    scratch.row.clear();
    if (illegal_[state]) return;
    scratch.plant.resize(product_.event_words());
    scratch.spec.resize(product_.event_words());
    product_.enabled(keys_[state], scratch.plant.data(), scratch.spec.data());
    u64 next_free = rows_.begin(state), next = rows_.free_end(state);
    for (u64 w = 0; w < scratch.plant.size(); ++w)
      for (u64 events = scratch.plant[w] & scratch.spec[w]; events; events &= events - 1) {
        const u64 bit = static_cast<u64>(std::countr_zero(events));
        const bool free = product_.uncontrollable()[w] >> bit & 1;
        scratch.row.push_back({static_cast<i32>(w * 64 + bit), rows_.targets[free ? next_free++ : next++]});
      }
  }

  const void* keys() const override { return keys_.data(); }
  u64 bytes() const override { return Exploration::bytes() + product_.bytes() + keys_.bytes(); }
  u32 key_bytes() const override { return sizeof(typename K::Word); }

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
      const K& key = keys_[x];
      auto at = [&](u64 c) { return key.w[layout_.words[c]] >> layout_.shifts[c] & low_bits(layout_.bits[c]); };
      const Look look = product_.enabled(key, scratch.plant.data(), scratch.spec.data());
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

  struct Successor {
    K key;
    u32 index, slot;  // slot of its target in the block
    u64 place;  // where to look for it
  };
  static constexpr u64 kBlock = 256;  // successors in flight, enough to hide the latency of memory

  u64 step(Visited<K>& visited) {
    const bool narrow = K::kWords == 1 && product_.event_words() == 1;  // the common case is worth code of its own
    switch (visited.by()) {
      case By::key: return narrow ? block<K::kWords == 1, By::key>(visited) : block<false, By::key>(visited);
      case By::index: return narrow ? block<K::kWords == 1, By::index>(visited) : block<false, By::index>(visited);
      default: return narrow ? block<K::kWords == 1, By::address>(visited) : block<false, By::address>(visited);
    }
  }

  // Expand some states: generate successors and prefetch, then look them up. Return the work done.
  template <bool Narrow, By by>
  u64 block(Visited<K>& visited) {
    const u64 n_words = Narrow ? 1 : product_.event_words(), first = n_states(), begin = n_transitions();
    const u64* const uncontrollable = product_.uncontrollable();
    keys_.room(successors_.size());
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
      const Look look = product_.template enabled<Narrow, by != By::key>(key, plant, spec);
      u64 breaks = 0, degree = 0, n_free = 0;
      for (u64 w = 0; w < n_words; ++w) {
        const u64 free = uncontrollable[w], both = plant[w] & spec[w];
        breaks |= plant[w] & ~spec[w] & free;
        degree += count_ones(both);
        n_free += count_ones(both & free);
      }
      illegal_.push(breaks != 0);
      marked_.push(look.plants_marked && look.specs_marked);
      if (breaks) degree = n_free = 0;
      rows_.push(begin + n, n_free);
      u32 slot[2] = {static_cast<u32>(n + n_free), static_cast<u32>(n)};  // of the next target, by who controls it
      n += degree;
      for (u64 w = 0; w < n_words; ++w) {
        const u64 free = uncontrollable[w];
        for (u64 events = breaks ? 0 : plant[w] & spec[w]; events; events &= events - 1) {
          const u64 bit = static_cast<u64>(std::countr_zero(events));
          successor->index = look.index;
          successor->key = product_.after(key, w * 64 + bit, successor->index);
          successor->slot = slot[free >> bit & 1]++;
          successor->place = visited.template prefetch<by>(successor->key, successor->index);
          ++successor;
        }
      }
    }
    rows_.targets.take(n);
    u32 fresh = static_cast<u32>(keys_.size());
    const Successor* const end = successor;
    for (const Successor* s = successors_.data(); s < end; ++s) {  // in this order: it numbers breadth-first
      const u32 id = visited.template find_or_insert<by>(s->key, s->index, s->place, fresh);
      if (id == fresh) keys[fresh++] = s->key;
      targets[s->slot] = id;
    }
    keys_.take(fresh - keys_.size());
    return n + x - first;
  }

  std::vector<Component> components_;
  Product<K> product_;
  Buffer<K> keys_;
  std::vector<Successor> successors_;
  std::vector<u64> masks_;
};

}  // namespace

std::unique_ptr<Exploration> Exploration::make(std::vector<Component> components, std::vector<u8> uncontrollable) {
  Packing packing = pack(components, uncontrollable.size());
  const Layout& layout = packing.layout;
  const u32 n = layout.n_words;
  bool slim = n == 1;  // touching half the memory is worth a type of its own
  for (u64 c = 0; c < components.size(); ++c) slim &= layout.bits[c] == 0 || layout.shifts[c] + layout.bits[c] <= 32;
  auto build = [&]<class Word, int W>() -> std::unique_ptr<Exploration> {
    packing.layout.n_words = W;
    return std::make_unique<Explorer<Key<Word, W>>>(std::move(components), std::move(uncontrollable),
                                                    std::move(packing));
  };
  if (slim) return build.operator()<u32, 1>();
  if (n <= 1) return build.operator()<u64, 1>();
  if (n <= 2) return build.operator()<u64, 2>();
  if (n <= 4) return build.operator()<u64, 4>();
  if (n <= 16) return build.operator()<u64, 16>();
  if (n <= 64) return build.operator()<u64, 64>();
  throw TooWide("a product state needs " + std::to_string(n * 64) + " bits; the explicit engine packs 4096");
}

}  // namespace thenar

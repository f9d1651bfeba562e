#include "explore.hpp"

#include <array>
#include <string>

#include "product.hpp"

namespace thenar {
namespace {

// Product states by key, open addressing with linear probing; the key lies in the slot, so that a probe
// costs one cache miss.
template <int W>
class Visited {
 public:
  void reserve(u64 n, const Key<W>* keys, u64 n_keys) {
    if (n * 5 <= slots_.size() * 3) return;  // load at most 0.6
    u64 size = std::max<u64>(64, std::bit_ceil(n * 2));
    std::vector<Slot>().swap(slots_);
    slots_.assign(size, Slot{{}, kNone});
    mask_ = size - 1;
    constexpr u64 kAhead = 16;
    for (u64 k = 0; k < n_keys; ++k) {
      if (k + kAhead < n_keys) prefetch(hash(keys[k + kAhead]));
      u64 h = hash(keys[k]) & mask_;
      while (slots_[h].id != kNone) h = (h + 1) & mask_;
      slots_[h] = {keys[k], static_cast<u32>(k)};
    }
  }
  void prefetch(u64 h) const { __builtin_prefetch(&slots_[h & mask_]); }
  // Return the number of `key`, `next` if it is new.
  u32 find_or_insert(const Key<W>& key, u64 h, u32 next) {
    for (h &= mask_;; h = (h + 1) & mask_) {
      Slot& slot = slots_[h];
      if (slot.id == kNone) {
        slot = {key, next};
        return next;
      }
      if (slot.key == key) return slot.id;
    }
  }
  u64 bytes() const { return slots_.size() * sizeof(Slot); }

 private:
  struct Slot {
    Key<W> key;
    u32 id;
  };
  std::vector<Slot> slots_;
  u64 mask_ = 0;
};

template <int W>
class Explorer final : public Exploration {
 public:
  Explorer(std::vector<Component> components, std::vector<u8> uncontrollable, Layout layout)
      : components_(std::move(components)), product_(components_, uncontrollable, layout) {
    layout_ = std::move(layout);
    uncontrollable_ = std::move(uncontrollable);
  }

  void run(Ticker& ticker) override {
    constexpr u64 kBlock = 512;             // successors in flight, enough to hide the latency of memory
    struct Successor {
      Key<W> key;
      u64 hash, slot;
    };
    const u64 n_words = product_.event_words(), n_events = uncontrollable_.size();
    std::vector<u64> plant(n_words), spec(n_words);
    std::vector<Successor> block(kBlock + n_events);
    Visited<W> visited;
    visited.reserve(1, nullptr, 0);
    visited.find_or_insert(product_.initial(), hash(product_.initial()), 0);
    keys_.push(product_.initial());

    while (row_of_.size() < keys_.size()) {
      visited.reserve(keys_.size() + kBlock + n_events, keys_.data(), keys_.size());
      u64 n = 0;
      for (u64 x = row_of_.size(); x < keys_.size() && n < kBlock; ++x) {  // generate and prefetch
        const Key<W> key = keys_[x];
        product_.enabled(key, plant.data(), spec.data());
        const u64 marker = product_.marker(), top = marker / 64, marker_bit = u64{1} << marker % 64;
        bool illegal = false;
        u64 degree = 0, n_free = 0;
        marked_.push(plant[top] & spec[top] & marker_bit);
        plant[top] &= ~marker_bit;
        for (u64 w = 0; w < n_words; ++w) {
          const u64 free = product_.uncontrollable()[w], both = plant[w] & spec[w];
          illegal |= (plant[w] & ~spec[w] & free) != 0;
          degree += std::popcount(both);
          n_free += std::popcount(both & free);
        }
        illegal_.push(illegal);
        if (illegal) degree = n_free = 0;
        const u64 begin = targets_.size();
        row_of_.push(begin);
        n_free_.push(static_cast<u16>(n_free));
        targets_.extend(degree);
        if (illegal) continue;
        u64 next_free = begin, next = begin + n_free;
        for (u64 w = 0; w < n_words; ++w) {
          const u64 free = product_.uncontrollable()[w];
          for (u64 events = plant[w] & spec[w]; events; events &= events - 1) {
            const u64 bit = static_cast<u64>(std::countr_zero(events));
            Successor& s = block[n++];
            s.key = product_.after(key, w * 64 + bit);
            s.hash = hash(s.key);
            s.slot = free >> bit & 1 ? next_free++ : next++;
            visited.prefetch(s.hash);
          }
        }
      }
      for (u64 k = 0; k < n; ++k) {  // probe, in the order of generation: that numbers the states breadth-first
        const Successor& s = block[k];
        const u32 fresh = static_cast<u32>(keys_.size());
        const u32 id = visited.find_or_insert(s.key, s.hash, fresh);
        if (id == fresh) keys_.push(s.key);
        targets_[s.slot] = id;
      }
      const u64 bytes = visited.bytes() + keys_.bytes() + row_of_.bytes() + targets_.bytes() + n_free_.bytes();
      ticker.check(keys_.size(), targets_.size(), bytes);
      ticker.tick(n + 64, keys_.size(), targets_.size());
    }
  }

  void row(u32 state, std::vector<Edge>& out) const override {
    out.clear();
    if (illegal_[state]) return;
    const auto [plant, spec] = masks(state);
    u64 next_free = row_of_[state], next = next_free + n_free_[state];
    for_each(plant, spec, [&](u64 event) {
      out.push_back({static_cast<i32>(event), targets_[uncontrollable_[event] ? next_free++ : next++]});
    });
  }

  const u64* keys() const override { return keys_.size() ? keys_.data()->w : nullptr; }

 protected:
  void disabled(u32 state, const Bits& alive, std::vector<i32>& out) const override {
    const auto [plant, spec] = masks(state);
    u64 next = row_of_[state] + n_free_[state];
    for (u64 w = 0; w < plant.size(); ++w)
      for (u64 events = plant[w] & ~product_.uncontrollable()[w]; events; events &= events - 1) {
        const u64 bit = static_cast<u64>(std::countr_zero(events));
        const bool allowed = spec[w] >> bit & 1;
        if (!allowed || !alive[targets_[next++]]) out.push_back(static_cast<i32>(w * 64 + bit));
      }
  }

 private:
  std::array<std::vector<u64>, 2> masks(u32 state) const {
    std::array<std::vector<u64>, 2> m{std::vector<u64>(product_.event_words()), std::vector<u64>(product_.event_words())};
    product_.enabled(keys_[state], m[0].data(), m[1].data());
    m[0][product_.marker() / 64] &= ~(u64{1} << product_.marker() % 64);
    return m;
  }
  template <class F>
  static void for_each(const std::vector<u64>& plant, const std::vector<u64>& spec, F&& f) {
    for (u64 w = 0; w < plant.size(); ++w)
      for (u64 events = plant[w] & spec[w]; events; events &= events - 1)
        f(w * 64 + static_cast<u64>(std::countr_zero(events)));
  }

  std::vector<Component> components_;
  Product<W> product_;
  Buffer<Key<W>> keys_;
};

}  // namespace

std::unique_ptr<Exploration> Exploration::make(std::vector<Component> components, std::vector<u8> uncontrollable) {
  Layout layout = pack(components);
  const u32 n = layout.n_words;
  auto build = [&]<int W>() -> std::unique_ptr<Exploration> {
    layout.n_words = W;
    return std::make_unique<Explorer<W>>(std::move(components), std::move(uncontrollable), std::move(layout));
  };
  if (n <= 1) return build.operator()<1>();
  if (n <= 2) return build.operator()<2>();
  if (n <= 4) return build.operator()<4>();
  if (n <= 16) return build.operator()<16>();
  if (n <= 64) return build.operator()<64>();
  throw std::length_error("a product state needs " + std::to_string(n * 64) + " bits; the explicit engine packs 4096");
}

}  // namespace thenar

#include "explore.hpp"

#include <string>

#include "product.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace thenar {
namespace {

// Memory for random access: on Linux backed by large pages, which halve the cost of a miss.
template <class T>
class Table {
 public:
  void reset(u64 n) {
    constexpr u64 kLargePage = u64{2} << 20;
    std::free(data_);
    data_ = nullptr;
    size_ = n;
    const u64 bytes = n * sizeof(T);
    const u64 align = bytes >= kLargePage ? kLargePage : 64;
    data_ = static_cast<T*>(std::aligned_alloc(align, (bytes + align - 1) / align * align));
    if (!data_) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    if (align == kLargePage) madvise(static_cast<void*>(data_), bytes, MADV_HUGEPAGE);
#endif
  }
  Table() = default;
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  ~Table() { std::free(data_); }
  T& operator[](u64 k) { return data_[k]; }
  const T& operator[](u64 k) const { return data_[k]; }
  u64 size() const { return size_; }

 private:
  T* data_ = nullptr;
  u64 size_ = 0;
};

// Product states by key, open addressing with linear probing; the key lies in the slot, so that a probe
// costs one cache miss. `Slim` keys fit 32 bits: touching half the memory is worth a type of its own.
template <int W, bool Slim>
class Visited {
 public:
  void reserve(u64 n, const Key<W>* keys, u64 n_keys, u64 n_transitions, Ticker& ticker) {
    if (n * 5 <= slots_.size() * 3) return;  // load at most 0.6
    const u64 size = std::max<u64>(64, std::bit_ceil(n * 2));
    slots_.reset(size);
    for (u64 h = 0; h < size; ++h) slots_[h].id = kNone;
    mask_ = size - 1;
    constexpr u64 kAhead = 16;
    for (u64 k = 0; k < n_keys; ++k) {
      if (k + kAhead < n_keys) prefetch(hash(keys[k + kAhead]));
      u64 h = hash(keys[k]) & mask_;
      while (slots_[h].id != kNone) h = (h + 1) & mask_;
      slots_[h] = {stored(keys[k]), static_cast<u32>(k)};
      ticker.tick(1, n_keys, n_transitions);
    }
  }
  void prefetch(u64 h) const { __builtin_prefetch(&slots_[h & mask_]); }
  // Return the number of `key`, `next` if it is new.
  u32 find_or_insert(const Key<W>& key, u64 h, u32 next) {
    for (h &= mask_;; h = (h + 1) & mask_) {
      Slot& slot = slots_[h];
      if (slot.id == kNone) {
        slot = {stored(key), next};
        return next;
      }
      if (slot.key == stored(key)) return slot.id;
    }
  }
  u64 bytes() const { return slots_.size() * sizeof(Slot); }

 private:
  using Stored = std::conditional_t<Slim, u32, Key<W>>;
  struct Slot {
    Stored key;
    u32 id;
  };
  static Stored stored(const Key<W>& key) {
    if constexpr (Slim) return static_cast<u32>(key.w[0]);
    else return key;
  }
  Table<Slot> slots_;
  u64 mask_ = 0;
};

template <int W, bool Slim = false>
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
    Visited<W, Slim> visited;
    visited.reserve(1, nullptr, 0, 0, ticker);
    visited.find_or_insert(product_.initial(), hash(product_.initial()), 0);
    keys_.push(product_.initial());

    while (row_of_.size() < keys_.size()) {
      visited.reserve(keys_.size() + kBlock + n_events, keys_.data(), keys_.size(), targets_.size(), ticker);
      u64 n = 0;
      for (u64 x = row_of_.size(); x < keys_.size() && n < kBlock; ++x) {  // generate and prefetch
        const Key<W> key = keys_[x];
        const auto marked = product_.enabled(key, plant.data(), spec.data());
        bool illegal = false;
        u64 degree = 0, n_free = 0;
        marked_.push(marked.plants && marked.specs);
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
        n_free_.push(static_cast<u32>(n_free));
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
      const u64 bytes = product_.bytes() + visited.bytes() + keys_.bytes() + row_of_.bytes() + targets_.bytes() +
                        n_free_.bytes();
      ticker.check(keys_.size(), targets_.size(), bytes);
      ticker.tick(n + 64, keys_.size(), targets_.size());
    }
  }

  void row(u32 state, Scratch& scratch) const override {
    scratch.row.clear();
    if (illegal_[state]) return;
    scratch.plant.resize(product_.event_words());
    scratch.spec.resize(product_.event_words());
    product_.enabled(keys_[state], scratch.plant.data(), scratch.spec.data());
    u64 next_free = row_of_[state], next = next_free + n_free_[state];
    for (u64 w = 0; w < scratch.plant.size(); ++w)
      for (u64 events = scratch.plant[w] & scratch.spec[w]; events; events &= events - 1) {
        const u64 bit = static_cast<u64>(std::countr_zero(events));
        const bool free = product_.uncontrollable()[w] >> bit & 1;
        scratch.row.push_back({static_cast<i32>(w * 64 + bit), targets_[free ? next_free++ : next++]});
      }
  }

  const u64* keys() const override { return keys_.size() ? keys_.data()->w : nullptr; }

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
        const u64 end = row_of_[x] + n_free_[x];
        for (u64 k = row_of_[x]; k < end; ++k)
          if (const u32 y = targets_[k]; rank[y] >= 0 && rank[y] < rank[x]) {
            follow(y);
            break;
          }
        continue;
      }
      const Key<W>& key = keys_[x];
      auto at = [&](u64 c) { return key.w[layout_.words[c]] >> layout_.shifts[c] & low_bits(layout_.bits[c]); };
      const auto marked = product_.enabled(key, scratch.plant.data(), scratch.spec.data());
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
        if (marked.plants) blame([&](u64 c) { return !components_[c].marked[at(c)]; });
        for (u64 k = row_of_[x]; k < row_end(x); ++k) follow(targets_[k]);
      }
      ticker.tick(row_end(x) - row_of_[x] + 1, n_states(), n_transitions());
    }
    return needed;
  }

 protected:
  void disabled(u32 state, const Bits& alive, const Scratch& scratch, std::vector<i32>& out) const override {
    u64 next = row_of_[state] + n_free_[state];
    for (u64 w = 0; w < scratch.plant.size(); ++w)
      for (u64 events = scratch.plant[w] & ~product_.uncontrollable()[w]; events; events &= events - 1) {
        const u64 bit = static_cast<u64>(std::countr_zero(events));
        const bool allowed = scratch.spec[w] >> bit & 1;
        if (!allowed || !alive[targets_[next++]]) out.push_back(static_cast<i32>(w * 64 + bit));
      }
  }

 private:
  static bool defined(const Graph& g, u64 state, u64 event) {
    return std::binary_search(g.events + g.offsets[state], g.events + g.offsets[state + 1], static_cast<i32>(event));
  }

  std::vector<Component> components_;
  Product<W> product_;
  Buffer<Key<W>> keys_;
};

}  // namespace

std::unique_ptr<Exploration> Exploration::make(std::vector<Component> components, std::vector<u8> uncontrollable) {
  Layout layout = pack(components);
  const u32 n = layout.n_words;
  bool slim = n == 1;
  for (u64 c = 0; c < components.size(); ++c) slim &= layout.shifts[c] + layout.bits[c] <= 32;
  auto build = [&]<int W, bool Slim = false>() -> std::unique_ptr<Exploration> {
    layout.n_words = W;
    return std::make_unique<Explorer<W, Slim>>(std::move(components), std::move(uncontrollable), std::move(layout));
  };
  if (slim) return build.operator()<1, true>();
  if (n <= 1) return build.operator()<1>();
  if (n <= 2) return build.operator()<2>();
  if (n <= 4) return build.operator()<4>();
  if (n <= 16) return build.operator()<16>();
  if (n <= 64) return build.operator()<64>();
  throw TooWide("a product state needs " + std::to_string(n * 64) + " bits; the explicit engine packs 4096");
}

}  // namespace thenar

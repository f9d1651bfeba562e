// The states that an exploration has met: by index where memory allows, by hash of the key otherwise.
#pragma once

#include <optional>

#include "product.hpp"

namespace thenar {

constexpr u64 kLine = 64;  // bytes of a cache line

// Memory for random access, zero, and touched only where it is used; on Linux backed by large pages, which
// halve the cost of a miss.
template <class T>
class Table {
 public:
  Table() = default;
  explicit Table(u64 n) : memory_(std::calloc(n * sizeof(T) + kLine, 1)), size_(n) {
    if (!memory_) throw std::bad_alloc();
    data_ = reinterpret_cast<T*>((reinterpret_cast<u64>(memory_) + kLine - 1) / kLine * kLine);
    advise_large_pages(memory_, n * sizeof(T) + kLine);
  }
  Table(Table&& other) noexcept { *this = std::move(other); }
  Table& operator=(Table&& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~Table() { std::free(memory_); }
  T& operator[](u64 k) { return data_[k]; }
  const T& operator[](u64 k) const { return data_[k]; }
  u64 size() const { return size_; }

 private:
  void* memory_ = nullptr;
  T* data_ = nullptr;  // memory_, aligned
  u64 size_ = 0;
};

// Numbers by key, by open addressing. The key lies in the slot and a cache line is searched from the place on and round
// before the next one is: most look-ups cost one miss.
template <class T>
class Slots {
  struct Slot {
    T key;
    u32 id;  // one more than the number of the state; 0: free
  };

 public:
  explicit Slots(u64 size = 64) : slots_(size), shift_(64 - static_cast<u32>(std::countr_zero(size))) {}
  static u64 bytes_for(u64 n) { return std::bit_ceil(n * 2) * sizeof(Slot); }
  static Slots for_number(u64 n) { return Slots(std::bit_ceil(n * 2)); }

  u64 bytes() const { return slots_.size() * sizeof(Slot); }
  bool has_room(u64 n) const { return n * 10 <= slots_.size() * 7; }
  u64 place(const T& key) const { return hash(key) >> shift_; }
  void prefetch(u64 place) const { __builtin_prefetch(&slots_[place]); }
  // Return the number of `key`; if it is new, that is `next`.
  u32 find_or_insert(const T& key, u64 place, u32 next) {
    constexpr u64 kTogether = std::bit_floor(std::max<u64>(kLine / sizeof(Slot), 1));
    for (u64 line = place & ~(kTogether - 1);; line = (line + kTogether) & (slots_.size() - 1))
      for (u64 k = 0; k < kTogether; ++k) {
        Slot& slot = slots_[line + ((place + k) & (kTogether - 1))];
        if (!slot.id) {
          slot = {key, next + 1};
          return next;
        }
        if (slot.key == key) return slot.id - 1;
      }
  }

 private:
  Table<Slot> slots_;
  u32 shift_;
};

enum class By { key, index, address };

template <class K>
class Visited {
 public:
  explicit Visited(Product<K>& product) : product_(product) {}

  By by() const { return by_; }
  u64 bytes() const {
    return by_ == By::key ? keys_.bytes() : by_ == By::index ? indices_.bytes() : ids_.size() * sizeof(u32);
  }

  // A state is looked up where prefetch() said that it would be; by() says how.
  template <By by>
  u64 prefetch(const K& key, u32 index) const {
    if constexpr (by == By::address) {
      __builtin_prefetch(&ids_[index]);
      return index;
    } else if constexpr (by == By::index) {
      const u64 place = indices_.place({index});
      indices_.prefetch(place);
      return place;
    } else {
      const u64 place = keys_.place(key);
      keys_.prefetch(place);
      return place;
    }
  }
  template <By by>
  u32 find_or_insert(const K& key, u32 index, u64 place, u32 next) {
    if constexpr (by == By::key) return keys_.find_or_insert(key, place, next);
    if constexpr (by == By::index) return indices_.find_or_insert({index}, place, next);
    u32& id = ids_[index];
    if (!id) id = next + 1;
    return id - 1;
  }

  // The bytes that making room for n states takes; 0 if there is room.
  u64 growth(u64 n) {
    if (by_ == By::address || (by_ == By::key ? keys_.has_room(n) : indices_.has_room(n))) return 0;
    next_ = by_;
    if (Slots<K>::bytes_for(n) < kWorthAnIndex) return Slots<K>::bytes_for(n);
    if (!span_) span_ = product_.make_index();
    if (!*span_) return Slots<K>::bytes_for(n);
    // An array by index touches one word a state and never moves; it may cost as much as slots for four times n.
    const u64 slots = Slots<Index>::bytes_for(n), all = *span_ * sizeof(u32);
    next_ = all <= 4 * slots ? By::address : sizeof(K) > sizeof(Index) ? By::index : By::key;
    return next_ == By::address ? all : slots;
  }
  // After growth() has said what it takes.
  void grow(u64 n, const K* keys, u64 n_keys, u64 n_transitions, Ticker& ticker) {
    if (next_ == By::address) ids_ = Table<u32>(*span_);
    if (next_ == By::index) indices_ = Slots<Index>::for_number(n);
    if (next_ == By::key) keys_ = Slots<K>::for_number(n);
    else keys_ = Slots<K>();
    if (next_ == By::address) indices_ = Slots<Index>();
    by_ = next_;
    switch (by_) {
      case By::key: return refill<By::key>(keys, n_keys, n_transitions, ticker);
      case By::index: return refill<By::index>(keys, n_keys, n_transitions, ticker);
      case By::address: return refill<By::address>(keys, n_keys, n_transitions, ticker);
    }
  }

 private:
  using Index = Key<u32, 1>;

  template <By by>
  void refill(const K* keys, u64 n_keys, u64 n_transitions, Ticker& ticker) {
    constexpr u64 kAhead = 32;
    struct Next {
      u32 index;
      u64 place;
    } next[kAhead];
    for (u64 k = 0; k < n_keys + kAhead; ++k) {
      Next& slot = next[k % kAhead];
      if (k >= kAhead) find_or_insert<by>(keys[k - kAhead], slot.index, slot.place, static_cast<u32>(k - kAhead));
      if (k < n_keys) {
        slot.index = by == By::key ? 0 : product_.index(keys[k]);
        slot.place = prefetch<by>(keys[k], slot.index);
      }
      ticker.tick(1, n_keys, n_transitions);
    }
  }

  static constexpr u64 kWorthAnIndex = 1 << 18;  // bytes; smaller tables stay in the cache anyway
  Product<K>& product_;
  By by_ = By::key, next_ = By::key;
  Slots<K> keys_;
  Slots<Index> indices_;
  Table<u32> ids_;
  std::optional<u64> span_;  // numbers that make_index() gives; 0: it cannot
};

}  // namespace thenar

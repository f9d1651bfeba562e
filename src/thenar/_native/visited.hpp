// The states that an exploration has met: a set of bits where memory allows, slots by hash of the key otherwise.
#pragma once

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

// A set of numbers below a bound, and how many of them are smaller than each one. Both lie in one word for 32 numbers,
// 16 times less memory than to keep the number of each, of which a cache holds that much more.
class Ranked {
 public:
  Ranked() = default;
  explicit Ranked(u64 bound) : words_(bound / 32 + 1) {}
  static u64 bytes_for(u64 bound) { return (bound / 32 + 1) * sizeof(u64); }
  u64 bytes() const { return words_.size() * sizeof(u64); }
  void prefetch(u32 x) const { __builtin_prefetch(&words_[x / 32]); }
  // Before count(): in the lower half of each the members; the upper half is free for other uses.
  u64* words() { return &words_[0]; }
  // Call f for each member, in order; from then on rank() knows.
  template <class F>
  void count(F&& f) {
    u64 n = 0;
    for (u64 w = 0; w < words_.size(); ++w) {
      const u64 members = words_[w] & 0xffffffff;
      words_[w] = members | n << 32;
      for (u64 left = members; left; left &= left - 1, ++n)
        f(static_cast<u32>(w * 32 + static_cast<u64>(std::countr_zero(left))));
    }
  }
  u32 rank(u32 x) const {
    const u64 word = words_[x / 32];
    return static_cast<u32>(word >> 32) + static_cast<u32>(count_ones(word & low_bits(x % 32)));
  }

 private:
  Table<u64> words_;
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

}  // namespace thenar

// What every kernel shares: short integer names, bit sets, limits and the tick by which long work can be stopped.
#pragma once

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace thenar {

using u8 = std::uint8_t;
using u16 = std::uint16_t;
using u32 = std::uint32_t;
using u64 = std::uint64_t;
using i32 = std::int32_t;
using i64 = std::int64_t;

constexpr u32 kNone = std::numeric_limits<u32>::max();

// Unlike std::popcount no call of a library function where the instruction cannot be taken for granted.
inline u64 count_ones(u64 word) {
  word -= word >> 1 & 0x5555555555555555u;
  word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
  return ((word + (word >> 4)) & 0x0f0f0f0f0f0f0f0fu) * 0x0101010101010101u >> 56;
}

// A deterministic automaton as compressed sparse rows, each row in the order of the alphabet.
struct Graph {
  i64 n_states;
  const i64* offsets;
  const i32* events;
  const i32* targets;
};

// Ask for large pages, which halve the cost of a cache miss and of touching memory for the first time.
inline void advise_large_pages([[maybe_unused]] void* data, [[maybe_unused]] u64 bytes) {
#ifdef MADV_HUGEPAGE
  constexpr u64 kPage = 4096, kWorthIt = u64{4} << 20;
  if (bytes < kWorthIt) return;
  // All pages that the block touches: were the first one left out, it could not be grown without copying.
  const u64 address = reinterpret_cast<u64>(data), first = address / kPage * kPage;
  madvise(reinterpret_cast<void*>(first), (address + bytes - first + kPage - 1) / kPage * kPage, MADV_HUGEPAGE);
#endif
}

// A growing array of plain data. Unlike std::vector it grows by realloc, which moves pages instead of copying them.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { std::free(data_); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  u64 size() const { return size_; }
  u64 bytes() const { return size_ * sizeof(T); }  // what is beyond has not been touched
  T& operator[](u64 k) { return data_[k]; }
  const T& operator[](u64 k) const { return data_[k]; }

  void push(const T& value) {
    if (size_ == capacity_) grow(size_ + 1);
    data_[size_++] = value;
  }
  // Make room for n more elements and return where they begin; take() makes the first k of them part of the array.
  T* room(u64 n) {
    if (size_ + n > capacity_) grow(size_ + n);
    return data_ + size_;
  }
  void take(u64 k) { size_ += k; }
  void clear() { size_ = 0; }
  // Append n elements without initialising them.
  T* extend(u64 n) {
    T* first = room(n);
    size_ += n;
    return first;
  }
  // Give back what has been made room for but not taken.
  void fit() {
    if (size_ == 0 || size_ == capacity_) return;
    void* moved = std::realloc(static_cast<void*>(data_), size_ * sizeof(T));
    if (moved) data_ = static_cast<T*>(moved), capacity_ = size_;
  }

 private:
  void grow(u64 needed) {
    u64 capacity = std::max<u64>({needed, capacity_ + capacity_ / 2, 64});
    void* moved = std::realloc(static_cast<void*>(data_), capacity * sizeof(T));
    if (!moved) throw std::bad_alloc();
    data_ = static_cast<T*>(moved);
    capacity_ = capacity;
    advise_large_pages(moved, capacity * sizeof(T));
  }
  T* data_ = nullptr;
  u64 size_ = 0, capacity_ = 0;
};

class Bits {
 public:
  Bits() = default;
  explicit Bits(u64 n, bool value = false) : size_(n), words_((n + 63) / 64, value ? ~u64{0} : 0) {
    if (value && n % 64) words_.back() = (u64{1} << (n % 64)) - 1;
  }
  u64 size() const { return size_; }
  bool operator[](u64 k) const { return words_[k >> 6] >> (k & 63) & 1; }
  void set(u64 k) { words_[k >> 6] |= u64{1} << (k & 63); }
  void clear(u64 k) { words_[k >> 6] &= ~(u64{1} << (k & 63)); }
  u64 n_words() const { return words_.size(); }
  u64 bytes() const { return words_.size() * sizeof(u64); }
  u64& word(u64 w) { return words_[w]; }
  u64 word(u64 w) const { return words_[w]; }
  void push(bool value) {
    if (size_ % 64 == 0) words_.push_back(0);
    if (value) set(size_);
    ++size_;
  }

 private:
  u64 size_ = 0;
  std::vector<u64> words_;
};

struct Limits {
  u64 states = std::numeric_limits<u64>::max();
  u64 transitions = std::numeric_limits<u64>::max();
  u64 bytes = std::numeric_limits<u64>::max();
  double seconds = std::numeric_limits<double>::infinity();
};

// Thrown where a computation stops at one of its limits, with what was found by then.
struct LimitHit {
  const char* limit;
  double bound;
  u64 states, transitions;
};

// Called a few times a second with (states, transitions) found so far; it may throw, which ends the work.
using Hook = std::function<void(u64, u64)>;

// Keeps a computation within its limits and lets others look in: asks the clock cheaply, calls the hook when it is due.
class Ticker {
 public:
  // `spent`: seconds that are gone already.
  explicit Ticker(const Limits& limits = {}, Hook hook = {}, double spent = 0)
      : limits_(limits), hook_(std::move(hook)), spent_(spent), start_(Clock::now()), next_(start_ + kPeriod) {}

  // Count `work` elementary steps.
  void tick(u64 work, u64 states, u64 transitions) {
    if ((credit_ += work) < kStepsPerLook) return;
    credit_ = 0;
    const auto now = Clock::now();
    if (now >= next_) {
      next_ = now + kPeriod;
      if (hook_) hook_(states, transitions);
    }
    if (std::chrono::duration<double>(now - start_).count() + spent_ > limits_.seconds)
      throw LimitHit{"seconds", limits_.seconds, states, transitions};
  }
  void check(u64 states, u64 transitions, u64 bytes) const {
    auto within = [&](const char* limit, u64 bound, u64 used) {
      if (used > bound) throw LimitHit{limit, static_cast<double>(bound), states, transitions};
    };
    within("states", std::min<u64>(limits_.states, kMaxStates), states);
    within("transitions", limits_.transitions, transitions);
    within("bytes", limits_.bytes, bytes);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr u64 kMaxStates = 0x7fffffff;  // states are numbered by int32
  static constexpr auto kPeriod = std::chrono::milliseconds(50);
  static constexpr u64 kStepsPerLook = 1 << 15;  // about a millisecond of work
  Limits limits_;
  Hook hook_;
  double spent_;
  Clock::time_point start_, next_;
  u64 credit_ = 0;
};

}  // namespace thenar

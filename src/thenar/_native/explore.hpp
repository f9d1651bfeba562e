// The n-way synchronous product, explored on the fly, and the supremal controllable nonblocking fixpoint on it.
#pragma once

#include <memory>
#include <stdexcept>
#include <unordered_map>

#include "common.hpp"

namespace thenar {

struct Component {
  Graph graph;
  const u8* marked;  // (n_states)
  const u8* own;     // (n_events) 1 where the event is in the component's alphabet
  i32 initial;
  bool plant;  // false: a specification
};

// The state of a component that is `code` places after its initial one, in a ring.
inline u32 ring_state(const Component& c, u64 code) {
  const u64 n = static_cast<u64>(c.graph.n_states), q = static_cast<u64>(c.initial) + code;
  return static_cast<u32>(q < n ? q : q - n);
}

// Where a packed product state keeps the state of each component.
struct Layout {
  std::vector<u32> words, shifts, bits;
  u32 n_words = 1;
};

enum class Reason : u8 { survives, illegal, uncontrollable, blocking };

struct Edge {
  i32 event;
  u32 target;
};

// Where one product state is: in each group of components its code, and the steps from there.
struct At {
  std::vector<u32> code;
  std::vector<const void*> steps;
};

// What a look at one state needs; made once, used for many states.
struct Scratch {
  At at;
  std::vector<u64> plant, spec;  // the events that the plants can do, and that the specifications allow
  std::vector<Edge> row;
};

// The part of a product that survives, numbered breadth-first in the order of the alphabet.
struct Extract {
  std::vector<i64> offsets, disabled_offsets;
  std::vector<i32> events, targets, disabled;
  std::vector<u8> marked;
  std::vector<i64> origin;  // product state of each state
};

struct TooWide : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The transitions of the states, without their events.
class Rows {
 public:
  explicit Rows(u64 n_events) : shift_(31 - static_cast<u32>(std::bit_width(n_events))) {}
  u64 size() const { return low_.size(); }
  u64 bytes() const {
    return low_.bytes() + n_free_.bytes() + targets.bytes() + base_.size() * sizeof(u64) + wide_.size() * kNode;
  }
  // What so many of them take, about.
  static u64 bytes_for(u64 n_rows, u64 n_targets) {
    return n_rows * (sizeof(u32) + sizeof(u8)) + n_targets * sizeof(u32);
  }
  u64 begin(u64 x) const { return base_[x >> shift_] + low_[x]; }
  u64 end(u64 x) const { return x + 1 < low_.size() ? begin(x + 1) : targets.size(); }
  u64 free_end(u64 x) const { return begin(x) + (n_free_[x] < kWide ? n_free_[x] : wide_.at(static_cast<u32>(x))); }

  // The row of the next state begins here; `n_free` of its events are uncontrollable.
  void push(u64 begin, u64 n_free) {
    const u64 x = low_.size();
    if ((x & ((u64{1} << shift_) - 1)) == 0) [[unlikely]] base_.push_back(begin);
    if (n_free >= kWide) [[unlikely]] wide_[static_cast<u32>(x)] = static_cast<u32>(n_free);
    low_.push(static_cast<u32>(begin - base_.back()));
    n_free_.push(static_cast<u8>(std::min<u64>(n_free, kWide)));
  }
  void clear() {
    low_.clear();
    n_free_.clear();
    targets.clear();
    base_.clear();
    wide_.clear();
  }
  // Make room for so many rows and transitions in all.
  void room(u64 n_rows, u64 n_targets) {
    low_.room(n_rows);
    n_free_.room(n_rows);
    targets.room(n_targets);
  }
  void fit() {
    low_.fit();
    n_free_.fit();
    targets.fit();
  }
  Buffer<u32> targets;  // each row: those of uncontrollable events first, then the others, each in alphabet order

 private:
  static constexpr u8 kWide = 255;
  static constexpr u64 kNode = 48;  // bytes of an entry of wide_, about
  u32 shift_;                       // so many rows that a difference of beginnings fits 32 bits
  std::vector<u64> base_;           // where the row of each (1 << shift_)th state begins
  Buffer<u32> low_;                 // where each row begins, from there
  Buffer<u8> n_free_;               // how many of a row belong to uncontrollable events
  std::unordered_map<u32, u32> wide_;  // the same where it is kWide or more
};

class Exploration {
 public:
  virtual ~Exploration() = default;
  // The explored product. Throws TooWide if a product state does not fit the widest packing.
  static std::unique_ptr<Exploration> explore(const std::vector<Component>& components,
                                              const std::vector<u8>& uncontrollable, Ticker& ticker);

  // From the initial state, which is number 0; a state in which the plants can do an uncontrollable event that
  // the specifications forbid is *illegal* and is not expanded. Return false if it is `small` but the product is not.
  virtual bool run(bool small, Ticker& ticker) = 0;
  // Put the transitions of one state, in the order of the alphabet, into `scratch.row`.
  virtual void row(u32 state, Scratch& scratch) const = 0;
  // The states of the components in each of n states, packed as in layout(); out: (n, n_words).
  virtual void pack(const i64* states, u64 n, u64* out) const = 0;
  const Layout& layout() const { return layout_; }

  // Remove illegal states, states from which an uncontrollable event leads to a removed state, and states
  // from which no marked state can be reached; until none is left to remove.
  void fixpoint(Ticker& ticker);
  Extract extract(Ticker& ticker) const;
  // After a fixpoint that removes the initial state: for each component 1 if the proof of that needs it (plants: 0).
  // The specifications that it needs conflict among themselves, though perhaps not minimally.
  virtual std::vector<u8> conflict(Ticker& ticker) const = 0;
  // A shortest path from `start` to a state of `goal` over states of `inside` (start excepted);
  // false if there is none. `states` includes both ends.
  bool path(u32 start, const u8* goal, const u8* inside, bool uncontrollable_only, Ticker& ticker,
            std::vector<i32>& events, std::vector<i64>& states) const;

  u64 n_states() const { return rows_.size(); }
  u64 n_transitions() const { return rows_.targets.size(); }
  // What it holds, but for what a computation needs while it runs.
  virtual u64 bytes() const {
    return rows_.bytes() + illegal_.bytes() + marked_.bytes() + rank.size() * sizeof(i32) + reason.size();
  }
  const Bits& illegal() const { return illegal_; }
  std::vector<i32> rank;   // after fixpoint: -1 survives; otherwise larger than the rank of what it follows from
  std::vector<u8> reason;  // after fixpoint: a Reason

 protected:
  Exploration(Layout layout, std::vector<u8> uncontrollable)
      : layout_(std::move(layout)), uncontrollable_(std::move(uncontrollable)), rows_(uncontrollable_.size()) {}
  // Append the controllable events of `state`, just looked at by row(), that are forbidden or lead to a removed state.
  virtual void disabled(u32 state, const Bits& alive, const Scratch& scratch, std::vector<i32>& out) const = 0;

  Bits alive() const;
  // Remove what leads uncontrollably to a removed state; return the highest rank given, at least `level`.
  i32 spread(Bits& alive, i32 level, Ticker& ticker);
  // The states of `alive` from which a marked one can be reached over `alive`; `way`, if any, becomes the next one.
  Bits coreachable(const Bits& alive, std::vector<u32>* way, Ticker& ticker) const;
  class Repair;

  Layout layout_;
  std::vector<u8> uncontrollable_;
  Rows rows_;
  Bits illegal_, marked_;
};

}  // namespace thenar

// The n-way synchronous product, explored on the fly, and the supremal controllable nonblocking fixpoint on it.
#pragma once

#include <memory>
#include <stdexcept>

#include "common.hpp"

namespace thenar {

struct Component {
  Graph graph;
  const u8* marked;  // (n_states)
  const u8* own;     // (n_events) 1 where the event is in the component's alphabet
  i32 initial;
  bool plant;  // false: a specification
};

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

// What a look at one state needs; made once, used for many states.
struct Scratch {
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

class Exploration {
 public:
  virtual ~Exploration() = default;
  // Throws TooWide if a product state does not fit its widest packing.
  static std::unique_ptr<Exploration> make(std::vector<Component> components, std::vector<u8> uncontrollable);

  // Breadth-first from the initial state; a state in which the plants can do an uncontrollable event that
  // the specifications forbid is *illegal* and is not expanded.
  virtual void run(Ticker& ticker) = 0;
  // Put the transitions of one state, in the order of the alphabet, into `scratch.row`.
  virtual void row(u32 state, Scratch& scratch) const = 0;
  // The state of every component, packed as in layout(); (n_states, n_words).
  virtual const u64* keys() const = 0;
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

  u64 n_states() const { return row_of_.size(); }
  u64 n_transitions() const { return targets_.size(); }
  const Bits& illegal() const { return illegal_; }
  std::vector<i32> rank;   // after fixpoint: -1 survives; otherwise larger than the rank of what it follows from
  std::vector<u8> reason;  // after fixpoint: a Reason

 protected:
  // Append the controllable events of `state`, just looked at by row(), that are forbidden or lead to a removed state.
  virtual void disabled(u32 state, const Bits& alive, const Scratch& scratch, std::vector<i32>& out) const = 0;

  u64 row_end(u64 state) const { return state + 1 < row_of_.size() ? row_of_[state + 1] : targets_.size(); }
  Bits alive() const;
  // Remove what leads uncontrollably to a removed state; return the highest rank given, at least `level`.
  i32 spread(Bits& alive, i32 level, Ticker& ticker);
  Bits coreachable(const Bits& alive, Ticker& ticker) const;

  Layout layout_;
  std::vector<u8> uncontrollable_;
  Buffer<u64> row_of_;   // where the row of each expanded state begins
  Buffer<u32> targets_;  // each row: targets of uncontrollable events first, then the others, each in alphabet order
  Buffer<u32> n_free_;   // how many of a row belong to uncontrollable events
  Bits illegal_, marked_;
};

}  // namespace thenar

// The supremal controllable nonblocking fixpoint over an explored product, and what is read off it.
#include <algorithm>

#include "explore.hpp"

namespace thenar {
namespace {

// Forward sweeps need no reversed graph, half the memory of a worklist; but a long thin graph can need as
// many sweeps as it has states. After this many, a worklist over a reversed graph bounds the time by O(|delta|).
constexpr int kMaxSweeps = 24;

// Visit the set bits of `word`, upwards or downwards.
template <class F>
void for_bits(u64 word, u64 base, bool up, F&& f) {
  while (word) {
    const u64 bit = static_cast<u64>(up ? std::countr_zero(word) : 63 - std::countl_zero(word));
    word &= ~(u64{1} << bit);
    f(base + bit);
  }
}

// Sweep over the states given by `todo(word)`, alternating between downwards and upwards, until `visit` changes
// nothing more. Return false if kMaxSweeps were not enough.
template <class Todo, class Visit>
bool sweep(u64 n_words, Todo&& todo, Visit&& visit) {
  for (int round = 0; round < kMaxSweeps; ++round) {
    bool changed = false;
    const bool up = round % 2;
    for (u64 i = 0; i < n_words; ++i) {
      const u64 w = up ? i : n_words - 1 - i;
      for_bits(todo(w), w * 64, up, [&](u64 x) { changed |= visit(x); });
    }
    if (!changed) return true;
  }
  return false;
}

// The reversed graph of the rows [first(x), last(x)) of `targets`.
struct Reversed {
  std::vector<u64> offsets;
  std::vector<u32> sources;

  template <class First, class Last>
  Reversed(u64 n, const u32* targets, First&& first, Last&& last) : offsets(n + 2) {
    for (u64 x = 0; x < n; ++x)
      for (u64 k = first(x); k < last(x); ++k) ++offsets[targets[k] + 2];
    for (u64 x = 2; x < n + 2; ++x) offsets[x] += offsets[x - 1];
    sources.resize(offsets[n + 1]);
    for (u64 x = 0; x < n; ++x)
      for (u64 k = first(x); k < last(x); ++k) sources[offsets[targets[k] + 1]++] = static_cast<u32>(x);
  }
};

}  // namespace

Bits Exploration::alive() const {
  Bits alive(n_states(), true);
  if (!rank.empty())
    for (u64 x = 0; x < n_states(); ++x)
      if (rank[x] >= 0) alive.clear(x);
  return alive;
}

i32 Exploration::spread(Bits& alive, i32 level, Ticker& ticker) {
  auto remove = [&](u64 x, u32 because) {
    alive.clear(x);
    rank[x] = rank[because] + 1;
    level = std::max(level, rank[x]);
    reason[x] = static_cast<u8>(Reason::uncontrollable);
  };
  auto free_end = [&](u64 x) { return row_of_[x] + n_free_[x]; };
  auto visit = [&](u64 x) {
    for (u64 k = row_of_[x]; k < free_end(x); ++k)
      if (!alive[targets_[k]]) {
        remove(x, targets_[k]);
        return true;
      }
    ticker.tick(1 + n_free_[x], n_states(), n_transitions());
    return false;
  };
  if (sweep(alive.n_words(), [&](u64 w) { return alive.word(w); }, visit)) return level;
  const Reversed back(n_states(), targets_.data(), [&](u64 x) { return row_of_[x]; }, free_end);
  std::vector<u32> stack;
  for (u64 x = 0; x < n_states(); ++x)
    if (!alive[x]) stack.push_back(static_cast<u32>(x));
  while (!stack.empty()) {
    const u32 y = stack.back();
    stack.pop_back();
    for (u64 k = back.offsets[y]; k < back.offsets[y + 1]; ++k)
      if (const u32 x = back.sources[k]; alive[x]) {
        remove(x, y);
        stack.push_back(x);
      }
    ticker.tick(1, n_states(), n_transitions());
  }
  return level;
}

Bits Exploration::coreachable(const Bits& alive, Ticker& ticker) const {
  Bits co(n_states());
  for (u64 w = 0; w < co.n_words(); ++w) co.word(w) = marked_.word(w) & alive.word(w);
  auto visit = [&](u64 x) {
    ticker.tick(row_end(x) - row_of_[x] + 1, n_states(), n_transitions());
    for (u64 k = row_of_[x]; k < row_end(x); ++k)
      if (co[targets_[k]]) {
        co.set(x);
        return true;
      }
    return false;
  };
  if (sweep(co.n_words(), [&](u64 w) { return alive.word(w) & ~co.word(w); }, visit)) return co;
  const Reversed back(n_states(), targets_.data(), [&](u64 x) { return row_of_[x]; }, [&](u64 x) { return row_end(x); });
  std::vector<u32> stack;
  for (u64 x = 0; x < n_states(); ++x)
    if (co[x]) stack.push_back(static_cast<u32>(x));
  while (!stack.empty()) {
    const u32 y = stack.back();
    stack.pop_back();
    for (u64 k = back.offsets[y]; k < back.offsets[y + 1]; ++k)
      if (const u32 x = back.sources[k]; alive[x] && !co[x]) {
        co.set(x);
        stack.push_back(x);
      }
    ticker.tick(1, n_states(), n_transitions());
  }
  return co;
}

void Exploration::fixpoint(Ticker& ticker) {
  const u64 n = n_states();
  rank.assign(n, -1);
  reason.assign(n, static_cast<u8>(Reason::survives));
  Bits alive(n, true);
  for (u64 x = 0; x < n; ++x)
    if (illegal_[x]) {
      alive.clear(x);
      rank[x] = 0;
      reason[x] = static_cast<u8>(Reason::illegal);
    }
  for (i32 level = 0;;) {
    level = spread(alive, level, ticker) + 1;  // above all ranks given so far
    const Bits co = coreachable(alive, ticker);
    bool removed = false;
    for (u64 w = 0; w < alive.n_words(); ++w) {
      const u64 blocked = alive.word(w) & ~co.word(w);
      removed |= blocked != 0;
      alive.word(w) &= co.word(w);
      for_bits(blocked, w * 64, true, [&](u64 x) {
        rank[x] = level;
        reason[x] = static_cast<u8>(Reason::blocking);
      });
    }
    if (!removed) return;
  }
}

Extract Exploration::extract(Ticker& ticker) const {
  const Bits alive = this->alive();
  Extract out;
  out.offsets.push_back(0);
  out.disabled_offsets.push_back(0);
  if (!n_states() || !alive[0]) return out;
  std::vector<u32> number(n_states(), kNone);
  Scratch scratch;
  number[0] = 0;
  out.origin.push_back(0);
  out.events.reserve(n_transitions());  // address space only: pages are not touched before they are used
  out.targets.reserve(n_transitions());
  out.offsets.reserve(n_states() + 1);
  out.origin.reserve(n_states());
  for (u64 k = 0; k < out.origin.size(); ++k) {
    const u32 x = static_cast<u32>(out.origin[k]);
    row(x, scratch);
    for (const auto& [event, target] : scratch.row) {
      if (!alive[target]) continue;
      if (number[target] == kNone) {
        number[target] = static_cast<u32>(out.origin.size());
        out.origin.push_back(target);
      }
      out.events.push_back(event);
      out.targets.push_back(static_cast<i32>(number[target]));
    }
    disabled(x, alive, scratch, out.disabled);
    out.offsets.push_back(static_cast<i64>(out.events.size()));
    out.disabled_offsets.push_back(static_cast<i64>(out.disabled.size()));
    out.marked.push_back(marked_[x]);
    ticker.tick(scratch.row.size() + 1, out.origin.size(), out.events.size());
  }
  return out;
}

bool Exploration::path(u32 start, const u8* goal, const u8* inside, bool uncontrollable_only, Ticker& ticker,
                       std::vector<i32>& events, std::vector<i64>& states) const {
  struct Step {
    u32 state, parent;
    i32 event;
  };
  std::vector<Step> queue{{start, 0, -1}};
  Bits seen(n_states());
  seen.set(start);
  Scratch scratch;
  for (u64 k = 0; k < queue.size(); ++k) {
    const u32 x = queue[k].state;
    if (goal[x]) {
      for (u64 i = k;; i = queue[i].parent) {
        states.push_back(queue[i].state);
        if (i == 0) break;
        events.push_back(queue[i].event);
      }
      std::reverse(states.begin(), states.end());
      std::reverse(events.begin(), events.end());
      return true;
    }
    row(x, scratch);
    ticker.tick(scratch.row.size() + 1, n_states(), n_transitions());
    for (const auto& [event, target] : scratch.row) {
      if (seen[target] || !(inside[target] || goal[target])) continue;
      if (uncontrollable_only && !uncontrollable_[event]) continue;
      seen.set(target);
      queue.push_back({target, static_cast<u32>(k), event});
    }
  }
  return false;
}

}  // namespace thenar

// The supremal controllable nonblocking fixpoint over an explored product, and what is read off it.
#include <algorithm>

#include "explore.hpp"

namespace thenar {
namespace {

// Forward sweeps need no reversed graph, half the memory of a worklist; but a long thin graph can need as
// many sweeps as it has states. After this many, a worklist over a reversed graph bounds the time by O(|delta|).
constexpr int kMaxSweeps = 24;

// Most models need one round or two of removing what leads to a removed state, then what blocks. After this many,
// only what a removal touches is looked at again.
constexpr int kMaxRounds = 4;

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
  Reversed(u64 n, const u32* targets, Ticker& ticker, First&& first, Last&& last) : offsets(n + 2) {
    auto each = [&](auto&& f) {
      for (u64 x = 0; x < n; ++x) {
        for (u64 k = first(x); k < last(x); ++k) f(x, targets[k]);
        ticker.tick(last(x) - first(x) + 1, n, 0);
      }
    };
    each([&](u64, u32 y) { ++offsets[y + 2]; });
    for (u64 x = 2; x < n + 2; ++x) offsets[x] += offsets[x - 1];
    sources.resize(offsets[n + 1]);
    each([&](u64 x, u32 y) { sources[offsets[y + 1]++] = static_cast<u32>(x); });
  }
};

}  // namespace

Bits Exploration::alive() const {
  Bits alive(n_states(), true);
  for (u64 x = 0; x < n_states(); ++x)
    if (rank.empty() ? illegal_[x] : rank[x] >= 0) alive.clear(x);  // illegal states are not expanded: they have no row
  return alive;
}

i32 Exploration::spread(Bits& alive, i32 level, Ticker& ticker) {
  auto remove = [&](u64 x, u32 because) {
    alive.clear(x);
    rank[x] = rank[because] + 1;
    level = std::max(level, rank[x]);
    reason[x] = static_cast<u8>(Reason::uncontrollable);
  };
  auto visit = [&](u64 x) {
    for (u64 k = rows_.begin(x); k < rows_.free_end(x); ++k)
      if (!alive[rows_.targets[k]]) {
        remove(x, rows_.targets[k]);
        return true;
      }
    ticker.tick(1 + rows_.free_end(x) - rows_.begin(x), n_states(), n_transitions());
    return false;
  };
  if (sweep(alive.n_words(), [&](u64 w) { return alive.word(w); }, visit)) return level;
  const Reversed back(n_states(), rows_.targets.data(), ticker, [&](u64 x) { return rows_.begin(x); },
                      [&](u64 x) { return rows_.free_end(x); });
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

Bits Exploration::coreachable(const Bits& alive, std::vector<u32>* way, Ticker& ticker) const {
  Bits co(n_states());
  for (u64 w = 0; w < co.n_words(); ++w) co.word(w) = marked_.word(w) & alive.word(w);
  auto visit = [&](u64 x) {
    ticker.tick(rows_.end(x) - rows_.begin(x) + 1, n_states(), n_transitions());
    for (u64 k = rows_.begin(x); k < rows_.end(x); ++k)
      if (co[rows_.targets[k]]) {
        co.set(x);
        if (way) (*way)[x] = rows_.targets[k];
        return true;
      }
    return false;
  };
  if (sweep(co.n_words(), [&](u64 w) { return alive.word(w) & ~co.word(w); }, visit)) return co;
  const Reversed back(n_states(), rows_.targets.data(), ticker, [&](u64 x) { return rows_.begin(x); },
                      [&](u64 x) { return rows_.end(x); });
  std::vector<u32> stack;
  for (u64 x = 0; x < n_states(); ++x)
    if (co[x]) stack.push_back(static_cast<u32>(x));
  while (!stack.empty()) {
    const u32 y = stack.back();
    stack.pop_back();
    for (u64 k = back.offsets[y]; k < back.offsets[y + 1]; ++k)
      if (const u32 x = back.sources[k]; alive[x] && !co[x]) {
        co.set(x);
        if (way) (*way)[x] = y;
        stack.push_back(x);
      }
    ticker.tick(1, n_states(), n_transitions());
  }
  return co;
}

// Keeps, for each survivor, a way to a marked state: the ways form a forest. What a removal cuts off is below it in
// the forest, so that only this is looked at again, where a round over all states would make many rounds quadratic.
class Exploration::Repair {
 public:
  // The survivors are `alive`, from each of which a marked state can be reached.
  Repair(Exploration& x, Bits& alive, Ticker& ticker)
      : x_(x), rows_(x.rows_), alive_(alive), ticker_(ticker), cut_(x.n_states()), child_(x.n_states(), kNone),
        sibling_(x.n_states(), kNone), entering_(x.n_states(), kNone),
        back_(x.n_states(), rows_.targets.data(), ticker, [&](u64 q) { return rows_.begin(q); },
              [&](u64 q) { return rows_.free_end(q); }) {
    std::vector<u32> way(x.n_states(), kNone);
    x.coreachable(alive, &way, ticker);
    for (u64 q = 0; q < way.size(); ++q)
      if (alive[q] && way[q] != kNone) hang(static_cast<u32>(q), way[q]);
  }
  static u64 bytes(u64 n_states, u64 n_transitions) {
    return n_states * (4 * sizeof(u32) + 2 * sizeof(u64)) + n_transitions * sizeof(u32);
  }

  // Remove `removed`, removed just now at `level` at most, and all that follows from it; ranks go up from there.
  void follow(std::vector<u32> removed, i32 level) {
    while (!removed.empty()) {
      for (u64 k = 0; k < removed.size(); ++k) {
        const u32 y = removed[k];
        ticker_.tick(back_.offsets[y + 1] - back_.offsets[y] + 1, x_.n_states(), x_.n_transitions());
        for (u64 i = back_.offsets[y]; i < back_.offsets[y + 1]; ++i)
          if (const u32 q = back_.sources[i]; alive_[q]) {
            remove(q, x_.rank[y] + 1, Reason::uncontrollable);
            level = std::max(level, x_.rank[q]);
            removed.push_back(q);
          }
      }
      removed = blocked(removed);
      ++level;
      for (const u32 q : removed) remove(q, level, Reason::blocking);
    }
  }

 private:
  void remove(u32 q, i32 rank, Reason reason) {
    alive_.clear(q);
    x_.rank[q] = rank;
    x_.reason[q] = static_cast<u8>(reason);
  }
  void hang(u32 q, u32 below) {
    sibling_[q] = child_[below];
    child_[below] = q;
  }
  // The states that have no other way than over `removed`.
  std::vector<u32> blocked(const std::vector<u32>& removed) {
    std::vector<u32> cut;  // the survivors above them in the forest
    auto gather = [&](u32 y) {
      for (u32 q = child_[y]; q != kNone; q = sibling_[q])
        if (alive_[q]) cut_.set(q), cut.push_back(q);
      child_[y] = kNone;
    };
    for (const u32 y : removed) gather(y);
    for (u64 k = 0; k < cut.size(); ++k) {
      ticker_.tick(1, x_.n_states(), x_.n_transitions());
      gather(cut[k]);
    }
    std::vector<u32> found;  // those with another way, each a way for those that enter it
    struct Edge {
      u32 source, next;
    };
    std::vector<Edge> edges;  // among `cut`, a list for each target
    for (const u32 q : cut) {
      const u64 end = rows_.end(q);
      ticker_.tick(end - rows_.begin(q) + 1, x_.n_states(), x_.n_transitions());
      for (u64 k = rows_.begin(q); k < end; ++k) {
        const u32 y = rows_.targets[k];
        if (!alive_[y]) continue;
        if (!cut_[y]) {
          hang(q, y);
          found.push_back(q);
          break;
        }
        if (edges.size() == kNone) throw std::bad_alloc();  // more than lists of 32 bits can link
        edges.push_back({q, entering_[y]});
        entering_[y] = static_cast<u32>(edges.size() - 1);
      }
    }
    for (const u32 q : found) cut_.clear(q);
    for (u64 k = 0; k < found.size(); ++k)
      for (u32 i = entering_[found[k]]; i != kNone; i = edges[i].next) {
        const u32 q = edges[i].source;
        ticker_.tick(1, x_.n_states(), x_.n_transitions());
        if (!cut_[q]) continue;
        cut_.clear(q);
        hang(q, found[k]);
        found.push_back(q);
      }
    std::vector<u32> none;
    for (const u32 q : cut) {
      entering_[q] = kNone;
      if (cut_[q]) cut_.clear(q), none.push_back(q);
    }
    return none;
  }

  Exploration& x_;
  const Rows& rows_;
  Bits& alive_;
  Ticker& ticker_;
  Bits cut_;
  std::vector<u32> child_, sibling_;  // the forest
  std::vector<u32> entering_;         // scratch of blocked()
  Reversed back_;                     // uncontrollable events only
};

void Exploration::fixpoint(Ticker& ticker) {
  const u64 n = n_states();
  ticker.check(n, n_transitions(), bytes() + n * (sizeof(i32) + sizeof(u8)) + n / 4);
  rank.assign(n, -1);
  reason.assign(n, static_cast<u8>(Reason::survives));
  Bits alive(n, true);
  for (u64 x = 0; x < n; ++x)
    if (illegal_[x]) {
      alive.clear(x);
      rank[x] = 0;
      reason[x] = static_cast<u8>(Reason::illegal);
    }
  i32 level = 0;
  for (int round = 0;; ++round) {
    level = spread(alive, level, ticker) + 1;  // above all ranks given so far
    const Bits co = coreachable(alive, nullptr, ticker);
    std::vector<u32> removed;
    const bool last = round == kMaxRounds;
    bool any = false;
    for (u64 w = 0; w < alive.n_words(); ++w) {
      const u64 blocked = alive.word(w) & ~co.word(w);
      any |= blocked != 0;
      alive.word(w) &= co.word(w);
      for_bits(blocked, w * 64, true, [&](u64 x) {
        rank[x] = level;
        reason[x] = static_cast<u8>(Reason::blocking);
        if (last) removed.push_back(static_cast<u32>(x));
      });
    }
    if (!any) return;
    if (!last) continue;
    ticker.check(n, n_transitions(), bytes() + Repair::bytes(n, n_transitions()));
    return Repair(*this, alive, ticker).follow(std::move(removed), level);
  }
}

namespace {

u64 bytes_of(const Extract& e) {
  return (e.offsets.size() + e.disabled_offsets.size() + e.origin.size()) * sizeof(i64) +
         (e.events.size() + e.targets.size() + e.disabled.size()) * sizeof(i32) + e.marked.size();
}

}  // namespace

Extract Exploration::extract(Ticker& ticker) const {
  const Bits alive = this->alive();
  Extract out;
  out.offsets.push_back(0);
  out.disabled_offsets.push_back(0);
  if (!n_states() || !alive[0]) return out;
  const u64 held = bytes() + alive.bytes() + n_states() * sizeof(u32);
  ticker.check(0, 0, held);
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
    if (k % 1024 == 0) ticker.check(out.origin.size(), out.events.size(), held + bytes_of(out));
    ticker.tick(scratch.row.size() + 1, out.origin.size(), out.events.size());
  }
  ticker.check(out.origin.size(), out.events.size(), held + bytes_of(out));
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

#include "groups.hpp"

#include <numeric>

namespace thenar {
namespace {

constexpr u32 kGroupBits = 10;        // the tables of a few groups of 1024 states stay in a near cache
constexpr u64 kGroupMoves = 1 << 20;  // states times events of a table

u32 width(const Component& c) {  // 0 for one state
  return static_cast<u32>(std::bit_width(static_cast<u64>(c.graph.n_states - 1)));
}

}  // namespace

Packing pack(const std::vector<Component>& components, u64 n_events) {
  const u32 n = static_cast<u32>(components.size());
  std::vector<std::vector<u32>> owners(n_events);
  std::vector<u64> moves(n);  // the events that can move a component, at most
  for (u32 c = 0; c < n; ++c)
    for (u64 e = 0; e < n_events; ++e)
      if (components[c].own[e]) owners[e].push_back(c), moves[c] += width(components[c]) > 0;

  Packing out;
  std::vector<u32> left(n), shared(n);
  std::iota(left.begin(), left.end(), 0);
  while (!left.empty()) {
    Group group;
    u64 events = 0;
    std::fill(shared.begin(), shared.end(), 0);
    for (auto next = left.begin(); next != left.end();) {
      const u32 c = *next;
      left.erase(next);
      group.members.push_back(c);
      group.bits += width(components[c]);
      events += moves[c];
      for (u64 e = 0; e < n_events; ++e)
        if (components[c].own[e] && owners[e].size() < 64)  // an event of very many binds none
          for (const u32 other : owners[e]) ++shared[other];
      next = left.end();
      for (auto k = left.begin(); k != left.end(); ++k)
        if (const u32 bits = group.bits + width(components[*k]);
            bits <= kGroupBits && (events + moves[*k]) << bits <= kGroupMoves &&
            (next == left.end() || shared[*k] > shared[*next]))
          next = k;
    }
    out.groups.push_back(std::move(group));
  }

  Layout& layout = out.layout;
  layout.words.resize(n), layout.shifts.resize(n), layout.bits.resize(n);
  u32 word = 0, used = 0;
  for (Group& g : out.groups) {
    if (used + g.bits > 64) ++word, used = 0;
    g.word = word;
    g.shift = g.bits ? used : 0;  // a field of no bits may lie anywhere
    for (const u32 c : g.members) {
      layout.words[c] = word;
      layout.bits[c] = width(components[c]);
      layout.shifts[c] = layout.bits[c] ? used : 0;
      used += layout.bits[c];
    }
  }
  layout.n_words = word + 1;
  return out;
}

}  // namespace thenar

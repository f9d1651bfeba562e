#include "groups.hpp"

#include <numeric>
#include <optional>

namespace thenar {
namespace {

constexpr u64 kMostMoves = 1 << 20;     // states times events of a group of several
constexpr u64 kMostPairs = 1 << 16;     // states of two parts that may be looked at to find those that are reached
constexpr u64 kDenseEntries = 1 << 22;  // 16 to 32 MiB a component; beyond that a row is searched

bool has(const u64* bits, u64 k) { return bits[k / 64] >> k % 64 & 1; }
void set(u64* bits, u64 k) { bits[k / 64] |= u64{1} << k % 64; }

class Maker {
 public:
  Maker(const std::vector<Component>& components, const std::vector<u8>& uncontrollable, u64 most_codes)
      : components_(components), most_codes_(most_codes), n_events_(uncontrollable.size()),
        n_words_(n_events_ / 64 + 1), free_(n_words_), owners_(n_events_), n_plants_(n_events_) {
    for (u64 e = 0; e < n_events_; ++e)
      if (uncontrollable[e]) set(free_.data(), e);
    for (u32 c = 0; c < components.size(); ++c)
      for (u64 e = 0; e < n_events_; ++e)
        if (components[c].own[e]) owners_[e].push_back(c), n_plants_[e] += components[c].plant;
  }

  // Components that share events come together.
  std::vector<Group> make() const {
    std::vector<Group> out, singles;
    for (u32 c = 0; c < components_.size(); ++c) singles.push_back(single(c));
    std::vector<u32> left(components_.size()), shared(components_.size());
    std::iota(left.begin(), left.end(), 0);
    while (!left.empty()) {
      Group group;
      std::fill(shared.begin(), shared.end(), 0);
      std::vector<u64> inside(n_events_);  // plants of the group that have each event
      int patience = kPatience;
      for (auto next = left.begin(); next != left.end();) {
        const u32 c = *next;
        if (group.members.empty()) {
          group = std::move(singles[c]);
        } else if (auto both = joined(group, singles[c], inside)) {
          group = std::move(*both);
        } else {
          shared[c] = kNone;  // not in this group
          --patience;
        }
        if (shared[c] != kNone) {
          left.erase(next);
          for (u64 e = 0; e < n_events_; ++e) {
            if (!components_[c].own[e]) continue;
            inside[e] += components_[c].plant;
            if (owners_[e].size() < 64)  // an event of very many binds none
              for (const u32 other : owners_[e]) shared[other] += shared[other] != kNone;
          }
        }
        next = left.end();
        for (auto k = left.begin(); k != left.end(); ++k)
          if (shared[*k] != kNone && (next == left.end() || shared[*k] > shared[*next]) &&
              fits(group, singles[*k], patience > 0))
            next = k;
      }
      out.push_back(std::move(group));
    }
    return out;
  }

 private:
  static constexpr int kPatience = 2;  // joins of a group that may turn out too large

  Group single(u32 c) const {
    const Component& part = components_[c];
    const Graph& g = part.graph;
    const u64 n = static_cast<u64>(g.n_states);
    Group out;
    out.members = {c};
    out.n_codes = n;
    // It has a say in its alphabet, and in the marker unless all its states are marked.
    std::vector<u64> own(n_words_), moved(n_words_);
    for (u64 e = 0; e < n_events_; ++e)
      if (part.own[e]) set(own.data(), e);
    if (!std::all_of(part.marked, part.marked + n, [](u8 m) { return m != 0; })) set(own.data(), n_events_);
    for (i64 q = 0; q < g.n_states; ++q)  // an event that only loops never moves
      for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k)
        if (g.targets[k] != q) set(moved.data(), static_cast<u64>(g.events[k]));
    std::vector<u32> word(n_words_), place(n_events_);
    for (u64 w = 0; w < n_words_; ++w)
      if (own[w] || n_words_ == 1)
        word[w] = static_cast<u32>(out.words.size()), out.words.push_back(static_cast<u32>(w));
    for (u64 e = 0; e < n_events_; ++e)
      if (has(moved.data(), e)) place[e] = static_cast<u32>(out.local.size()), out.local.push_back(static_cast<u32>(e));
    const u64 n_own = out.words.size(), n_local = out.local.size();
    out.rows.assign(n * 2 * n_own, ~u64{0});
    if (n * n_local <= kDenseEntries) out.next.resize(n * n_local);
    const u64 initial = static_cast<u64>(part.initial);
    auto code = [&](u64 q) { return q < initial ? q + n - initial : q - initial; };
    for (u64 q = 0; q < n; ++q) {
      u64* const row = out.rows.data() + (code(q) * 2 + !part.plant) * n_own;
      for (u64 i = 0; i < n_own; ++i) row[i] = ~own[out.words[i]];
      for (i64 k = g.offsets[q]; k < g.offsets[q + 1]; ++k) {
        const u64 e = static_cast<u64>(g.events[k]);
        row[word[e / 64]] |= u64{1} << e % 64;
        if (!out.next.empty() && has(moved.data(), e))
          out.next[code(q) * n_local + place[e]] = static_cast<u32>(code(static_cast<u64>(g.targets[k])));
      }
      if (part.marked[q] && n_own && out.words.back() == n_events_ / 64) row[n_own - 1] |= u64{1} << n_events_ % 64;
    }
    return out;
  }

  bool fits(const Group& a, const Group& b, bool hopeful) const {
    const u64 pairs = a.n_codes * b.n_codes;
    auto listed = [](const Group& g) { return !g.next.empty() || g.local.empty(); };
    return listed(a) && listed(b) && pairs <= (hopeful ? std::min(kMostPairs, 16 * most_codes_) : most_codes_);
  }

  // Both together, unless they reach too many states; `inside` counts the plants of `a` that have each event.
  std::optional<Group> joined(const Group& a, const Group& b, const std::vector<u64>& inside) const {
    Group out;
    out.members = a.members;
    out.members.insert(out.members.end(), b.members.begin(), b.members.end());
    std::set_union(a.words.begin(), a.words.end(), b.words.begin(), b.words.end(), std::back_inserter(out.words));
    std::set_union(a.local.begin(), a.local.end(), b.local.begin(), b.local.end(), std::back_inserter(out.local));
    const u64 n_words = out.words.size(), n_local = out.local.size(), n_members = out.members.size();
    struct Local {
      u32 in_a, in_b, word, bit;
    };
    std::vector<Local> local;
    std::vector<u32> of_a, of_b;  // where their words are
    auto place = [](const std::vector<u32>& in, u32 x) {
      const auto at = std::lower_bound(in.begin(), in.end(), x);
      return at != in.end() && *at == x ? static_cast<u32>(at - in.begin()) : kNone;
    };
    for (const u32 w : a.words) of_a.push_back(place(out.words, w));
    for (const u32 w : b.words) of_b.push_back(place(out.words, w));
    for (const u32 e : out.local)
      local.push_back({place(a.local, e), place(b.local, e), place(out.words, e / 64), e % 64});
    std::vector<u64> closed;  // uncontrollable events that no plant outside can hinder
    for (const u32 w : out.words) {
      u64 bits = free_[w];
      for (u64 left = bits; left; left &= left - 1) {
        const u64 e = w * 64 + static_cast<u64>(std::countr_zero(left));
        const Component& added = components_[b.members[0]];
        if (inside[e] + (added.plant && added.own[e]) < n_plants_[e]) bits &= ~(left & -left);
      }
      closed.push_back(bits);
    }

    std::vector<u32> code(a.n_codes * b.n_codes, kNone);
    struct Pair {
      u32 a, b;
    };
    std::vector<Pair> pairs{{0, 0}};
    code[0] = 0;
    for (u64 k = 0; k < pairs.size(); ++k) {
      const auto [p, q] = pairs[k];
      out.rows.resize((k + 1) * 2 * n_words, ~u64{0});
      u64* const can = out.rows.data() + k * 2 * n_words;
      u64* const may = can + n_words;
      auto narrow = [&](const Group& g, const std::vector<u32>& where, u64 state) {
        const u64* row = g.rows.data() + state * 2 * where.size();
        for (u64 i = 0; i < where.size(); ++i) can[where[i]] &= row[i], may[where[i]] &= row[where.size() + i];
      };
      narrow(a, of_a, p);
      narrow(b, of_b, q);
      bool illegal = false;
      for (u64 i = 0; i < n_words; ++i) illegal |= (can[i] & ~may[i] & closed[i]) != 0;
      out.next.resize((k + 1) * n_local);
      for (u64 i = 0; i < n_local && !illegal; ++i) {
        const Local& l = local[i];
        if (!(can[l.word] & may[l.word] & u64{1} << l.bit)) continue;
        const u32 to_a = l.in_a == kNone ? p : a.next[p * a.local.size() + l.in_a];
        const u32 to_b = l.in_b == kNone ? q : b.next[q * b.local.size() + l.in_b];
        u32& to = code[to_a * b.n_codes + to_b];
        if (to == kNone) {
          to = static_cast<u32>(pairs.size());
          pairs.push_back({to_a, to_b});
        }
        out.next[k * n_local + i] = to;
      }
      if (pairs.size() > most_codes_ || pairs.size() * n_local > kMostMoves) return {};
    }
    out.n_codes = pairs.size();
    out.states.reserve(out.n_codes * n_members);
    for (const auto& [p, q] : pairs) {
      append(out.states, a, p);
      append(out.states, b, q);
    }
    return out;
  }

  void append(std::vector<u32>& states, const Group& g, u64 code) const {
    const u64 n = g.members.size();
    if (!g.states.empty()) {
      states.insert(states.end(), g.states.data() + code * n, g.states.data() + (code + 1) * n);
    } else {
      states.push_back(ring_state(components_[g.members[0]], code));
    }
  }

  const std::vector<Component>& components_;
  u64 most_codes_, n_events_, n_words_;
  std::vector<u64> free_;
  std::vector<std::vector<u32>> owners_;
  std::vector<u64> n_plants_;  // that have each event
};

}  // namespace

std::vector<Group> groups(const std::vector<Component>& components, const std::vector<u8>& uncontrollable,
                          u64 most_codes) {
  std::vector<Group> out = Maker(components, uncontrollable, most_codes).make();
  if (out.empty()) {  // a product of nothing has one state, and hinders nothing
    out.emplace_back().n_codes = 1;
    out[0].words = {0};
    out[0].rows = {~u64{0}, ~u64{0}};
  }
  return out;
}

Layout layout(const std::vector<Component>& components, const std::vector<Group>& groups) {
  Layout out;
  const u64 n = components.size();
  out.words.resize(n), out.shifts.resize(n), out.bits.resize(n);
  u32 word = 0, used = 0;
  for (const Group& g : groups)
    for (const u32 c : g.members) {
      const u32 bits = static_cast<u32>(std::bit_width(static_cast<u64>(components[c].graph.n_states - 1)));
      if (used + bits > 64) ++word, used = 0;
      out.words[c] = word;
      out.shifts[c] = bits ? used : 0;  // a field of no bits may lie anywhere
      out.bits[c] = bits;
      used += bits;
    }
  out.n_words = word + 1;
  return out;
}

}  // namespace thenar

#include "saturation.hpp"

namespace thenar {

Saturation::Saturation(Forest& forest, const std::vector<Relation>& relations)
    : f_(forest), family_(forest.join_family()), k_saturate(kFamily + 4 * family_), k_fire(k_saturate + 2), shifts_(forest.n_levels() + 1),
      first_shift_(forest.n_levels() + 1) {
  for (Relation r : relations) {
    if (r <= kIdentity) continue;
    const u32 level = f_.relation_level(r);
    lowest_ = std::min(lowest_, level);
    for (const Pair* p = f_.begin(r); p != f_.end(r); ++p) shifts_[level].push_back({p->from, p->to, p->next});
  }
  for (u32 level = 1; level <= forest.n_levels(); ++level) {
    auto& shifts = shifts_[level];
    auto key = [](const Shift& s) { return std::tuple(s.from, s.to, s.next); };
    std::sort(shifts.begin(), shifts.end(), [&](const Shift& a, const Shift& b) { return key(a) < key(b); });
    shifts.erase(std::unique(shifts.begin(), shifts.end(), [&](const Shift& a, const Shift& b) { return key(a) == key(b); }),
                 shifts.end());
    auto& first = first_shift_[level];
    first.assign(forest.size(level) + 1, 0);
    for (const Shift& s : shifts) ++first[s.from + 1];
    for (u32 i = 0; i < forest.size(level); ++i) first[i + 1] += first[i];
  }
}

Node Saturation::operator()(Node start, Node within) {
  free_ = within == kEverything;
  Frame protect(f_, {start, within});
  return saturate(f_.n_levels(), f_.intersect(start, within), within);
}

// set ⊆ within; what is found is closed under all relations whose top is at this level or below.
Node Saturation::saturate(u32 level, Node set, Node within) {
  if (set == kNothing || set == within || level < lowest_) return set;
  // set is a proper part of within, so neither is a terminal of its own and level > 0
  Node result;
  // The level is a key: the sets may skip it, and still the relations of this level apply.
  const u32 kind = k_saturate + free_ + (level << 8);
  if (f_.cache().find(kind, 0, set, within, result)) return result;
  Frame kids(f_, {set, within}, f_.size(level));
  if (f_.collection_is_due()) f_.collect();
  f_.tick();
  for (u32 i = 0; i < f_.size(level); ++i) {
    const Node found = saturate(level - 1, f_.child(set, level, i), f_.child(within, level, i));
    kids[i] = found;
  }
  settle(level, kids, within);
  result = f_.make(level, kids.data());
  f_.cache().store(kind, 0, set, within, result);
  return result;
}

// The children are closed each for itself; apply the relations of this level until nothing changes.
void Saturation::settle(u32 level, Frame& kids, Node within) {
  const auto& shifts = shifts_[level];
  if (shifts.empty()) return;
  const auto& first = first_shift_[level];
  const u32 size = f_.size(level);
  u8 few[64];
  std::vector<u8> many;
  if (size > sizeof few) many.resize(size);
  u8* dirty = size > sizeof few ? many.data() : few;
  std::fill_n(dirty, size, 1);
  for (bool changed = true; changed;) {
    changed = false;
    for (u32 i = 0; i < size; ++i) {
      if (!dirty[i] || kids[i] == kNothing) continue;
      dirty[i] = 0;
      for (u32 k = first[i]; k < first[i + 1]; ++k) {
        const Shift s = shifts[k];
        const Node allowed = f_.child(within, level, s.to);
        if (allowed == kNothing || kids[s.to] == allowed) continue;
        const Node found = fire(level - 1, kids[i], s.next, allowed);
        const Node more = f_.unite(kids[s.to], found);
        if (more == kids[s.to]) continue;
        kids[s.to] = more;
        dirty[s.to] = 1;
        changed = true;
      }
    }
  }
}

// The successors of set by r within `within`, closed under the relations of this level and below.
Node Saturation::fire(u32 level, Node set, Relation r, Node within) {
  if (set == kNothing || within == kNothing || r == kNever) return kNothing;
  if (r == kIdentity) {
    if (free_) return set;  // closed already
    return saturate(level, f_.intersect(set, within), within);
  }
  Node result;
  const u32 kind = k_fire + free_ + (level << 8);
  if (f_.cache().find(kind, r, set, within, result)) return result;
  Frame kids(f_, {set, within}, f_.size(level));
  if (f_.collection_is_due()) f_.collect();
  f_.tick();
  if (f_.relation_level(r) == level) {
    for (const Pair *p = f_.begin(r), *stop = f_.end(r); p != stop; ++p) {
      const Node found = fire(level - 1, f_.child(set, level, p->from), p->next, f_.child(within, level, p->to));
      if (found != kNothing) kids[p->to] = f_.unite(kids[p->to], found);
    }
  } else {
    for (u32 i = 0; i < f_.size(level); ++i) {
      const Node found = fire(level - 1, f_.child(set, level, i), r, f_.child(within, level, i));
      kids[i] = found;
    }
  }
  const Node raw = f_.make(level, kids.data());
  if (raw == kNothing || raw == within) {
    result = raw;
  } else if (const u32 closed = k_saturate + free_ + (level << 8); !f_.cache().find(closed, 0, raw, within, result)) {
    Frame keep(f_, {raw});
    settle(level, kids, within);
    result = f_.make(level, kids.data());
    f_.cache().store(closed, 0, raw, within, result);
  }
  f_.cache().store(kind, r, set, within, result);
  return result;
}

}  // namespace thenar

// Reachability by saturation (Ciardo), within a set of allowed states (Zhao and Ciardo).
#pragma once

#include "diagrams.hpp"

namespace thenar {

// A fixed set of relations to be applied until nothing new is found. What one run found out serves the next ones.
class Saturation {
 public:
  Saturation(Forest& forest, const std::vector<Relation>& relations);
  ~Saturation() {
    const u64 own = u64{1} << family_;
    if (f_.busy) f_.left_meanwhile |= own;  // a thread of its own may be looking at the cache
    else f_.leave_families(own);
  }
  Saturation(const Saturation&) = delete;
  Saturation& operator=(const Saturation&) = delete;
  // The least set that contains start ∩ within and is closed, within `within`, under the relations.
  Node operator()(Node start, Node within);

 private:
  struct Shift {
    u32 from, to;
    Relation next;
  };
  Node saturate(u32 level, Node set, Node within);
  Node fire(u32 level, Node set, Relation r, Node within);
  void settle(u32 level, Frame& kids, Node within);
  Forest& f_;
  const u32 family_, k_saturate, k_fire;  // keys of the cache
  std::vector<std::vector<Shift>> shifts_;       // of each level, those of the relations with this top
  std::vector<std::vector<u32>> first_shift_;    // by the value that they start from
  u32 lowest_ = kNone;                           // level that a relation has for its top
  bool free_ = false;                            // everything is allowed
};

}  // namespace thenar

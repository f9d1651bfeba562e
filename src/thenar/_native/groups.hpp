// Components taken together as one automaton of their own, and where a packed product state keeps which component.
#pragma once

#include "explore.hpp"

namespace thenar {

// One component, or a few with the states that they reach together, were it for them alone: often far fewer than the
// product of their sizes, and one look-up instead of many. States are numbered by codes; code 0 is the initial one.
struct Group {
  std::vector<u32> members;  // components
  u64 n_codes = 0;
  std::vector<u32> words;   // the words of a bit an event in which the members have a say
  std::vector<u64> rows;    // (n_codes, 2, words): what its plants can do, what its specifications allow
  std::vector<u32> local;   // the events that move it, in the order of the alphabet
  std::vector<u32> next;    // (n_codes, local) where an enabled one leads; empty: search the rows of the only member
  std::vector<u32> states;  // (n_codes, members); empty: code k is the state k places after the initial one, in a ring
};

// The groups of a product, those of several components with at most so many codes. The bit after the last event says
// whether every member is in a marked state.
std::vector<Group> groups(const std::vector<Component>& components, const std::vector<u8>& uncontrollable,
                          u64 most_codes);

// A field of bits for each component, those of a group side by side, none across words.
Layout layout(const std::vector<Component>& components, const std::vector<Group>& groups);

}  // namespace thenar

// What the memory of this machine can do: the bounds that an exploration is measured against.
#pragma once

#include "common.hpp"

namespace thenar {

// Independent random 8-byte reads a second over a table of n_words words, with as many in flight as the machine keeps.
double random_reads(u64 n_words, u64 n_reads, Ticker& ticker);

// Bytes a second: written for the first time into fresh memory, and read in order.
struct Stream {
  double touch, read;
};
Stream stream(u64 n_words, Ticker& ticker);

}  // namespace thenar

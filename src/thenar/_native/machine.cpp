#include "machine.hpp"

namespace thenar {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr u64 kChunk = 1 << 16;  // steps between two looks at the ticker: a millisecond

u64* fresh(Buffer<u64>& memory, u64 n_words, Ticker& ticker) {
  ticker.check(0, 0, n_words * sizeof(u64));
  u64* words = memory.extend(n_words);
  advise_large_pages(words, n_words * sizeof(u64));
  for (u64 k = 0; k < n_words;) {
    const u64 end = std::min(n_words, k + kChunk);
    ticker.tick(end - k, 0, 0);
    for (; k < end; ++k) words[k] = k;
  }
  return words;
}

// Keeps a result from being optimised away.
void use(u64 value) { asm volatile("" : : "r"(value)); }

}  // namespace

double random_reads(u64 n_words, u64 n_reads, Ticker& ticker) {
  Buffer<u64> memory;
  n_words = std::bit_ceil(std::max<u64>(n_words, 2));
  const u64* words = fresh(memory, n_words, ticker);
  const int shift = 64 - std::countr_zero(n_words);
  u64 sum = 0, h = 0;
  const auto start = Clock::now();
  for (u64 done = 0; done < n_reads;) {
    const u64 end = std::min(n_reads, done + kChunk);
    ticker.tick(end - done, 0, 0);
    for (; done < end; ++done) {  // the address depends on the number of the read, not on what was read
      h += 0x9e3779b97f4a7c15u;
      sum += words[(h ^ h >> 32) * 0xd6e8feb86659fd93u >> shift];
    }
  }
  const double seconds = seconds_since(start);
  use(sum);
  return static_cast<double>(n_reads) / seconds;
}

Stream stream(u64 n_words, Ticker& ticker) {
  Buffer<u64> memory;
  auto start = Clock::now();
  const u64* words = fresh(memory, n_words, ticker);
  const double touch = seconds_since(start);
  start = Clock::now();
  u64 sum = 0;
  for (u64 k = 0; k < n_words;) {
    const u64 end = std::min(n_words, k + kChunk);
    ticker.tick(end - k, 0, 0);
    for (; k < end; ++k) sum += words[k];
  }
  const double read = seconds_since(start);
  use(sum);
  const double bytes = static_cast<double>(n_words * sizeof(u64));
  return {bytes / touch, bytes / read};
}

}  // namespace thenar

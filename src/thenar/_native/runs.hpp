// A product of many states, a run of them at a time: those that differ in the code of the first group only.
#pragma once

#include "visited.hpp"

namespace thenar {

// Numbers of states whose last digit is the code of the first group lie side by side, and what the other groups say of
// them is the same. An event that does not move the first group leads from all states of a run to the same places of
// another one: 32 states are followed by one instruction. The first radix is padded so that runs begin with a word.
class Runs {
 public:
  using K = Key<u32, 1>;
  static constexpr u64 kLongest = 1024;  // a run is looked at anew whenever a state of it is found

  static u64 length(u64 n_codes) { return std::min((n_codes + 31) / 32 * 32, kLongest); }
  static u64 padded(u64 n_codes) { return (n_codes + length(n_codes) - 1) / length(n_codes) * length(n_codes); }
  // Whether the tables for this are worth their memory.
  static bool fit(const Product<K>& product) {
    return product.first_steps_known() && padded(product.first().n_codes) * product.n_events() <= kMostBits;
  }

  explicit Runs(const Product<K>& product)
      : product_(product), n_(length(product.first().n_codes)), plant_(product.event_words()),
        spec_(product.event_words()), seen_(n_ / 32), fresh_(n_ / 32), column_(product.n_events(), kNone) {
    product.prepare(at_);
    const Group& g = product.first();
    n_columns_ = g.local.size() + 1;
    within_.resize(g.n_codes * n_columns_);
    for (u64 code = 0; code < g.n_codes; ++code)
      for (u64 k = 0; k + 1 < n_columns_; ++k) within_[code * n_columns_ + k] = product.first_step(code, k);
    for (u64 e = 0; e < product.n_events(); ++e) steps_.push_back({0, static_cast<u32>(g.local.size())});
    for (u32 k = 0; k < g.local.size(); ++k) column_[g.local[k]] = steps_[g.local[k]].column = k;
    width_ = padded(g.n_codes) / 32;
    enabled_.resize(product.n_events() * width_);
    breaks_.resize(enabled_.size());
    plants_can_.resize(enabled_.size());
    may_break_.resize(product.event_words());
    std::vector<u64> can(product.event_words()), may(product.event_words());
    for (u64 code = 0; code < g.n_codes; ++code) {
      std::fill(can.begin(), can.end(), ~u64{0});
      std::fill(may.begin(), may.end(), ~u64{0});
      product.first_narrows(code, can.data(), may.data());
      for (u64 e = 0; e < product.n_events(); ++e) {
        const u32 bit = u32{1} << code % 32;
        if (!(can[e / 64] >> e % 64 & 1)) continue;
        const u64 at = e * width_ + code / 32;
        plants_can_[at] |= bit;
        if (may[e / 64] >> e % 64 & 1) {
          enabled_[at] |= bit;
        } else {
          breaks_[at] |= bit;
          may_break_[e / 64] |= u64{1} << e % 64;
        }
      }
    }
  }
  u64 bytes() const { return (3 * enabled_.size() + within_.size()) * sizeof(u32) + queued_.bytes(); }

  // Mark all that is reachable from the initial state.
  void mark(Ranked& ranked, Ticker& ticker, u64 held) {
    ticker.check(0, 0, held + bytes() + product_.span() / n_ / 4);
    words_ = ranked.words();
    words_[0] |= 1;
    queued_ = Bits(product_.span() / n_);
    std::vector<u32> now, next{0};
    while (!next.empty()) {
      std::swap(now, next);
      next.clear();
      for (const u32 run : now) {
        queued_.clear(run);
        const u64 before = n_transitions_;
        expand(run, next);
        ticker.tick(n_transitions_ - before + n_ / 32, n_states_, n_transitions_);
        ticker.check(n_states_, n_transitions_, held + bytes() + (now.size() + next.size()) * sizeof(u32));
      }
    }
  }

  // Say of a state what Product::enabled() says; quick for states of one run after another.
  template <bool Narrow>
  Look enabled(u32 key, u64* plant, u64* spec) {
    if (key - begin_ >= n_) enter(key / static_cast<u32>(n_) * static_cast<u32>(n_));
    code_ = first_ + key - begin_;
    if constexpr (Narrow) {
      const u64* row = product_.first().rows.data() + code_ * 2;
      *plant = plant_[0] & row[0];
      *spec = spec_[0] & row[1];
    } else {
      std::copy(plant_.begin(), plant_.end(), plant);
      std::copy(spec_.begin(), spec_.end(), spec);
      product_.first_narrows(code_, plant, spec);
    }
    return product_.take_marker<Narrow>(plant, spec);
  }
  // After enabled() of the same state.
  u32 after(u32 key, u64 event) const {
    const Step& step = steps_[event];
    return key + step.above + within_[code_ * n_columns_ + step.column];
  }

  u64 n_states() const { return n_states_; }
  u64 n_transitions() const { return n_transitions_; }

 private:
  static constexpr u64 kMostBits = u64{1} << 26;

  void enter(u32 begin) {
    begin_ = begin;
    product_.enabled_above({{begin}}, at_, plant_.data(), spec_.data());
    first_ = product_.first_code(at_);
    for_events([&](u64 e) {
      if (e < steps_.size()) steps_[e].above = product_.step_above(at_, e);
    });
  }

  // Follow what is new in a run, first within it.
  void expand(u32 run, std::vector<u32>& next) {
    const u32 key = run * static_cast<u32>(n_);
    const u64 n_words = n_ / 32;
    product_.enabled_above({{key}}, at_, plant_.data(), spec_.data());
    product_.take_marker(plant_.data(), spec_.data());
    const u64 window = product_.first_code(at_) / 32;
    u64* const own = words_ + key / 32;
    std::fill(seen_.begin(), seen_.end(), 0);
    for (bool any = true; any;) {
      u32 left = 0;
      for (u64 i = 0; i < n_words; ++i) {
        fresh_[i] = static_cast<u32>(own[i]) & ~static_cast<u32>(own[i] >> 32);
        left |= fresh_[i];
        own[i] |= u64{fresh_[i]} << 32;
      }
      if (!(any = left != 0)) break;
      for (u64 i = 0; i < n_words; ++i) n_states_ += count_ones(fresh_[i]);
      prune(window);
      for (u64 i = 0; i < n_words; ++i) seen_[i] |= fresh_[i];
      for_events([&](u64 e) {
        if (column_[e] != kNone && !product_.step_above(at_, e)) scatter(key, window, e, 0, run, next);
      });
      any = false;
      for (u64 i = 0; i < n_words; ++i) any |= (own[i] & ~(own[i] >> 32) & kLow) != 0;
    }
    std::swap(fresh_, seen_);
    for_events([&](u64 e) {
      const u32* const enabled = enabled_.data() + e * width_ + window;
      u64 n = 0;
      for (u64 i = 0; i < n_words; ++i) n += count_ones(fresh_[i] & enabled[i]);
      n_transitions_ += n;
      const u32 step = product_.step_above(at_, e);
      if (!n || !step) return;
      if (column_[e] != kNone) return scatter(key, window, e, step, run, next);
      const u32 to = key + step;
      u64* const other = words_ + to / 32;
      u64 changed = 0;
      for (u64 i = 0; i < n_words; ++i) {
        const u64 add = fresh_[i] & enabled[i] & ~other[i];
        changed |= add;
        other[i] |= add;
      }
      if (changed) queue(static_cast<u32>(to / n_), next);
    });
  }

  void scatter(u32 key, u64 window, u64 e, u32 step, u32 run, std::vector<u32>& next) {
    const u32* const enabled = enabled_.data() + e * width_ + window;
    for (u64 i = 0; i < n_ / 32; ++i)
      for (u32 bits = fresh_[i] & enabled[i]; bits; bits &= bits - 1) {
        const u32 place = static_cast<u32>(i * 32 + static_cast<u64>(std::countr_zero(bits)));
        const u32 to = key + place + step + within_[(window * 32 + place) * n_columns_ + column_[e]];
        u64& word = words_[to / 32];
        const u64 bit = u64{1} << to % 32;
        if (word & bit) continue;
        word |= bit;
        if (const u32 other = static_cast<u32>(to / n_); other != run) queue(other, next);
      }
  }

  // Leave out of fresh_ the illegal states.
  void prune(u64 window) {
    for (u64 w = 0; w < plant_.size(); ++w) {
      const u64 free = plant_[w] & product_.uncontrollable()[w];
      for (u64 events = free & (~spec_[w] | may_break_[w]); events; events &= events - 1) {
        const u64 bit = static_cast<u64>(std::countr_zero(events));
        const u32* const bad = (spec_[w] >> bit & 1 ? breaks_ : plants_can_).data() + (w * 64 + bit) * width_ + window;
        for (u64 i = 0; i < n_ / 32; ++i) fresh_[i] &= ~bad[i];
      }
    }
  }

  template <class F>
  void for_events(F&& f) const {
    for (u64 w = 0; w < plant_.size(); ++w)
      for (u64 events = plant_[w] & spec_[w]; events; events &= events - 1)
        f(w * 64 + static_cast<u64>(std::countr_zero(events)));
  }

  void queue(u32 run, std::vector<u32>& next) {
    if (queued_[run]) return;
    queued_.set(run);
    next.push_back(run);
  }

  static constexpr u64 kLow = 0xffffffff;
  const Product<K>& product_;
  u64 n_;  // states of a run
  At at_;
  std::vector<u64> plant_, spec_;  // of the run
  std::vector<u32> seen_, fresh_;  // states of the run
  std::vector<u32> column_;        // of each event among those that move the first group
  u64 width_;                      // words of a row of these, a bit a code, a row an event:
  std::vector<u32> enabled_;       // the first group can
  std::vector<u32> breaks_;        // its plants can, its specifications forbid
  std::vector<u32> plants_can_;
  std::vector<u64> may_break_;  // the events of breaks_
  struct Step {
    u32 above, column;
  };
  std::vector<Step> steps_;   // of each event: what it adds because of other groups, its column in
  std::vector<u32> within_;   // (codes, columns) what it adds because of the first group; the last column is 0
  u64 n_columns_ = 0;
  u32 begin_ = u32{1} << 31;  // where the run that enabled() has been in begins, first none near 0
  u64 first_ = 0, code_ = 0;  // the code that it begins with, and that of the state
  u64* words_ = nullptr;      // in each the states found and, in the upper half, those that have been followed
  Bits queued_;
  u64 n_states_ = 0, n_transitions_ = 0;
};

}  // namespace thenar

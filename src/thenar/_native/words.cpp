#include "words.hpp"

namespace thenar {
namespace {

bool is_space(u8 c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

u64 mixed(u64 x) {
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93u;
  return x ^ x >> 32;
}

// Up to eight bytes as a number.
u64 load(const u8* bytes, i64 length) {
  u64 piece = 0;
  std::memcpy(&piece, bytes, static_cast<std::size_t>(length));
  return piece;
}

// Open addressing. What tells a word stands in its slot, so that one cache miss is enough: its bytes if they are eight at
// most, else their hash, and then the text is looked at too.
class Table {
 public:
  Table(const u8* text, Words& words) : text_(text), words_(words), slots_(1024) {}

  i32 number(i64 start, i64 end) {
    const i64 length = end - start;
    const u64 key = length <= 8 ? load(text_ + start, length) : hash(start, end);
    u64 at = first(key, static_cast<u32>(length));
    for (; slots_[at].number >= 0; at = (at + 1) & (slots_.size() - 1)) {
      const Slot& slot = slots_[at];
      if (slot.key == key && slot.length == static_cast<u32>(length) && (length <= 8 || same(slot.number, start, end)))
        return slot.number;
    }
    const i32 fresh = static_cast<i32>(words_.starts.size());
    slots_[at] = {key, static_cast<u32>(length), fresh};
    words_.starts.push_back(start);
    words_.ends.push_back(end);
    if (2 * words_.starts.size() > slots_.size()) grow();
    return fresh;
  }

 private:
  struct Slot {
    u64 key = 0;
    u32 length = 0;  // as far as 32 bits tell it
    i32 number = -1;
  };

  u64 first(u64 key, u64 length) const { return mixed(key + length * 0x9e3779b97f4a7c15u) & (slots_.size() - 1); }

  u64 hash(i64 at, i64 end) const {
    u64 h = 0;
    for (; end - at > 8; at += 8) h = mixed(h ^ load(text_ + at, 8));
    return mixed(h ^ load(text_ + at, end - at));
  }

  bool same(i32 number, i64 start, i64 end) const {
    const i64 first = words_.starts[static_cast<u64>(number)], last = words_.ends[static_cast<u64>(number)];
    return last - first == end - start && std::memcmp(text_ + first, text_ + start, static_cast<u64>(end - start)) == 0;
  }

  void grow() {
    std::vector<Slot> old(4 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.number < 0) continue;
      u64 at = first(slot.key, slot.length);
      while (slots_[at].number >= 0) at = (at + 1) & (slots_.size() - 1);
      slots_[at] = slot;
    }
  }

  const u8* text_;
  Words& words_;
  std::vector<Slot> slots_;
};

}  // namespace

Words words_of(const u8* text, i64 length) {
  Words words;
  Table table(text, words);
  for (i64 at = 0; at < length;) {
    while (at < length && is_space(text[at])) ++at;
    const i64 start = at;
    while (at < length && !is_space(text[at])) ++at;
    if (at > start) words.ids.push_back(table.number(start, at));
  }
  return words;
}

}  // namespace thenar

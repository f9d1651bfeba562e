// The words of a text, numbered: what a reader of a million transitions does first.
#pragma once

#include "common.hpp"

namespace thenar {

// Word k of the text is the distinct word number ids[k]; distinct words are numbered as they are first met, and
// number w is text[starts[w]] .. text[ends[w]-1]. Words are what ASCII white space separates.
struct Words {
  std::vector<i32> ids;
  std::vector<i64> starts, ends;
};

Words words_of(const u8* text, i64 length);

}  // namespace thenar

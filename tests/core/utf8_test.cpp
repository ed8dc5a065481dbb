// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/utf8.hpp"

#include <gtest/gtest.h>

#include "bouncelab/core/random.hpp"

namespace bouncelab {
namespace {

bool is_valid(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = utf8_character(text);
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

TEST(Utf8, ValidTextStaysAsItIs) {
  for (const std::string text : {"", "a.wav",
                                 "Pr\xC3\xBC"
                                 "fung \xE2\x82\xAC \xF0\x9F\x8E\xB1",
                                 "\n\x1b\x7f"}) {
    EXPECT_EQ(utf8_of_bytes(text), text);
    EXPECT_EQ(bytes_of_utf8(text), text);
  }
}

TEST(Utf8, AnyBytesBecomeValidTextAndComeBack) {
  EXPECT_EQ(utf8_of_bytes("caf\xE9"), "caf\xEE\xBF\xA9");  // U+EFE9
  Random random(7, RandomStream::test, 3);
  for (int k = 0; k < 20000; ++k) {
    std::string bytes;
    const int n = static_cast<int>(random.uniform(0.0, 12.0));
    for (int j = 0; j < n; ++j) bytes += static_cast<char>(static_cast<int>(random.uniform(0.0, 256.0)));
    if (k % 3 == 0) bytes.insert(bytes.size() / 2, "\xEE\xBE\x80");  // a stand-in that is there already
    const std::string text = utf8_of_bytes(bytes);
    EXPECT_TRUE(is_valid(text));
    EXPECT_EQ(bytes_of_utf8(text), bytes);
  }
}

}  // namespace
}  // namespace bouncelab

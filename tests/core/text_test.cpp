// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab {
namespace {

using testing::HasSubstr;

std::size_t characters(const std::string& text) {
  std::size_t n = 0;
  for (const char c : text) n += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;
  return n;
}

TEST(Printable, LeavesOrdinaryTextAlone) {
  const std::string text = "drops/Prüfung 3 – Stahlkugel, \"C:\\old\" \xF0\x9F\x8E\xB1.wav";
  EXPECT_EQ(printable(text), text);
  EXPECT_EQ(printable(""), "");
}

TEST(Printable, EscapesControlCharactersAndEscapeSequences) {
  EXPECT_EQ(printable("a\nb\r\tc\x1b[31m\x7f"), "a\\nb\\r\\tc\\x1b[31m\\x7f");
  EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable("\xC2\x9B"), "\\xc2\\x9b");  // CSI as one character
  EXPECT_EQ(printable("\xE2\x80\xAEvaw.a"), "\\xe2\\x80\\xaevaw.a") << "the direction of writing was turned";
}

TEST(Printable, EscapesBytesThatAreNotUtf8) {
  EXPECT_EQ(printable("caf\xE9.wav"), "caf\\xe9.wav");
  EXPECT_EQ(printable("\xC0\xAF"), "\\xc0\\xaf");           // a '/' in more bytes than it needs
  EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80");  // half of a surrogate pair
  EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(printable("\xE2\x82"), "\\xe2\\x82");  // cut off
}

TEST(Printable, CutsALongTextInItsMiddleAndSaysHowLongItWas) {
  const std::string cut = printable("begin" + std::string(8'000'000, 'x') + "end.wav");
  EXPECT_LE(cut.size(), 200U);
  EXPECT_THAT(cut, testing::StartsWith("beginxxx"));
  EXPECT_THAT(cut, testing::EndsWith("xxxend.wav (8000012 bytes)"));
  EXPECT_EQ(printable(std::string(200, 'x')), std::string(200, 'x'));
}

TEST(Printable, NeverCutsACharacterAndCountsAnEscapeAsWhatItShows) {
  for (const std::string part : {"\xE2\x82\xAC", "\xF0\x9F\x8E\xB1", "\x1b", "\xFF", "\xC3\xA9x"})
    for (int shift = 0; shift < 5; ++shift) {
      std::string text(static_cast<std::size_t>(shift), 'a');
      for (int k = 0; k < 1000; ++k) text += part;
      const std::string cut = printable(text);
      EXPECT_LE(characters(cut), 200U);
      EXPECT_EQ(printable(cut), cut) << "not valid UTF-8, or not the same when applied twice";
      EXPECT_THAT(cut, testing::Not(HasSubstr("\\xe2")));
    }
}

TEST(Printable, EveryMessageIsOneLineOfThousandCharactersAtMost) {
  const FileError error("new\nline\x1b[2J.wav", "line 7: '" + std::string(1'000'000, '\a') + "' is not a number");
  EXPECT_THAT(error.what(), testing::StartsWith("new\\nline\\x1b[2J.wav: line 7: '\\x07"));
  EXPECT_LE(std::string(error.what()).size(), 1000U);
  EXPECT_LE(std::string(InvalidArgument(std::string(5000, 'x')).what()).size(), 1000U);
  EXPECT_STREQ(FileExists("a\nb").what(), "a\\nb: exists already");
}

TEST(ShortNames, AreTheShortestEndsThatNoOtherPathHas) {
  EXPECT_EQ(short_names({"/me/a.wav", "b.wav", "x/c", "y/c", "c", "p/x/c", "y/c", "", "d/"}),
            (std::vector<std::string>{"a.wav", "b.wav", "x/c", "y/c", "c", "p/x/c", "y/c", "", "d/"}));
  EXPECT_EQ(short_names({"rec/granite/1/a", "rec/steel/1/a", "rec/steel/2/a"}),
            (std::vector<std::string>{"granite/1/a", "steel/1/a", "2/a"}));
}

TEST(DecodedText, IsTheSameInPiecesOfAnySize) {
  const std::string utf8 = "Zeit;\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80\n";
  const std::u16string utf16 = u"\uFEFFZeit;\u00E4\u20AC\U0001F600\n";
  const std::u32string utf32 = U"\uFEFFZeit;\u00E4\u20AC\U0001F600\n";
  std::string big_endian(reinterpret_cast<const char*>(utf16.data()), 2 * utf16.size());
  for (std::size_t k = 0; k < big_endian.size(); k += 2) std::swap(big_endian[k], big_endian[k + 1]);
  for (const std::string& bytes :
       {"\xEF\xBB\xBF" + utf8, big_endian, std::string(reinterpret_cast<const char*>(utf16.data()), 2 * utf16.size()),
        std::string(reinterpret_cast<const char*>(utf32.data()), 4 * utf32.size())})
    for (std::size_t n = 4; n <= bytes.size(); ++n) {
      TextDecoder decoder("x");
      std::string text;
      for (std::size_t at = 0; at < bytes.size(); at += at == 0 ? n : 1)
        decoder.append(std::string_view(bytes).substr(at, at == 0 ? n : 1), text);
      decoder.finish();
      EXPECT_EQ(text, utf8) << n;
    }
}

TEST(DecodedText, NamesWhatItIsNot) {
  const auto message = [](const std::string& bytes) -> std::string {
    try {
      return decoded_text(bytes, "x");
    } catch (const FileError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(message(std::string("\xFF\xFE\0\0a\0\0\0", 8)), "a");
  EXPECT_EQ(message(std::string("\0\0\xFE\xFF\0\0\0a", 8)), "a");
  EXPECT_THAT(message(std::string("\0\0\xFE\xFF\0\0\0", 7)), HasSubstr("cut off within a character of UTF-32"));
  const std::string zip = "PK\x03\x04" + std::string(26, ' ');
  for (const char* first : {"[Content_Types].xml", "docProps/app.xml", "xl/workbook.xml",
                            "mimetypeapplication/vnd.oasis", "Index/Document.iwa"})
    EXPECT_EQ(message(zip + first), "x: is a workbook: save the sheet as CSV") << first;
  EXPECT_EQ(message("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"), "x: is a workbook: save the sheet as CSV");
  EXPECT_EQ(message(zip + "Raw Data.csv"), "x: is a ZIP archive: unpack it, or save the sheet as CSV");
  EXPECT_THAT(message("PK\x03\x04"), HasSubstr("ZIP archive"));
  EXPECT_THAT(message(std::string("\xFF\xFE\0\xDC", 4)), HasSubstr("damaged UTF-16"));
  EXPECT_THAT(message(std::string("a\0b\0\0\0c d e f g", 15)), HasSubstr("bytes 0"));
  EXPECT_THAT(message("\x81"), HasSubstr("neither UTF-8"));
  EXPECT_EQ(message("\x80 5\n"), "\xE2\x82\xAC 5\n");                                  // the euro of Windows-1252
  EXPECT_EQ(message(std::string("\xFF\xFE\x3D\xD8\x00\xDE", 6)), "\xF0\x9F\x98\x80");  // a pair of surrogates
}

}  // namespace
}  // namespace bouncelab

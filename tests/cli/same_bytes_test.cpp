// SPDX-License-Identifier: GPL-3.0-or-later
/// Every stage gives the same bytes on every x86-64 processor and with every compiler.
#include <array>
#include <string>

#include "program.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::cli_test {
namespace {

struct Stage {
  std::string arguments, output, sha256;
};

// The sums stand for gcc and clang, Debug and Release alike. A change of results changes them: put in what the failing
// test prints, and say in the commit why.
const std::array<Stage, 10> kStages{{
    {"simulate --drops 2 --impacts 40 --asperities 5000 --out impacts.csv", "impacts.csv",
     "b76079db16f59b100c2b20209e073913390c57a2b09e0c23550dbd48733194d6"},
    {"simulate --drops 2 --impacts 25 --asperities 2000 --drag --contact coulomb --tilt 0.02 --law viscoelastic:0.02 "
     "--radius-law lognormal:1e-3,0.4 --out other.csv",
     "other.csv", "58f4605717d9e3d5fd8a69abc9f45444906cdad7fcfbeef5fccea0eb77c9f8f7"},
    {"simulate --drops 2 --impacts 25 --asperities 2000 --contact stronge --mu 0.02 --contact-patch --spin 30,20,0 "
     "--out patch.csv",
     "patch.csv", "7c35ab1a72366106436a84008afc492ae95a11cee4670cee5dfbb86a13adb263"},
    {"synthesize impacts.csv --rate 24000 --out sound.wav --truth truth.csv", "sound.wav",
     "fd946d72721586e1946c5fd70d842da3bd4c5682870132235fba750d33e43514"},
    {"", "truth.csv", "3c950260db0ddfb8ad8cef9b6ad0e72d46403e4ab0bf17a4835cb42a3c8f1a52"},
    {"synthesize other.csv --rate 24000 --hard rough --out hard.wav", "hard.wav",
     "4d3c2e66541b23513de996c061be607e632502510dd13f30bfceacf405491f74"},
    {"detect sound.wav --out onsets.csv", "onsets.csv",
     "26ef54b2f4217f32bb0445020d77fcfd6eac61e573e2119164ddb3e414e316b2"},
    {"restitution onsets.csv --correct-drag --ball steel:6mm --plate glass --out samples.csv", "samples.csv",
     "fa10f447720f92c892d433b980221416c717d99b86c913719a725e8f400c133e"},
    {"fit samples.csv --goodness-replicates 3 --bootstrap 3 --out fit.json --table law.csv", "fit.json",
     "baeeb15457dfc39057af16441c31214bae5b1d33af10a8e8ec960bd869e2031b"},
    {"", "law.csv", "57a91fee98399a2d08a028d4ba424aaa8d677ab575295b223243f09104497856"},
}};

class SameBytesTest : public ProgramTest {
 protected:
  /// @param prefix  what stands before the program on the command line
  void expect_same_bytes(const std::string& prefix) {
    // an emulator of one process spends its time on the threads' waiting
    const std::string threads = prefix.empty() ? "" : " --threads 1";
    for (const Stage& stage : kStages) {
      if (!stage.arguments.empty()) {
        const Result result = shell(prefix + " \"$B\" " + stage.arguments + " --quiet --force" + threads);
        // 1: the few samples do not identify the constants
        ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 1) << stage.arguments << "\n" << result.err;
      }
      EXPECT_EQ(sha256_of(stage.output), stage.sha256) << stage.output << " " << prefix;
    }
  }

  std::string sha256_of(const std::string& file) const {
    std::string sum;
    FILE* pipe = popen(("sha256sum '" + (folder_ / file).string() + "'").c_str(), "r");
    for (int c = fgetc(pipe); c != EOF && c != ' '; c = fgetc(pipe)) sum += static_cast<char>(c);
    pclose(pipe);
    return sum;
  }

  void expect_same_bytes_on(const std::string& processor) {
    if (test::kSanitizer != nullptr) GTEST_SKIP() << "the sanitizers' memory does not fit into the emulator's";
    if (std::system("command -v qemu-x86_64 >/dev/null") != 0)
      GTEST_SKIP() << "qemu-x86_64 is not installed (Debian: qemu-user): not tried on a processor of type "
                   << processor;
    expect_same_bytes("qemu-x86_64 -cpu " + processor);
  }
};

TEST_F(SameBytesTest, OfEveryStageOnThisProcessor) { expect_same_bytes(""); }

TEST_F(SameBytesTest, WhereTheCLibraryTakesNoFusedMultiplyAdd) {
  expect_same_bytes("env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-AVX2_Usable,-FMA_Usable,-AVX512F_Usable");
}

TEST_F(SameBytesTest, OnAProcessorWithSse2Only) { expect_same_bytes_on("qemu64"); }

TEST_F(SameBytesTest, OnAProcessorWithAvx2AndFma) { expect_same_bytes_on("Haswell"); }

}  // namespace
}  // namespace bouncelab::cli_test

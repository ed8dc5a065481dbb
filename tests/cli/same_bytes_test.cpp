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
     "2ebb0059c65bee867a9e077b491d8a840b1050fe20f44590fb4a0686aa5657c4"},
    {"", "truth.csv", "16852b742f0bfc9b304b9c8cb2e056158c3619cbeff0a79db17a0605c4f42eeb"},
    {"synthesize other.csv --rate 24000 --hard rough --out hard.wav", "hard.wav",
     "963e9c642f4e4c92fe6ef216b730d03f0dbe1b865c6507c04bcfcdb807373a5b"},
    {"detect sound.wav --out onsets.csv", "onsets.csv",
     "b4495a19f0bd389db85f07ea98675933b093f0f382ee65a66fa55bf4603ad13b"},
    {"restitution onsets.csv --correct-drag --ball steel:6mm --plate glass --out samples.csv", "samples.csv",
     "82e12ff59553fe5fc7dd468b2bb1af72fb1e70ac102635054a75098bad4d6fad"},
    {"fit samples.csv --goodness-replicates 3 --bootstrap 3 --out fit.json --table law.csv", "fit.json",
     "cef7286dbfcd4d689d40e8ffd31327116ba4fb4600bc09a3396d4cdbd5250a28"},
    {"", "law.csv", "4b0e9b136eca2066706c419c0b6109e84e3db931dcf4feb99866a5a7ce244871"},
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

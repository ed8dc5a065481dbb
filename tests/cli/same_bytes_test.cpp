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
const std::array<Stage, 11> kStages{{
    {"simulate --drops 2 --impacts 40 --asperities 5000 --out impacts.csv", "impacts.csv",
     "b76079db16f59b100c2b20209e073913390c57a2b09e0c23550dbd48733194d6"},
    {"simulate --drops 2 --impacts 25 --asperities 2000 --drag --contact coulomb --tilt 0.02 --law viscoelastic:0.02 "
     "--radius-law lognormal:1e-3,0.4 --out other.csv",
     "other.csv", "58f4605717d9e3d5fd8a69abc9f45444906cdad7fcfbeef5fccea0eb77c9f8f7"},
    {"simulate --drops 2 --impacts 25 --asperities 2000 --contact stronge --mu 0.02 --contact-patch --spin 30,20,0 "
     "--out patch.csv",
     "patch.csv", "7c35ab1a72366106436a84008afc492ae95a11cee4670cee5dfbb86a13adb263"},
    {"synthesize impacts.csv --rate 24000 --out sound.wav --truth truth.csv", "sound.wav",
     "3307287e4f530304c186f5295109f927a69cbd17ec624e390cdf657ebdd090c5"},
    {"", "truth.csv", "c8cd1c13d2a8feb7c82cf42f8d25c84a35d2701a1715038b8b544787114e76da"},
    {"synthesize other.csv --rate 24000 --hard rough --out hard.wav", "hard.wav",
     "18dc044e55d696c6ab2a21ba8b880565102f7cb555e374880ce4441f0ef42612"},
    // as many modes as ring by a transform
    {"synthesize other.csv --rate 96000 --out fine.wav", "fine.wav",
     "125b115e345829b5f0d5b3db3bfe672ead12e36241faf96a1f4973926098c385"},
    {"detect sound.wav --out onsets.csv", "onsets.csv",
     "43f99382c02c3e436b5b4cb7e3b799f1ce590c5052741fc41a1f363751ebe5e5"},
    {"restitution onsets.csv --correct-drag --ball steel:6mm --plate glass --out samples.csv", "samples.csv",
     "eadf3182fb0223925818b1c5de4529526b2e937575bbcd84e5c4b36c1f2c38e8"},
    {"fit samples.csv --goodness-replicates 3 --bootstrap 3 --out fit.json --table law.csv", "fit.json",
     "b17140ad1b85f383a1c245501ce9de353ba221ce7670dffd3384038d39daaa49"},
    {"", "law.csv", "67b2b721a8f9c7344199f9daeae303eea14e8387131d303352caa5d4a3f39f84"},
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

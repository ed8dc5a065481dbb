// SPDX-License-Identifier: GPL-3.0-or-later
// Disks that are full, folders that cannot be written or vanish, files that change while they are read.
#include <unistd.h>

#include <atomic>
#include <thread>

#include "fault_test.hpp"

namespace bouncelab::fault_test {
namespace {

class Disk : public FaultTest {
 protected:
  /// Runs a job with `out` on a file system of its own, of that size, and copies what it left to `left`.
  Result run_on_disk(const Job& job, const std::string& size) const {
    fs::remove_all(path("left"));
    fs::create_directory(path("left"));
    write("on_disk.sh", "mount -t tmpfs -o size=" + size +
                            " none out || exit 125\n\"$@\"\ncode=$?\n"
                            "cp -r out/. left\nexit $code\n");
    return run_job(job, 2, "", unshared() + "sh on_disk.sh ");
  }
  static std::string unshared() { return ::geteuid() == 0 ? "unshare -m " : "unshare -rm "; }
};

TEST_F(Disk, ThatIsFullEndsInTheWholeResultOrInOneLine) {
  if (run_under(unshared() + "sh -c 'mount -t tmpfs none out && exec \"$0\" \"$@\"' ", "--version").exit_code != 0)
    GTEST_SKIP() << "no file system can be mounted here";
  for (const Job& job : jobs()) {
    const Undisturbed whole = undisturbed(job);
    int n_full = 0;
    for (const char* size : {"4k", "16k", "64k", "300k", "1500k", "30m"}) {
      SCOPED_TRACE(std::string(size) + " " + job.arguments);
      const Result result = run_on_disk(job, size);
      ASSERT_NE(result.exit_code, 125) << result.err;
      expect_whole_or_explained(result, files_in("left"), whole);
      if (result.exit_code == 3) {
        ++n_full;
        EXPECT_THAT(result.err, testing::HasSubstr("out")) << "which file?";
      }
    }
    EXPECT_GT(n_full, 0) << job.name;
  }
}

class Folder : public FaultTest {};

TEST_F(Folder, ThatMayNotBeWrittenIsSaidInOneLine) {
  const std::string before = ::geteuid() == 0 ? "setpriv --reuid=65534 --regid=65534 --clear-groups " : "";
  if (run_under(before, "--version").exit_code != 0)
    GTEST_SKIP() << "a user without rights cannot run the program where it is";
  for (const Job& job : jobs()) {
    SCOPED_TRACE(job.arguments);
    fs::permissions(path("out"),
                    fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
    cli_test::expect_one_line_error(run_job(job, 2, "", before), 3, {"out", "ermission"});
    EXPECT_THAT(files_in(), testing::IsEmpty());
    empty_out();
  }
}

TEST_F(Folder, ThatVanishesDuringTheWorkIsSaidInOneLine) {
  RandomDisturbance random;
  for (const char* name : {"synthesize", "analyze", "paper"}) {
    const Undisturbed whole = undisturbed(job(name));
    for (int k = 0; k < n_times(4); ++k) {
      SCOPED_TRACE(std::string(name) + ", BOUNCELAB_FAULT_SEED=" + std::to_string(random.seed()));
      const double after_s = random.between(0, whole.duration_s.at(2));
      std::thread remover([&] {
        std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
        std::error_code ignored;
        fs::rename(path("out"), path("gone"), ignored);
      });
      const Result result = run_job(job(name), 2);
      remover.join();
      if (result.exit_code != whole.exit_code) cli_test::expect_one_line_error(result, 3, {"out"});
      fs::remove_all(path("gone"));
      empty_out();
    }
  }
}

class Recording : public FaultTest {
 protected:
  /// Runs `detect` while the recording's length changes from the one to the other, and so on.
  Result detect_while_length_changes(const std::vector<std::uintmax_t>& lengths) const {
    std::atomic<bool> done = false;
    std::thread writer([&] {
      RandomDisturbance random;
      for (std::size_t k = 0; !done; k = (k + 1) % lengths.size()) {
        fs::resize_file(path("long.wav"), lengths[k]);
        std::this_thread::sleep_for(std::chrono::duration<double>(random.between(0, 2e-3)));
      }
    });
    const Result result = run("detect long.wav --out out/o.csv --quiet --force");
    done = true;
    writer.join();
    return result;
  }
};

TEST_F(Recording, ThatGrowsWhileItIsReadGivesItsFirstPart) {
  ASSERT_EQ(run("synthesize i.csv --rate 22050 --max-mode 10000 --out long.wav --quiet").exit_code, 0);
  ASSERT_EQ(run("detect long.wav --out out/o.csv --quiet").exit_code, 0);
  const Files whole = files_in();
  const std::string sound = cli_test::content_of(path("long.wav"));
  for (int k = 0; k < n_times(5); ++k) {
    write("long.wav", sound);
    std::vector<std::uintmax_t> lengths;
    for (std::uintmax_t n = 1; n < 4096; ++n) lengths.push_back(sound.size() + n);  // more of them would be sound
    const Result result = detect_while_length_changes(lengths);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(files_in().at("o.csv"), whole.at("o.csv"));
  }
}

TEST_F(Recording, ThatShrinksWhileItIsReadIsReadWholeOrRefused) {
  ASSERT_EQ(run("synthesize i.csv --rate 22050 --max-mode 10000 --out long.wav --quiet").exit_code, 0);
  const std::string sound = cli_test::content_of(path("long.wav"));
  for (int k = 0; k < n_times(10); ++k) {
    write("long.wav", sound);
    empty_out();
    const Result result = detect_while_length_changes({100 + sound.size() / 10, sound.size()});
    // zeros come back where it was cut: they are sound, for all that can be known
    if (result.exit_code == 0) continue;
    cli_test::expect_one_line_error(result, 3, {"long.wav"});
    EXPECT_THAT(files_in(), testing::IsEmpty());
  }
}

}  // namespace
}  // namespace bouncelab::fault_test

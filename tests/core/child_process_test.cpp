// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr ChildLimits kWide{60.0, 1'000'000'000};
constexpr ChildLimits kTight{0.2, 50'000'000};

void write_text(const ChildProcess::Output& write, const std::string& text) { write(std::as_bytes(std::span(text))); }

void compute_for_a_tenth_of_a_second() {
  const std::clock_t begin = std::clock();
  while (std::clock() - begin < CLOCKS_PER_SEC / 10) {
  }
}

/// Behaves as a decoder may on a damaged file, after its first output.
ChildProcess::Work misbehaving(const std::string& way) {
  return [way](const ChildProcess::Output& write) {
    write_text(write, "a");
    if (way == "loop")
      while (std::clock() >= 0) {
      }
    if (way == "crash") std::abort();
    if (way == "exit") _exit(7);
    if (way == "refuse") throw FileError("a.xyz", "line 3: no number");
    if (way == "fail") throw std::runtime_error("something else");
    if (way == "allocate") write_text(write, std::string(1'000'000'000, 'x'));
    write_text(write, "!");
  };
}

std::string all_of(ChildProcess& child) {
  std::string text;
  for (std::array<std::byte, 1000> piece{}; const std::size_t n = child.read(piece);)
    text.append(reinterpret_cast<const char*>(piece.data()), n);
  return text;
}

/// What is said at the end, after the output.
std::string refusal(const std::string& way, const ChildLimits& limits) {
  ChildProcess child(misbehaving(way), "a.xyz", -1, limits);
  EXPECT_THAT(all_of(child), StartsWith("a"));
  return test::refusal<FileError>([&] { child.finish("make it again"); });
}

TEST(ChildProcess, GivesWhatAFunctionWrites) {
  for (const std::size_t n : {0UL, 1UL, 5'000'000UL}) {
    const std::string text(n, 'q');
    ChildProcess child([&](const ChildProcess::Output& write) { write_text(write, text); }, "a.xyz", -1, kWide);
    EXPECT_EQ(all_of(child), text);
    EXPECT_NO_THROW(child.finish(""));
  }
}

TEST(ChildProcess, ThrowsWhatTheFunctionThrewAndSurvivesWhateverItDoes) {
  EXPECT_EQ(refusal("refuse", kWide), "a.xyz: line 3: no number");
  EXPECT_EQ(refusal("fail", kWide), "a.xyz: cannot be read (something else): damaged? make it again");
  EXPECT_THAT(refusal("loop", kTight), HasSubstr("of processor time to read: damaged? make it again"));
  for (const char* way : {"crash", "exit"})
    EXPECT_THAT(refusal(way, kWide), HasSubstr("a.xyz: ended the process that read it"));
  if (kHasAddressSanitizer) GTEST_SKIP() << "the sanitizer's own memory would count";
  EXPECT_EQ(refusal("allocate", kTight), "a.xyz: takes more than 50 MB of memory to read: damaged? make it again");
}

TEST(ChildProcess, CountsTheTimeOfAFunctionAnewWithEachPieceOfItsOutput) {
  ChildProcess child(
      [](const ChildProcess::Output& write) {
        for (int k = 0; k < 5; ++k) {  // half a second in all
          compute_for_a_tenth_of_a_second();
          write_text(write, "x");
        }
      },
      "a.xyz", -1, {0.3});
  EXPECT_EQ(all_of(child), "xxxxx");
  EXPECT_NO_THROW(child.finish(""));
}

TEST(ChildProcess, HasTheFileThatIsHandedOver) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.txt") << "content";
  const int descriptor = open((folder / "a.txt").c_str(), O_RDONLY);
  ChildProcess function(
      [](const ChildProcess::Output& write) {
        std::array<std::byte, 100> text{};
        const ssize_t n = pread(ChildProcess::kHandedOver, text.data(), text.size(), 0);
        write(std::span(text).first(static_cast<std::size_t>(n)));
      },
      "a.txt", descriptor, kWide);
  EXPECT_EQ(all_of(function), "content");
  EXPECT_EQ(run_program("/bin/cat", {"/dev/fd/3"}, "a.txt", descriptor, kWide).output, "content");
  close(descriptor);
}

TEST(ChildProcess, ReturnsAlsoWhereTheHostLetsNobodyWaitForChildren) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(refusal("", kWide), "no error");
  EXPECT_EQ(refusal("refuse", kWide), "a.xyz: line 3: no number");
  EXPECT_THAT(refusal("crash", kWide), HasSubstr("ended the process"));
  std::signal(SIGCHLD, before);
}

TEST(ChildProcess, NoticesTheEndOfOneChildAmongManyThatWereStartedAtTheSameTime) {
  if (!kMayStartChildBesideThreads) GTEST_SKIP() << "a child that is started beside other threads may wait for ever";
  // a child that held the pipe of another would keep it open
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 8; ++thread)
    threads.emplace_back([thread] {
      for (int k = 0; k < 10; ++k) {
        ChildProcess bystander(misbehaving(""), "a.xyz", -1, kWide);
        if ((thread + k) % 2 == 0)
          EXPECT_THAT(refusal("crash", kWide), HasSubstr("ended"));
        else
          EXPECT_EQ(refusal("", kWide), "no error");
        EXPECT_EQ(all_of(bystander), "a!");
      }
    });
  for (std::thread& thread : threads) thread.join();
}

/// False also for a process that has ended and for which nobody has waited.
bool is_running(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  return std::getline(stat, text) && text.find(") Z ") == std::string::npos;
}

TEST(ChildProcess, EndsWhenItsOwnerIsKilled) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const pid_t owner = fork();
  if (owner == 0) {
    ChildProcess child(
        [](const ChildProcess::Output& write) {
          const pid_t pid = getpid();
          for (;;) write(std::as_bytes(std::span(&pid, 1)));
        },
        "a.xyz", -1, kWide);
    pid_t pid = 0;
    child.read(std::as_writable_bytes(std::span(&pid, 1)));
    if (write(ends[1], &pid, sizeof pid) < 0) _exit(1);
    pause();
  }
  pid_t child = 0;
  ASSERT_EQ(read(ends[0], &child, sizeof child), static_cast<ssize_t>(sizeof child));
  EXPECT_TRUE(is_running(child));
  kill(owner, SIGKILL);
  waitpid(owner, nullptr, 0);
  for (int k = 0; k < 600 && is_running(child); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_FALSE(is_running(child));
  close(ends[0]);
  close(ends[1]);
}

TEST(ChildProcess, IsEndedWithItsObjectHoweverLongItWouldRun) {
  pid_t child = 0;
  {
    ChildProcess running("/bin/sh", {"-c", "echo $$; exec sleep 1000"}, "x", -1, {10.0});
    std::array<std::byte, 1> digit{};
    std::string text;
    while (running.read(digit) == 1 && std::to_integer<char>(digit[0]) != '\n') text += std::to_integer<char>(digit[0]);
    child = static_cast<pid_t>(std::stol(text));
    EXPECT_EQ(kill(child, 0), 0);
  }
  EXPECT_EQ(kill(child, 0), -1);  // and was waited for
  EXPECT_EQ(errno, ESRCH);
}

TEST(ChildProcess, ManyComplaintsOfAProgramDoNotKeepItFromGoingOn) {
  // a pipe holds 64 kB: a program whose complaints nobody reads would wait for ever
  const ProgramResult result = run_program(
      "/bin/sh", {"-c", "i=0; while [ $i -lt 20000 ]; do echo complaint $i >&2; i=$((i+1)); done; echo done; exit 3"},
      "x", -1, {100.0});
  EXPECT_FALSE(result.ended_well);
  EXPECT_EQ(result.output, "done\n");
  EXPECT_THAT(result.complaints, StartsWith("complaint 0\ncomplaint 1\n"));
  EXPECT_LE(result.complaints.size(), 4096u);
}

TEST(ChildProcess, TheProcessorTimeOfAProgramIsLimited) {
  EXPECT_FALSE(run_program("/bin/sh", {"-c", "while :; do :; done"}, "x", -1, {1.0}).ended_well);
}

TEST(ChildProcess, AProgramThatCannotBeStartedSaysSo) {
  const ProgramResult result = run_program("/no/such/program", {}, "x", -1, {1.0});
  EXPECT_FALSE(result.ended_well);
  EXPECT_EQ(result.complaints, "/no/such/program cannot be started\n");
}

}  // namespace
}  // namespace bouncelab

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/child_process.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab {
namespace {

using testing::HasSubstr;

constexpr ChildLimits kWide{60.0, 1'000'000'000};
constexpr ChildLimits kTight{0.2, 50'000'000};

std::string refusal(ChildProcess& child, std::string_view request, const ChildLimits& limits) {
  try {
    child.ask(request, limits, "a.xyz", "make it again");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

/// Does as the request says, as a reader might on a damaged file.
std::string misbehave(std::string_view request, int) {
  if (request == "loop")
    while (std::clock() >= 0) {
    }
  if (request == "crash") std::abort();
  if (request == "exit") _exit(7);
  if (request == "refuse") throw FileError("a.xyz", "line 3: no number");
  if (request == "fail") throw std::runtime_error("something else");
  if (request == "allocate") return std::string(1'000'000'000, 'x');
  if (request == "pid") return std::to_string(getpid());
  return std::string(request) + "!";
}

TEST(ChildProcess, AnswersOneRequestAfterTheOther) {
  ChildProcess child(misbehave, "a.xyz");
  for (const std::size_t n : {0UL, 1UL, 5'000'000UL, 10UL}) {
    const std::string request(n, 'q');
    EXPECT_EQ(child.ask(request, kWide, "a.xyz", ""), request + "!");
    EXPECT_TRUE(child.is_usable());
  }
}

TEST(ChildProcess, ThrowsWhatTheChildThrew) {
  ChildProcess child(misbehave, "a.xyz"), other(misbehave, "a.xyz");
  EXPECT_EQ(refusal(child, "refuse", kWide), "a.xyz: line 3: no number");
  EXPECT_FALSE(child.is_usable()) << "what the failure left behind is not known";
  EXPECT_THAT(refusal(child, "x", kWide), HasSubstr("has ended"));
  EXPECT_EQ(refusal(other, "fail", kWide), "a.xyz: cannot be read (something else): damaged? make it again");
}

TEST(ChildProcess, EndsAReaderThatNeverReturns) {
  ChildProcess child(misbehave, "a.xyz");
  EXPECT_EQ(child.ask("a", kTight, "a.xyz", ""), "a!");
  EXPECT_THAT(refusal(child, "loop", kTight), HasSubstr("of processor time to read: damaged? make it again"));
  EXPECT_FALSE(child.is_usable());
}

std::string compute_for_a_tenth_of_a_second(std::string_view, int) {
  const std::clock_t begin = std::clock();
  while (std::clock() - begin < CLOCKS_PER_SEC / 10) {
  }
  return {};
}

TEST(ChildProcess, CountsTheTimeOfEachRequestAnew) {
  ChildProcess child(compute_for_a_tenth_of_a_second, "a.xyz");
  // half a second in all
  for (int k = 0; k < 5; ++k) EXPECT_EQ(child.ask("", {0.4, 0}, "a.xyz", ""), "");
}

TEST(ChildProcess, AnswersRequestsThatWereBegunTogetherInTheirOrder) {
  ChildProcess child(misbehave, "a.xyz");
  for (const char* request : {"a", "b", "refuse", "c"}) child.begin(request, kWide);
  EXPECT_EQ(child.finish(kWide, "a.xyz", ""), "a!");
  EXPECT_FALSE(child.is_usable()) << "three answers are to come";
  EXPECT_EQ(child.finish(kWide, "a.xyz", ""), "b!");
  EXPECT_THROW(child.finish(kWide, "a.xyz", ""), FileError);
  EXPECT_THROW(child.finish(kWide, "a.xyz", ""), FileError) << "after a failure nothing is certain";
}

TEST(ChildProcess, CountsTheTimeOfRequestsThatShareItTogether) {
  ChildProcess child(compute_for_a_tenth_of_a_second, "a.xyz");
  child.begin("", {0.25, 0});
  for (int k = 0; k < 5; ++k) child.begin("", {0.0, 0});  // 0.6 s in all
  EXPECT_EQ(child.finish(kWide, "a.xyz", ""), "");
  EXPECT_THROW(
      {
        for (int k = 0; k < 5; ++k) child.finish(kWide, "a.xyz", "");
      },
      FileError);
}

TEST(ChildProcess, IsPreparedBeforeTheFirstRequest) {
  int n_prepared = 0;  // the child's copy
  ChildProcess child([&](std::string_view, int) { return std::to_string(n_prepared); }, "a.xyz", [&] { ++n_prepared; });
  EXPECT_EQ(child.ask("", kWide, "a.xyz", ""), "1");
  EXPECT_EQ(n_prepared, 0);
  ChildProcess other(misbehave, "a.xyz", [] { throw std::runtime_error("not there"); });
  EXPECT_EQ(other.ask("a", kWide, "a.xyz", ""), "a!") << "what is missing is for the request to find";
}

TEST(ChildProcess, SurvivesACrashOfTheReader) {
  for (const char* way : {"crash", "exit"}) {
    ChildProcess child(misbehave, "a.xyz");
    EXPECT_THAT(refusal(child, way, kWide), HasSubstr("a.xyz: ended the process that read it"));
  }
}

TEST(ChildProcess, LimitsTheMemoryOfTheReader) {
  if (kHasAddressSanitizer) GTEST_SKIP() << "the sanitizer's own memory would count";
  ChildProcess child(misbehave, "a.xyz");
  EXPECT_EQ(refusal(child, "allocate", kTight),
            "a.xyz: takes more than 50 MB of memory to read: damaged? make it again");
}

TEST(ChildProcess, SharesMemoryAndFiles) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.txt") << "content";
  const SharedMemory shared(1 << 20);
  ChildProcess child(
      [&](std::string_view, int descriptor) {
        const ssize_t n = pread(descriptor, shared.bytes().data(), 100, 0);
        close(descriptor);
        return std::to_string(n);
      },
      "a.txt");
  const int descriptor = open((folder / "a.txt").c_str(), O_RDONLY);
  EXPECT_EQ(child.ask("", kWide, "a.txt", "", descriptor), "7");
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(shared.bytes().data())), "content");
  close(descriptor);
}

TEST(ChildProcess, NoticesTheEndOfOneChildAmongManyThatWereStartedAtTheSameTime) {
  if (!kMayStartChildBesideThreads) GTEST_SKIP() << "a child that is started beside other threads may wait for ever";
  // a child that held the socket of another would keep it open
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 8; ++thread)
    threads.emplace_back([thread] {
      for (int k = 0; k < 10; ++k) {
        ChildProcess child(misbehave, "a.xyz"), bystander(misbehave, "a.xyz");
        if ((thread + k) % 2 == 0)
          EXPECT_THAT(refusal(child, "crash", kWide), HasSubstr("ended"));
        else
          EXPECT_EQ(child.ask("a", kWide, "a.xyz", ""), "a!");
        EXPECT_EQ(bystander.ask("b", kWide, "a.xyz", ""), "b!");
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
    ChildProcess first(misbehave, "a.xyz"), second(misbehave, "a.xyz");
    const std::string pids = first.ask("pid", kWide, "", "") + " " + second.ask("pid", kWide, "", "");
    if (write(ends[1], pids.data(), pids.size()) < 0) _exit(1);
    pause();
  }
  std::array<char, 100> text{};
  ASSERT_GT(read(ends[0], text.data(), text.size() - 1), 0);
  char* rest = nullptr;
  const auto first = static_cast<pid_t>(std::strtol(text.data(), &rest, 10));
  const auto second = static_cast<pid_t>(std::strtol(rest, nullptr, 10));
  EXPECT_TRUE(is_running(first) && is_running(second));
  kill(owner, SIGKILL);
  waitpid(owner, nullptr, 0);
  for (int k = 0; k < 600 && (is_running(first) || is_running(second)); ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_FALSE(is_running(first) || is_running(second));
  close(ends[0]);
  close(ends[1]);
}

TEST(ChildProcess, IsNotUsedByACopyOfItsOwner) {
  ChildProcess child(misbehave, "a.xyz");
  const pid_t copy = fork();
  if (copy == 0) _exit(child.is_usable() ? 1 : 0);
  int status = -1;
  waitpid(copy, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(child.ask("a", kWide, "a.xyz", ""), "a!");
}

}  // namespace
}  // namespace bouncelab

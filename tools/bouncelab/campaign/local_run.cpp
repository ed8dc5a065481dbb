// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/local_run.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstddef>
#include <span>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/program_output.hpp"
#include "campaign/scripts.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

/// The shards of a campaign are run here by one process at a time; the lock ends with it.
class LocalLock {
 public:
  explicit LocalLock(const Campaign& campaign)
      : descriptor_(::open((campaign.parts_folder() / "local.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {}
  LocalLock(const LocalLock&) = delete;
  LocalLock& operator=(const LocalLock&) = delete;
  ~LocalLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  bool is_taken() const { return descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0; }

 private:
  int descriptor_;
};

fs::path program(const std::string& name) {
  const auto found = find_program(name);
  if (!found) throw FileError(name, "not found; a campaign is run on one machine by xargs and bash");
  return *found;
}

}  // namespace

bool is_local_run_at_work(const Campaign& campaign) { return !LocalLock(campaign).is_taken(); }

void run_shards_here(const Campaign& campaign, const std::vector<std::int64_t>& shards, const Run& run) {
  const LocalLock lock(campaign);
  if (!lock.is_taken())
    throw FileError(campaign.parts().string(), "another bouncelab campaign runs these shards on this machine");
  std::string numbers;
  for (const std::int64_t shard : shards) numbers += std::to_string(shard) + "\n";
  write_whole(campaign.parts_folder() / "shards.txt", numbers, true);
  const ProgressCallback progress = progress_line(run, "campaign", "shards");
  ProgramOutput xargs(program("xargs"), local_arguments(campaign), "xargs", -1, 0.0, true);
  std::byte line{};
  for (std::size_t n_ended = 0; xargs.read(std::span(&line, 1)) == 1;)
    progress(static_cast<double>(++n_ended), static_cast<double>(shards.size()));
  xargs.ended_well();
}

bool run_merge_here(const Campaign& campaign) {
  const fs::path parts = campaign.parts_folder();
  ProgramOutput bash(program("bash"),
                     {"-c", R"(bash "$1" >>"$2" 2>&1)", "merge", (parts / "merge.sh").string(),
                      (parts / "logs" / "merge.log").string()},
                     "bash", -1, 0.0, true);
  std::byte line{};
  while (bash.read(std::span(&line, 1)) == 1) {
  }
  return bash.ended_well();
}

}  // namespace bouncelab::cli

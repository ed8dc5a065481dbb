// SPDX-License-Identifier: GPL-3.0-or-later
/// Slurm's programs, run without a shell. What they say of an error is passed on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace bouncelab::cli::slurm {

/// @return the number of the job. @throws FileError where sbatch is not installed, or refuses
std::string submit(const std::vector<std::string>& sbatch_arguments);

/// A job in the queue, or a task of an array.
struct Queued {
  std::string job;
  std::int64_t shard = 0;  ///< of an array, from 1
  bool is_running = false;
  std::string reason;  ///< why it waits
};
/// This user's jobs. @throws FileError
std::vector<Queued> queue();

/// Jobs that are no longer in the queue are passed over. @throws FileError
void cancel(const std::vector<std::string>& jobs);

/// The largest number of a task in an array (MaxArraySize less one). @throws FileError
std::int64_t most_shards();

}  // namespace bouncelab::cli::slurm

// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/slurm.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/program_output.hpp"

namespace bouncelab::cli::slurm {
namespace {

constexpr std::size_t kMostOutput_bytes = 1 << 26;  // a line for each of a million tasks

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::filesystem::path installed(const std::string& name) {
  if (const auto program = find_program(name)) return *program;
  throw FileError(name, "not found: is this the cluster's login node? --on local runs a campaign on this machine");
}

std::string answer_of(const std::string& name, const std::vector<std::string>& arguments) {
  const ProgramResult result = run_program(installed(name), arguments, name, -1, 0.0, kMostOutput_bytes);
  if (!result.ended_well)
    throw FileError(name, result.complaints.empty() ? "failed without a message" : first_line(result.complaints));
  return result.output;
}

std::int64_t number(const std::string& text) {
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

}  // namespace

std::string submit(const std::vector<std::string>& sbatch_arguments) {
  const std::string line = first_line(answer_of("sbatch", sbatch_arguments));  // "12" or "12;cluster"
  const std::string job = line.substr(0, line.find(';'));
  if (job.empty() || job.find_first_not_of("0123456789") != std::string::npos)
    throw FileError("sbatch", "'" + line + "' is no number of a job");
  return job;
}

std::vector<Queued> queue() {
  std::istringstream lines(
      answer_of("squeue", {"--noheader", "--array", "--user=" + std::to_string(::getuid()),
                           "--states=pending,configuring,running,suspended,requeued,stopped", "--format=%F|%K|%T|%r"}));
  std::vector<Queued> all;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string job, task, state, reason;
    std::getline(fields, job, '|');
    std::getline(fields, task, '|');
    std::getline(fields, state, '|');
    std::getline(fields, reason);
    all.push_back({job, number(task), state != "PENDING" && state != "REQUEUED", reason});
  }
  return all;
}

void cancel(const std::vector<std::string>& jobs) {
  if (!jobs.empty()) answer_of("scancel", jobs);
}

std::int64_t most_shards() {
  installed("sbatch");
  const std::string text = answer_of("scontrol", {"show", "config"});
  const auto at = text.find("MaxArraySize");
  const auto digits = at == std::string::npos ? at : text.find_first_of("0123456789", at);
  const std::int64_t size = digits == std::string::npos ? 0 : number(text.substr(digits, 20));
  if (size < 2) throw FileError("scontrol", "this cluster takes no job arrays (MaxArraySize); --on local runs here");
  return size - 1;
}

}  // namespace bouncelab::cli::slurm

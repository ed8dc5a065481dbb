// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/cost.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/program_output.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

/// A folder for the files of the measurement, deleted with this.
class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "bouncelab-campaign-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw FileError(name, "cannot be created; TMPDIR chooses another folder");
    path_ = name;
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Processor time of all children that have ended.
double children_cpu_s() {
  rusage used{};
  ::getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

double bytes_of(const Campaign& campaign, std::size_t k) {
  std::error_code unreadable;
  const auto size = fs::file_size(campaign.folder / campaign.recordings[k], unreadable);
  return unreadable ? 0.0 : static_cast<double>(size);
}

/// What people are told of a program's failure: its last line, without the program's name.
std::string reason(const std::string& complaints) {
  std::string text = complaints.substr(0, complaints.find_last_not_of('\n') + 1);
  text = text.substr(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
  const std::string own = "bouncelab: ";
  return text.rfind(own, 0) == 0 ? text.substr(own.size()) : text;
}

}  // namespace

MeasuredCost measure_cost(const Campaign& campaign, const fs::path& program, std::int64_t n_items) {
  constexpr double kLeast_cpu_s = 1.0;
  constexpr std::int64_t kMost_items = 20;
  const WorkFolder work;
  const fs::path config = work.path() / "run.toml", list = work.path() / "recordings.txt";
  write_whole(config,
              config_text(campaign, (work.path() / "out").string(), campaign.takes_recordings() ? list.string() : ""),
              false);
  double whole_bytes = 0.0, measured_bytes = 0.0;
  std::string names;
  for (std::size_t k = 0; k < campaign.recordings.size(); ++k) {
    names += (campaign.folder / campaign.recordings[k]).string() + "\n";
    whole_bytes += bytes_of(campaign, k);
  }
  if (campaign.takes_recordings()) write_whole(list, names, false);

  MeasuredCost cost;
  const double before_s = children_cpu_s();
  const std::int64_t n_most = std::min(kMost_items, n_items);
  for (std::int64_t k = 0; k < n_most && cost.cpu_s < kLeast_cpu_s; ++k) {
    // as many shards as items: a shard is one item
    const std::int64_t item = k * n_items / n_most;
    const ProgramResult result =
        run_program("/bin/sh",
                    {"-c", R"(cd "$1" && shift && exec "$@")", "sh", campaign.folder.string(), program.string(),
                     campaign.command, "--config", config.string(), "--shard", fmt::format("{}/{}", item + 1, n_items)},
                    program.string(), -1, 0.0, 1 << 22);
    if (!result.ended_well)
      throw FileError(campaign.file.string(),
                      fmt::format("{} {} of {} was run to measure what it costs, and failed: {}",
                                  campaign.takes_recordings() ? "recording" : "point", item + 1, n_items,
                                  reason(result.complaints)));
    cost.cpu_s = children_cpu_s() - before_s;
    ++cost.n_items;
    if (campaign.takes_recordings()) measured_bytes += bytes_of(campaign, static_cast<std::size_t>(item));
  }
  cost.share = campaign.takes_recordings() ? (whole_bytes > 0.0 ? measured_bytes / whole_bytes : 0.0)
                                           : static_cast<double>(cost.n_items) / static_cast<double>(n_items);
  cost.text =
      campaign.takes_recordings()
          ? fmt::format(
                "{} of {} recordings, {:.3g} of {:.3g} MB, took {:.2f} s of a processor; all of them will take about "
                "{:.2g} h",
                cost.n_items, n_items, 1e-6 * measured_bytes, 1e-6 * whole_bytes, cost.cpu_s, cost.whole_cpu_s() / 3600)
          : fmt::format("{} of {} points took {:.2f} s of a processor; all of them will take about {:.2g} h",
                        cost.n_items, n_items, cost.cpu_s, cost.whole_cpu_s() / 3600);
  return cost;
}

std::int64_t shards_for(const JobSettings& jobs, double whole_cpu_s, std::int64_t n_items, std::int64_t most) {
  const double n = std::ceil(whole_cpu_s / (jobs.seconds_per_shard * static_cast<double>(jobs.n_cpus)));
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::min(n, 1e9)), 1, std::min(n_items, most));
}

}  // namespace bouncelab::cli

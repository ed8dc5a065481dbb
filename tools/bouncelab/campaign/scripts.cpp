// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/scripts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <thread>

#include "campaign/path_patterns.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

/// A name for squeue, that people know the campaign by.
std::string job_name(const Campaign& campaign) {
  std::string name = fs::path(campaign.out).stem().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_' && c != '.') c = '_';
  return name;
}

std::string directive(const std::string& option, const std::string& value) {
  return value.empty() ? "" : fmt::format("#SBATCH --{}={}\n", option, value);
}

std::string head(const Campaign& campaign, const std::string& name, std::int64_t n_cpus, const std::string& time,
                 const std::string& memory) {
  const JobSettings& jobs = campaign.jobs;
  std::string text = "#!/bin/bash\n" + directive("job-name", name) + "#SBATCH --requeue\n#SBATCH --open-mode=append\n" +
                     directive("cpus-per-task", std::to_string(n_cpus)) + directive("partition", jobs.partition) +
                     directive("account", jobs.account) + directive("time", time) + directive("mem", memory);
  for (const std::string& option : jobs.sbatch) text += "#SBATCH " + option + "\n";
  return text + "set -e\ncd " + shell_word(campaign.folder.string()) + "\n";
}

/// In sbatch's names of files `%a` and the like are replaced.
std::string sbatch_path(const std::string& path) {
  std::string text;
  for (const char c : path) text += c == '%' ? "%%" : std::string(1, c);
  return text;
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string value_of(const std::vector<PatternValue>& patterns, const std::string& recording) {
  const auto first = std::find_if(patterns.begin(), patterns.end(),
                                  [&](const PatternValue& p) { return names(p.pattern, recording); });
  return first == patterns.end() ? "" : first->value;
}

}  // namespace

std::string shell_word(const std::string& text) {
  const bool is_safe = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string("/._-+=:,@%").find(c) != std::string::npos;
  });
  if (is_safe) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

std::string shell_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + shell_word(word);
  return line;
}

std::string shard_script(const Campaign& campaign, const fs::path& program, std::int64_t n_shards) {
  const JobSettings& jobs = campaign.jobs;
  return head(campaign, job_name(campaign), jobs.n_cpus, jobs.time, jobs.memory) +
         fmt::format("exec {} {} --config {} --shard \"$SLURM_ARRAY_TASK_ID/{}\"\n", shell_word(program.string()),
                     campaign.command, shell_word((campaign.parts() / "run.toml").string()), n_shards);
}

std::string merge_script(const Campaign& campaign, const fs::path& program) {
  const JobSettings& jobs = campaign.jobs;
  const std::string bouncelab = shell_word(program.string());
  const std::string parts = shell_word(campaign.parts().string()), out = shell_word(campaign.command_out());
  const fs::path folder = campaign.out;
  std::string text =
      head(campaign, job_name(campaign) + "-merge", 1, jobs.merge_time.empty() ? jobs.time : jobs.merge_time,
           jobs.merge_memory.empty() ? jobs.memory : jobs.merge_memory);
  // an unreadable recording gives exit code 3 and the results of the others
  const std::string result = campaign.command == "detect"    ? out
                             : campaign.command == "analyze" ? shell_word((folder / "onsets.csv").string())
                                                             : "";
  if (!result.empty()) text += fmt::format("rm -f {}\n", result);
  text += fmt::format("{} merge {} --force{}\n", bouncelab, parts, result.empty() ? "" : " || test -e " + result);
  if (campaign.command == "detect")
    text +=
        fmt::format("{} restitution {} --config {} --out {} --force\n", bouncelab, out,
                    shell_word((campaign.parts() / "run.toml").string()), shell_word((folder / "samples.h5").string()));
  if (campaign.takes_recordings()) {
    const fs::path samples = folder / (campaign.command == "detect" ? "samples.h5" : "samples.csv");
    // exit code 1: too few for a comparison, which the page says
    text += fmt::format("{} compare {} --groups {} --title {} --out {} --force || test $? -eq 1\n", bouncelab,
                        shell_word(samples.string()), shell_word((campaign.parts() / "groups.csv").string()),
                        shell_word(campaign.out), shell_word((folder / "compare").string()));
  }
  return text + fmt::format("touch {}\n", shell_word((campaign.parts() / "merged").string()));
}

std::string groups_text(const Campaign& campaign) {
  std::string text = "recording,plate,date\n";
  for (const std::string& recording : campaign.recordings)
    text += fmt::format("{},{},{}\n", csv_cell(recording), csv_cell(value_of(campaign.plates, recording)),
                        csv_cell(value_of(campaign.dates, recording)));
  return text;
}

std::string ranges(const std::vector<std::int64_t>& shards) {
  std::string text;
  for (std::size_t k = 0; k < shards.size();) {
    std::size_t last = k;
    while (last + 1 < shards.size() && shards[last + 1] == shards[last] + 1) ++last;
    text += (text.empty() ? "" : ",") + std::to_string(shards[k]);
    if (last > k) text += "-" + std::to_string(shards[last]);
    k = last + 1;
  }
  return text;
}

std::vector<std::string> array_arguments(const Campaign& campaign, const std::vector<std::int64_t>& shards) {
  const fs::path parts = campaign.parts_folder();
  std::string array = "--array=" + ranges(shards);
  if (campaign.jobs.n_at_once > 0) array += "%" + std::to_string(campaign.jobs.n_at_once);
  return {"--parsable", array, "--output=" + sbatch_path((parts / "logs").string()) + "/shard-%a.log",
          (parts / "shard.sh").string()};
}

std::vector<std::string> merge_arguments(const Campaign& campaign, const std::string& dependency) {
  const fs::path parts = campaign.parts_folder();
  std::vector<std::string> arguments{"--parsable"};
  if (!dependency.empty()) {
    arguments.push_back("--dependency=" + dependency);
    arguments.emplace_back("--kill-on-invalid-dep=yes");
  }
  arguments.push_back("--output=" + sbatch_path((parts / "logs" / "merge.log").string()));
  arguments.push_back((parts / "merge.sh").string());
  return arguments;
}

std::vector<std::string> local_arguments(const Campaign& campaign) {
  const fs::path parts = campaign.parts_folder();
  const std::int64_t n_cores = std::max<std::int64_t>(1, std::thread::hardware_concurrency() / campaign.jobs.n_cpus);
  return {"--arg-file=" + (parts / "shards.txt").string(),
          "--max-procs=" + std::to_string(campaign.jobs.n_at_once > 0 ? campaign.jobs.n_at_once : n_cores),
          "--max-args=1",
          "bash",
          "-c",
          R"(SLURM_ARRAY_TASK_ID=$3 bash "$1" >>"$2/shard-$3.log" 2>&1; echo)",
          "shard",
          (parts / "shard.sh").string(),
          (parts / "logs").string()};
}

fs::path log_of(const Campaign& campaign, std::int64_t shard) {
  return campaign.parts() / "logs" / fmt::format("shard-{}.log", shard);
}
fs::path merge_log(const Campaign& campaign) { return campaign.parts() / "logs" / "merge.log"; }

}  // namespace bouncelab::cli

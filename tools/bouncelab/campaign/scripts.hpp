// SPDX-License-Identifier: GPL-3.0-or-later
/// The two scripts of a campaign, as a person would write them, and the command lines that submit them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "campaign/campaign_file.hpp"

namespace bouncelab::cli {

/// The text as one word of a POSIX shell: as it is where that is safe, else between single quotes.
std::string shell_word(const std::string& text);
/// Words of a command line for people to read, and to paste into a shell.
std::string shell_line(const std::vector<std::string>& words);

/// Does shard $SLURM_ARRAY_TASK_ID of n_shards. @param program  bouncelab, absolute
std::string shard_script(const Campaign& campaign, const std::filesystem::path& program, std::int64_t n_shards);

/// Merges the parts; of recordings also the coefficients of restitution and their comparison.
std::string merge_script(const Campaign& campaign, const std::filesystem::path& program);

/// Recordings with their plate and date, CSV; the first pattern of each kind that names a recording counts.
std::string groups_text(const Campaign& campaign);

/// "1-3,7" for {1, 2, 3, 7}. @param shards  ascending
std::string ranges(const std::vector<std::int64_t>& shards);

/// sbatch's arguments: the job array of these shards.
std::vector<std::string> array_arguments(const Campaign& campaign, const std::vector<std::int64_t>& shards);
/// sbatch's arguments: the merge.
/// @param dependency  "afterok:12"; empty: none
std::vector<std::string> merge_arguments(const Campaign& campaign, const std::string& dependency);
/// xargs' arguments: the same scripts on this machine. Numbers of shards are read from the file OUT.parts/shards.txt;
/// an empty line comes out for each that has ended.
std::vector<std::string> local_arguments(const Campaign& campaign);

/// Paths relative to the campaign's folder.
std::filesystem::path log_of(const Campaign& campaign, std::int64_t shard);
std::filesystem::path merge_log(const Campaign& campaign);

}  // namespace bouncelab::cli

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "command.hpp"

namespace bouncelab::cli {

struct CampaignOptions {
  std::string action = "start";  ///< start, status, resume, cancel
  std::string file;              ///< .toml
  std::string on;                ///< slurm, local; empty: where it was started
  bool dry_run = false;
};

Outcome run_campaign(const CampaignOptions& options, const Run& run);

}  // namespace bouncelab::cli

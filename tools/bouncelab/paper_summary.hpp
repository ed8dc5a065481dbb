// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "streamed_loop.hpp"

namespace bouncelab::cli {

/// paper.json: what the paper concludes, as checks with numbers; slopes from the simulation and from the sound; the
/// scatter against speed; energy shares against bounce number.
Json paper_json(const StreamedLoop& loop);

/// The checks and slopes as a table for people.
std::string paper_text(const Json& paper);

/// Adds where the time went: seconds and processor seconds by stage, per hour of sound and per impact; peak memory.
void add_work(const StreamedLoop& loop, const std::vector<std::pair<std::string, double>>& later_wall_s,
              double memory_bytes, Json& summary);
std::string work_text(const Json& summary);

}  // namespace bouncelab::cli

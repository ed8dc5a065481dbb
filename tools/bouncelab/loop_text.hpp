// SPDX-License-Identifier: GPL-3.0-or-later
/// Results of closed loops as tables for people.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/loop/loop.hpp"
#include "json/loop_json.hpp"

namespace bouncelab::cli {

std::string loop_text(const loop::LoopScore& score, const std::optional<loop::ReservoirCheck>& reservoir,
                      const SecondsByStage& seconds);
/// Slopes and conclusions.
std::string paper_text(const std::vector<loop::SlopeWindow>& slopes,
                       const std::vector<report::Conclusion>& conclusions);
/// Processor time by stage, per hour of sound and per impact; memory.
std::string work_text(const LoopWork& work, std::size_t n_impacts);
std::string sweep_text(const std::vector<loop::SweepPoint>& points);

}  // namespace bouncelab::cli

// SPDX-License-Identifier: GPL-3.0-or-later
/// Results of closed loops, as objects and as tables for people.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/loop/loop.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::stages {

using SecondsByStage = loop::StageClock::SecondsByStage;

/// What a loop cost, beside its clock.
struct LoopWork {
  double sound_s = 0.0;
  double peak_memory_bytes = 0.0;
};

/// summary.json of `loop`.
/// @param work  absent: without times and memory, which differ from run to run
Object loop_summary(const loop::LoopScore& score, const loop::LoopResult& loop, const std::vector<Note>& notes,
                    const std::optional<LoopWork>& work = {});
/// paper.json: the conclusions as checks with numbers; slopes from the simulation and from the sound; the scatter
/// against speed; energy shares against bounce number.
Object paper_results(const loop::LoopResult& loop, const std::vector<loop::SlopeWindow>& slopes,
                     const std::vector<report::Conclusion>& conclusions);

std::string loop_text(const loop::LoopScore& score, const loop::LoopResult& loop);
/// Slopes and conclusions.
std::string paper_text(const std::vector<loop::SlopeWindow>& slopes,
                       const std::vector<report::Conclusion>& conclusions);
/// Processor time by stage, per hour of sound and per impact; memory.
std::string work_text(const LoopWork& work, const SecondsByStage& processor_s, std::size_t n_impacts);
std::string sweep_text(const std::vector<loop::SweepPoint>& points);

}  // namespace bouncelab::stages

// SPDX-License-Identifier: GPL-3.0-or-later
/// Results of closed loops, as objects and as tables for people.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/loop/loop.hpp"
#include "bouncelab/report/conclusions.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::stages {

using SecondsByStage = std::vector<std::pair<std::string, double>>;

/// What a loop through memory cost.
struct LoopWork {
  double sound_s = 0.0;
  SecondsByStage wall_s, processor_s;
  double peak_memory_bytes = 0.0;
};

/// summary.json of `loop`.
/// @param seconds    by stage, of a loop through files
/// @param work       of a loop through memory, in place of `seconds`
/// @param theory     of its scatter, where it applies
/// @param reservoir  from its sound, where there are three drops or more
/// @param ball       cut open, for a picture
Object loop_summary(const loop::LoopScore& score, const SecondsByStage& seconds, const std::vector<Note>& notes,
                    const std::optional<loop::ScatterTheory>& theory,
                    const std::optional<loop::ReservoirCheck>& reservoir, const sim::BallSection& ball,
                    const std::optional<LoopWork>& work = {});
/// paper.json: the conclusions as checks with numbers; slopes from the simulation and from the sound; the scatter
/// against speed; energy shares against bounce number.
Object paper_results(const loop::LoopResult& loop, const std::vector<loop::SlopeWindow>& slopes,
                     const std::vector<report::Conclusion>& conclusions);

std::string loop_text(const loop::LoopScore& score, const std::optional<loop::ReservoirCheck>& reservoir,
                      const SecondsByStage& seconds);
/// Slopes and conclusions.
std::string paper_text(const std::vector<loop::SlopeWindow>& slopes,
                       const std::vector<report::Conclusion>& conclusions);
/// Processor time by stage, per hour of sound and per impact; memory.
std::string work_text(const LoopWork& work, std::size_t n_impacts);
std::string sweep_text(const std::vector<loop::SweepPoint>& points);

}  // namespace bouncelab::stages

// SPDX-License-Identifier: GPL-3.0-or-later
/// Results of closed loops as JSON text.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/loop/loop.hpp"
#include "bouncelab/report/conclusions.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::cli {

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
std::string loop_summary_json(const loop::LoopScore& score, const SecondsByStage& seconds,
                              const std::vector<std::string>& warnings,
                              const std::optional<loop::ScatterTheory>& theory,
                              const std::optional<loop::ReservoirCheck>& reservoir, const sim::BallSection& ball,
                              const std::optional<LoopWork>& work = {});
/// paper.json: the conclusions as checks with numbers; slopes from the simulation and from the sound; the scatter
/// against speed; energy shares against bounce number.
std::string paper_json(const loop::LoopResult& loop, const std::vector<loop::SlopeWindow>& slopes,
                       const std::vector<report::Conclusion>& conclusions);
/// sweep.json
/// @param indent  spaces for each level
std::string sweep_json(const std::vector<loop::SweepAxis>& axes, const std::vector<loop::SweepPoint>& points,
                       int indent);

}  // namespace bouncelab::cli

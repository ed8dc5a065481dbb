// SPDX-License-Identifier: GPL-3.0-or-later
#include "streamed_loop.hpp"

#include <algorithm>
#include <ctime>
#include <functional>

#include "bouncelab/core/parallel.hpp"
#include "progress_line.hpp"
#include "stages.hpp"

namespace bouncelab::cli {
namespace {

double processor_time_s() {
  std::timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Wall and processor time of each stage, in order.
class StageAccount {
 public:
  explicit StageAccount(StreamedLoop& loop) : loop_(loop) {}
  template <class Stage>
  void run(const std::string& name, const Stage& stage) {
    const double start_s = processor_time_s();
    StageClock clock;
    clock.time(name, [&] {
      stage();
      return true;
    });
    loop_.wall_s.push_back(clock.seconds().front());
    loop_.processor_s.emplace_back(name, processor_time_s() - start_s);
  }

 private:
  StreamedLoop& loop_;
};

/// The scatter that the simulation itself has, without any measuring.
RestitutionSamples direct_samples(const Impacts& impacts) {
  RestitutionSamples samples;
  samples.reserve(impacts.rows.size());
  for (const Impact& impact : impacts.rows) {
    RestitutionSample sample;
    sample.drop = impact.drop;
    sample.impact = impact.impact;
    sample.t_s = impact.t_s;
    sample.v_mps = impact.v_mps;
    sample.eps = impact.eps_macro;
    samples.push_back(std::move(sample));
  }
  return samples;
}

HeardBall simulated(const std::string& name, const sim::SimulationConfig& config, const sim::Surface& surface,
                    StreamedLoop& loop, const Run& run) {
  sim::SimulationResult result = sim::simulate(config, surface, progress_line(run, "simulate", "drops"));
  if (config.with_state) {
    loop.shares = sim::energy_shares(config.ball, result.impacts);
    loop.energy = result.energy;
  }
  HeardBall ball;
  ball.name = name;
  ball.impacts = std::move(result.impacts);
  ball.impacts.states = {};
  return ball;
}

void simulate_balls(const LoopOptions& options, bool with_smooth, StreamedLoop& loop, const Run& run) {
  sim::SimulationConfig config = loop.simulation;
  config.with_state = true;
  loop.rough = simulated("rough", config,
                         surface_of(options.simulate, config, progress_line(run, "surface", "asperities")), loop, run);
  if (!with_smooth) return;
  config.with_state = false;
  config.n_drops = std::max<std::int64_t>(1, config.n_drops / kRoughDropsPerSmoothDrop);
  loop.smooth = simulated("smooth", config, sim::Surface{}, loop, run);
}

void hear(HeardBall& ball, const SoundStage& stage, std::vector<HeardDrop> finished, RunJournal* journal,
          const Run& run) {
  ball.drops = hear_drops(ball.impacts, ball.name, stage, std::move(finished), journal, run);
  ball.score = detection::score_onsets(true_onsets_of(ball.drops, ball.name), onsets_of(ball.drops));
}

/// "hear" is two stages in one pass over the drops: their shares are known by the drops' own clocks.
void split_hearing(StreamedLoop& loop) {
  double synthesize_s = 0.0, detect_s = 0.0;
  for (const HeardBall* ball : {&loop.rough, &loop.smooth})
    for (const HeardDrop& drop : ball->drops) {
      synthesize_s += drop.synthesize_s;
      detect_s += drop.detect_s;
    }
  auto& stages = loop.processor_s;
  const auto hearing = std::find_if(stages.begin(), stages.end(), [](const auto& s) { return s.first == "hear"; });
  *hearing = {"synthesize", synthesize_s};
  stages.insert(hearing + 1, {"detect", detect_s});
}

void fit_everything(StreamedLoop& loop, const LoopOptions& options, const Run& run) {
  const auto from = [&](const Onsets& onsets) {
    fit::RestitutionConfig config;
    config.gravity_mps2 = loop.simulation.gravity_mps2;
    config.ball = loop.simulation.ball;
    return fit::restitution_samples(onsets, config).samples;
  };
  fit::FitConfig config;
  config.law.node_speeds_mps = options.node_speeds_mps;
  config.budget = budget_of(loop.simulation);
  loop.samples_direct = direct_samples(loop.rough.impacts);
  loop.samples_true = from(true_onsets_of(loop.rough.drops, loop.rough.name));
  loop.samples_sound = from(onsets_of(loop.rough.drops));
  const auto fit = [&](const RestitutionSamples& samples, fit::FitResult& result) {
    result = fit::fit_all(samples, config);
  };
  progress_line(run, "fit", "fits")(0.0, 4.0);
  std::vector<std::function<void()>> fits{[&] { fit(loop.samples_sound, loop.sound); },
                                          [&] { fit(loop.samples_true, loop.true_times); },
                                          [&] { fit(loop.samples_direct, loop.direct); }};
  if (!loop.smooth.drops.empty())
    fits.emplace_back([&] { fit(from(onsets_of(loop.smooth.drops)), loop.smooth_sound); });
  parallel_for(fits.size(), run.common.n_threads, [&](std::size_t k) { fits[k](); });
}

}  // namespace

void FinishedDrops::add(const Json& part) {
  (part.at("ball") == "smooth" ? smooth : rough).push_back(heard_drop_from_json(part));
}

StreamedLoop run_streamed(const LoopOptions& options, bool with_smooth, FinishedDrops finished, RunJournal* journal,
                          Run& run) {
  StreamedLoop loop;
  loop.simulation = simulation_config(options.simulate, run.common);
  const synthesis::SynthesisConfig synthesis = synthesis_config(options.synthesize, run.common);
  StageAccount account(loop);
  account.run("simulate", [&] { simulate_balls(options, with_smooth, loop, run); });
  account.run("hear", [&] {
    SoundStage stage = make_sound_stage(synthesis, loop.rough.impacts);
    stage.folder = std::filesystem::path(options.out) / "sound";
    stage.keep_sound = options.keep_sound;
    hear(loop.rough, stage, std::move(finished.rough), journal, run);
    if (with_smooth) hear(loop.smooth, stage, std::move(finished.smooth), journal, run);
  });
  split_hearing(loop);
  account.run("restitution_and_fit", [&] { fit_everything(loop, options, run); });
  return loop;
}

}  // namespace bouncelab::cli

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/closed_loop.hpp"

#include <algorithm>

namespace bouncelab::loop {
namespace {

std::int64_t n_smooth_drops(std::int64_t n_rough) {
  return std::max<std::int64_t>(1, n_rough / kRoughDropsPerSmoothDrop);
}

ProgressCallback callback(const StageProgress& progress, const std::string& label, const std::string& unit) {
  return progress ? progress(label, unit) : ProgressCallback{};
}

/// The scatter of the simulation itself, without any measurement.
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

sim::Surface surface_of(const LoopConfig& config, const StageProgress& progress) {
  if (config.surface) return *config.surface;
  return sim::make_surface(config.simulation.ball, config.n_asperities, config.radius_law, config.simulation.seed,
                           callback(progress, "surface", "asperities"));
}

BallResult simulated(const std::string& name, const sim::SimulationConfig& config, const sim::Surface& surface,
                     LoopResult& loop, const StageProgress& progress) {
  sim::SimulationResult result = sim::simulate(config, surface, callback(progress, "simulate", "drops"));
  if (config.with_state) {
    loop.shares = sim::energy_shares(config.ball, result.impacts);
    loop.energy = result.energy;
    loop.reservoirs = sim::reservoirs_after(config.ball, result.impacts);
  }
  BallResult ball;
  ball.name = name;
  ball.impacts = std::move(result.impacts);
  return ball;
}

void simulate_balls(const LoopConfig& config, LoopResult& loop, const StageProgress& progress) {
  sim::SimulationConfig simulation = loop.simulation;
  simulation.with_state = true;
  {
    const sim::Surface surface = surface_of(config, progress);
    loop.section = sim::section_of(simulation.ball, surface);
    loop.rough = simulated("rough", simulation, surface, loop, progress);
    if (!config.simulation.with_state) loop.rough.impacts.states = {};
  }
  if (!config.with_smooth_ball) return;
  simulation.with_state = false;
  simulation.n_drops = n_smooth_drops(simulation.n_drops);
  loop.smooth = simulated("smooth", simulation, sim::Surface{}, loop, progress);
}

void score(BallResult& ball) {
  std::vector<DetectorScore> scores;
  for (const RecordingResult& r : ball.recordings)
    scores.push_back(score_detector(true_times_from_table(synthesis::truth_table(r.truth, r.recording), r.recording),
                                    r.onsets, r.sound_s, 0.0));
  ball.score = pooled(scores);
}

void record_and_detect(BallResult& ball, const DropRecording& recording, int n_threads, const StageProgress& progress) {
  ball.recordings = run_drops(ball.impacts, ball.name, recording, n_threads,
                              callback(progress, "synthesize and detect the " + ball.name + " ball", "drops"));
  score(ball);
}

void sound_by_drop(LoopResult& loop, const LoopConfig& config, const StageProgress& progress) {
  DropRecording recording = drop_recording(config.synthesis, loop.rough.impacts);
  recording.folder = config.sound_folder;
  record_and_detect(loop.rough, recording, config.n_threads, progress);
  if (config.with_smooth_ball) record_and_detect(loop.smooth, recording, config.n_threads, progress);
}

void sound_together(LoopResult& loop, const LoopConfig& config, const StageProgress& progress) {
  loop.rough.recordings.push_back(synthesize_together(loop.rough.impacts, config.synthesis, *config.recording,
                                                      callback(progress, "synthesize", "s of sound")));
  detect_together(loop.rough.recordings.back(), config.n_threads, callback(progress, "detect", "s of sound"));
  score(loop.rough);
}

/// How samples are made of the onsets of this experiment: its gravity, its ball.
fit::RestitutionConfig restitution_config_of(const sim::SimulationConfig& simulation) {
  fit::RestitutionConfig config;
  config.gravity_mps2 = simulation.gravity_mps2;
  config.ball = simulation.ball;
  config.air_kgpm3 = simulation.air ? simulation.air->density_kgpm3 : 0.0;
  config.instant_contacts = true;
  return config;
}

/// Which disturbances the samples of this experiment contain: a simulated ball is struck without delay and, in the
/// sound, each drop at one point.
fit::BudgetConfig budget_config_of(const sim::SimulationConfig& simulation) {
  fit::BudgetConfig budget;
  budget.ball = simulation.ball;
  budget.gravity_mps2 = simulation.gravity_mps2;
  if (simulation.air) budget.air = *simulation.air;
  budget.has_drag = simulation.air.has_value();
  budget.has_contact_time = budget.has_travel_time = false;
  return budget;
}

void fit_everything(LoopResult& loop, const LoopConfig& config, const StageProgress& progress) {
  const auto samples_of = [&](const Onsets& onsets) {
    return fit::restitution_samples(onsets, restitution_config_of(loop.simulation)).samples;
  };
  fit::FitConfig fit_config;
  fit_config.law.node_speeds_mps = config.node_speeds_mps;
  fit_config.law.seed = loop.simulation.seed;
  fit_config.budget = budget_config_of(loop.simulation);
  fit_config.compare_recordings = false;  // each drop is one, all of the same ball
  const auto fit = [&](const RestitutionSamples& samples, fit::FitResult& result, bool memory = false) {
    fit::FitConfig this_config = fit_config;
    if (memory) this_config.memory = fit::UseMemory::where_long;
    result = fit::fit_all(samples, this_config);
  };
  std::vector<std::function<void()>> fits{[&] {
                                            loop.samples_sound = samples_of(onsets_of(loop.rough.recordings));
                                            fit(loop.samples_sound, loop.sound, config.with_memory);
                                          },
                                          [&] {
                                            loop.samples_true = samples_of(true_onsets_of(loop.rough.recordings));
                                            fit(loop.samples_true, loop.true_times, config.with_memory);
                                          }};
  if (config.with_direct)
    fits.emplace_back([&] {
      loop.samples_direct = direct_samples(loop.rough.impacts);
      fit(loop.samples_direct, loop.direct);
    });
  if (!loop.smooth.recordings.empty())
    fits.emplace_back([&] {
      loop.samples_smooth = samples_of(onsets_of(loop.smooth.recordings));
      fit(loop.samples_smooth, loop.smooth_sound);
    });
  if (const ProgressCallback report = callback(progress, "fit", "fits")) report(0.0, static_cast<double>(fits.size()));
  parallel_for(fits.size(), config.n_threads, [&](std::size_t k) { fits[k](); });
}

}  // namespace

LoopResult run_loop(const LoopConfig& config, const StageProgress& progress) {
  LoopResult loop;
  loop.simulation = config.simulation;
  loop.simulation.n_threads = config.n_threads;
  simulate_balls(config, loop, progress);
  config.recording ? sound_together(loop, config, progress) : sound_by_drop(loop, config, progress);
  fit_everything(loop, config, progress);
  const sim::ContactOffset offset =
      contact_offset_of(config.simulation.ball, config.surface ? &*config.surface : nullptr, config.radius_law,
                        config.n_asperities, config.n_threads);
  const auto reservoir = [&] {
    loop.reservoir = reservoir_check(loop.rough.impacts, loop.reservoirs, true_onsets_of(loop.rough.recordings),
                                     onsets_of(loop.rough.recordings), loop.rough.score.match, loop.samples_sound,
                                     loop.sound, loop.simulation.gravity_mps2);
  };
  const auto theory = [&] {
    loop.theory = scatter_theory(loop.simulation, offset, loop.rough.impacts, loop.sound.histograms);
  };
  parallel_for(2, config.n_threads, [&](std::size_t k) { k == 0 ? reservoir() : theory(); });
  return loop;
}

double sound_s(const LoopResult& loop) {
  double sum = 0.0;
  for (const BallResult* ball : {&loop.rough, &loop.smooth})
    for (const RecordingResult& r : ball->recordings) sum += r.sound_s;
  return sum;
}

}  // namespace bouncelab::loop

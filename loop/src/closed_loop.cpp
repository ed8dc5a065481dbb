// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/closed_loop.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/synthesis/synthesize.hpp"

namespace bouncelab::loop {
namespace {

namespace fs = std::filesystem;

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
                           progress("surface", "asperities"));
}

BallResult simulated(const std::string& name, const sim::SimulationConfig& config, const sim::Surface& surface,
                     LoopResult& loop, const StageProgress& progress) {
  sim::SimulationResult result = sim::simulate(config, surface, progress("simulate", "drops"));
  if (config.with_state) {
    loop.shares = sim::energy_shares(config.ball, result.impacts);
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
  simulation.n_drops = std::max<std::int64_t>(1, simulation.n_drops / kRoughDropsPerSmoothDrop);
  loop.smooth = simulated("smooth", simulation, sim::Surface{}, loop, progress);
}

void score(BallResult& ball) {
  std::vector<DetectorScore> scores;
  for (const RecordingResult& r : ball.recordings)
    scores.push_back(score_detector(true_times_from_table(synthesis::truth_table(r.truth, r.recording), r.recording),
                                    r.onsets, r.sound_s, 0.0));
  ball.score = pooled(scores);
}

/// How drops become sound: one recording each, all with the same gain and noise level.
struct DropSound {
  synthesis::SynthesisConfig config;  ///< one channel; positions drawn, one for each drop
  synthesis::Levels levels;
  std::shared_ptr<const synthesis::Instrument> instrument;
};

std::vector<Impacts> by_drop(const Impacts& impacts) {
  std::vector<Impacts> all;
  const synthesis::DropSource drops = synthesis::drops_of(impacts);
  for (Impacts drop; drops(std::ssize(all), drop);) all.push_back(drop);
  return all;
}

/// Gain and noise are chosen for the first drops: the weakest impact of so many has the SNR of the configuration.
/// @throws InvalidArgument where there is more than one channel
DropSound sound_of_drops(const synthesis::SynthesisConfig& config, const std::vector<Impacts>& drops) {
  constexpr std::size_t kDropsForLevels = 40;
  if (config.channels.size() != 1)
    throw InvalidArgument("a loop through memory has one sensor, not " + std::to_string(config.channels.size()));
  DropSound sound;
  sound.config = config;
  sound.config.simulated_positions = false;
  sound.config.n_threads = 1;  // the drops run in parallel
  sound.instrument = synthesis::make_instrument(sound.config);
  Impacts first;
  for (std::size_t k = 0; k < std::min(kDropsForLevels, drops.size()); ++k)
    first.rows.insert(first.rows.end(), drops[k].rows.begin(), drops[k].rows.end());
  sound.levels = synthesis::SyntheticRecording(first, sound.config, sound.instrument).levels();
  return sound;
}

void keep(const std::vector<float>& samples, const synthesis::SynthesisConfig& config, const fs::path& path) {
  audio::AudioWriter writer(path, {config.rate_hz, 1, config.encoding}, std::ssize(samples), true);
  writer.write(samples);
  writer.commit();
}

/// A pure function of its arguments but for the recording that is kept.
/// @param ball    names the recording, BALL.0017.flac
/// @param folder  as LoopConfig::sound_folder
RecordingResult run_drop(const Impacts& drop, const std::string& ball, const DropSound& by,
                         const std::optional<fs::path>& folder) {
  RecordingResult result;
  const std::int64_t number = drop.rows.front().drop;
  const synthesis::SynthesisConfig config = synthesis::config_of_drop(by.config, by.levels, number);
  const synthesis::SyntheticRecording sound(drop, config, by.instrument);
  const std::vector<float> samples = sound.samples_as_read_back();
  result.truth = sound.truth();
  result.sound_s = static_cast<double>(samples.size()) / config.rate_hz;
  result.recording = synthesis::path_of_drop(ball + ".flac", number).string();
  if (folder) keep(samples, config, *folder / result.recording);
  result.onsets = detection::detect(samples, config.rate_hz, result.recording).onsets;
  return result;
}

/// The sound of each drop and the impacts in it, in parallel, through memory; the same for any number of threads.
void sound_by_drop(LoopResult& loop, const LoopConfig& config, const StageProgress& progress) {
  std::optional<DropSound> sound;  // that of the rough ball
  for (BallResult* ball : {&loop.rough, &loop.smooth}) {
    if (ball->name.empty()) continue;
    const std::vector<Impacts> drops = by_drop(ball->impacts);
    if (!sound) sound = sound_of_drops(config.synthesis, drops);
    ball->recordings.resize(drops.size());
    const ProgressCallback shown = progress("synthesize and detect the " + ball->name + " ball", "drops");
    std::mutex mutex;
    std::size_t n_done = 0;
    parallel_for(drops.size(), config.n_threads, [&](std::size_t k) {
      ball->recordings[k] = run_drop(drops[k], ball->name, *sound, config.sound_folder);
      const std::lock_guard lock(mutex);
      if (shown) shown(static_cast<double>(++n_done), static_cast<double>(drops.size()));
    });
    score(*ball);
  }
}

/// All drops in one file, one after the other: what they have in common is learned of all.
void sound_together(LoopResult& loop, const LoopConfig& config, const StageProgress& progress) {
  RecordingResult result;
  result.recording = config.recording->string();
  const auto take = [&](const synthesis::DropTruth& drop) {
    result.truth.insert(result.truth.end(), drop.impacts.begin(), drop.impacts.end());
    result.others.insert(result.others.end(), drop.others.begin(), drop.others.end());
  };
  result.sound_s = synthesis::synthesize(synthesis::drops_of(loop.rough.impacts), config.synthesis, *config.recording,
                                         true, take, progress("synthesize", "s of sound"))
                       .duration_s;
  result.onsets = std::move(
      detection::detect({*config.recording}, {}, config.n_threads, progress("detect", "s of sound")).front().onsets);
  loop.rough.recordings.push_back(std::move(result));
  score(loop.rough);
}

Onsets true_onsets_of(const std::vector<RecordingResult>& recordings) {
  Onsets all;
  for (const RecordingResult& r : recordings) {
    const Onsets truth = synthesis::onsets_of_truth(r.truth, r.recording);
    all.insert(all.end(), truth.begin(), truth.end());
  }
  return all;
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
  fit::FitConfig fit_config;
  fit_config.law.node_speeds_mps.assign(kNodeSpeeds_mps.begin(), kNodeSpeeds_mps.end());
  fit_config.law.seed = loop.simulation.seed;
  fit_config.budget = budget_config_of(loop.simulation);
  fit_config.compare_recordings = false;  // each drop is one, all of the same ball
  const auto fit = [&](RestitutionSamples of, RestitutionSamples& samples, fit::FitResult& result, bool memory) {
    fit::FitConfig this_config = fit_config;
    if (memory) this_config.memory = fit::UseMemory::where_long;
    samples = std::move(of);
    result = fit::fit_all(samples, this_config);
  };
  const auto fit_onsets = [&](const Onsets& onsets, RestitutionSamples& samples, fit::FitResult& result, bool memory) {
    fit(fit::restitution_samples(onsets, restitution_config_of(loop.simulation)).samples, samples, result, memory);
  };
  const auto &rough = loop.rough.recordings, &smooth = loop.smooth.recordings;
  std::vector<std::function<void()>> fits{
      [&] { fit_onsets(onsets_of(rough), loop.samples_sound, loop.sound, config.with_memory); },
      [&] { fit_onsets(true_onsets_of(rough), loop.samples_true, loop.true_times, config.with_memory); }};
  if (config.with_direct)
    fits.emplace_back([&] { fit(direct_samples(loop.rough.impacts), loop.samples_direct, loop.direct, false); });
  if (!smooth.empty())
    fits.emplace_back([&] { fit_onsets(onsets_of(smooth), loop.samples_smooth, loop.smooth_sound, false); });
  if (const ProgressCallback report = progress("fit", "fits")) report(0.0, static_cast<double>(fits.size()));
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

Onsets onsets_of(const std::vector<RecordingResult>& recordings) {
  Onsets all;
  for (const RecordingResult& r : recordings) all.insert(all.end(), r.onsets.begin(), r.onsets.end());
  return all;
}

Table truth_table_of(const std::vector<RecordingResult>& recordings) {
  std::vector<synthesis::TrueImpact> all;
  std::vector<std::string> names;
  for (const RecordingResult& r : recordings) {
    all.insert(all.end(), r.truth.begin(), r.truth.end());
    names.insert(names.end(), r.truth.size(), r.recording);
  }
  Table table = synthesis::truth_table(all, "");
  table.columns.front().values = std::move(names);
  return table;
}

double sound_s(const LoopResult& loop) {
  double sum = 0.0;
  for (const BallResult* ball : {&loop.rough, &loop.smooth})
    for (const RecordingResult& r : ball->recordings) sum += r.sound_s;
  return sum;
}

}  // namespace bouncelab::loop

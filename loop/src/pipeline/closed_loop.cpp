// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/closed_loop.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>

#include "bouncelab/core/parallel.hpp"

namespace bouncelab::loop {
namespace {

double processor_time_s() {
  std::timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Runs a stage and adds its wall and processor time.
template <class Stage>
void timed(LoopResult& loop, const std::string& name, const Stage& stage) {
  using Clock = std::chrono::steady_clock;
  const double start_s = processor_time_s();
  const auto start = Clock::now();
  stage();
  loop.wall_s.emplace_back(name, std::chrono::duration<double>(Clock::now() - start).count());
  loop.processor_s.emplace_back(name, processor_time_s() - start_s);
}

std::int64_t n_smooth_drops(std::int64_t n_rough) {
  return std::max<std::int64_t>(1, n_rough / kRoughDropsPerSmoothDrop);
}

ProgressCallback callback(const StageProgress& progress, const std::string& label, const std::string& unit) {
  return progress ? progress(label, unit) : ProgressCallback{};
}

std::string item_name(const std::string& ball, std::int64_t drop) { return ball + " " + std::to_string(drop); }

/// The drops that the loop records, by ball: their numbers.
std::vector<std::pair<std::string, std::vector<std::int64_t>>> drops_of_balls(const LoopConfig& config) {
  const auto numbers = [&](std::int64_t n) {
    std::vector<std::int64_t> all(static_cast<std::size_t>(n));
    std::iota(all.begin(), all.end(), config.simulation.first_drop);
    return all;
  };
  const std::int64_t n = config.simulation.n_drops;
  std::vector<std::pair<std::string, std::vector<std::int64_t>>> balls{{"rough", numbers(n)}};
  if (config.with_smooth_ball) balls.emplace_back("smooth", numbers(n_smooth_drops(n)));
  return balls;
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
  ball.impacts.states = {};
  return ball;
}

void simulate_balls(const LoopConfig& config, LoopResult& loop, const StageProgress& progress) {
  sim::SimulationConfig simulation = loop.simulation;
  simulation.with_state = true;
  {
    const sim::Surface surface = surface_of(config, progress);
    loop.section = sim::section_of(simulation.ball, surface);
    loop.rough = simulated("rough", simulation, surface, loop, progress);
  }
  if (!config.with_smooth_ball) return;
  simulation.with_state = false;
  simulation.n_drops = n_smooth_drops(simulation.n_drops);
  loop.smooth = simulated("smooth", simulation, sim::Surface{}, loop, progress);
}

/// The impacts of some drops, one drop after the other.
Impacts impacts_of(const sim::SimulationConfig& config, const sim::Surface& surface,
                   const std::vector<std::int64_t>& drops, const StageProgress& progress) {
  std::vector<Impacts> each(drops.size());
  sim::simulate_each(
      config, surface, drops, [&](std::size_t k, sim::DropResult&& drop) { each[k] = std::move(drop.impacts); },
      callback(progress, "simulate", "drops"));
  Impacts all;
  for (const Impacts& drop : each) all.rows.insert(all.rows.end(), drop.rows.begin(), drop.rows.end());
  return all;
}

std::set<std::int64_t> drops_with_impacts(const Impacts& impacts) {
  std::set<std::int64_t> drops;
  for (const Impact& impact : impacts.rows) drops.insert(impact.drop);
  return drops;
}

/// The impacts of these drops of the rough ball and of the first ones, as many as gain and noise are chosen by.
Impacts impacts_with_first(const sim::SimulationConfig& config, const sim::Surface& surface,
                           const std::vector<std::int64_t>& wanted, const StageProgress& progress) {
  for (std::int64_t n_first = kDropsForLevels;; n_first *= 2) {  // again where some of them had no impacts
    std::set<std::int64_t> drops(wanted.begin(), wanted.end());
    for (std::int64_t k = 0; k < std::min(n_first, config.n_drops); ++k) drops.insert(config.first_drop + k);
    Impacts impacts = impacts_of(config, surface, {drops.begin(), drops.end()}, progress);
    const std::set<std::int64_t> with_impacts = drops_with_impacts(impacts);
    const auto n = std::distance(with_impacts.begin(), with_impacts.lower_bound(config.first_drop + n_first));
    if (n >= kDropsForLevels || n_first >= config.n_drops) return impacts;
  }
}

void record_and_detect(BallResult& ball, const DropRecording& recording, std::vector<DropResult> finished,
                       int n_threads, RunJournal* journal, const StageProgress& progress) {
  DropSink sink;
  if (journal != nullptr)
    sink = [&](const DropResult& drop) {
      journal->append(item_name(ball.name, drop.drop), to_record(ball.name, drop));
    };
  ball.drops = run_drops(ball.impacts, ball.name, recording, std::move(finished), n_threads, sink,
                         callback(progress, "synthesize and detect the " + ball.name + " ball", "drops"));
  ball.score = detection::score_onsets(true_onsets_of(ball.drops, ball.name), onsets_of(ball.drops));
}

const char* const kSound = "sound";

/// Synthesis and detection are one pass over the drops; the drops' own clocks tell their shares of processor time.
void split_sound_stage(LoopResult& loop) {
  double synthesize_s = 0.0, detect_s = 0.0;
  for (const BallResult* ball : {&loop.rough, &loop.smooth})
    for (const DropResult& drop : ball->drops) {
      synthesize_s += drop.synthesize_s;
      detect_s += drop.detect_s;
    }
  auto& stages = loop.processor_s;
  const auto sound = std::find_if(stages.begin(), stages.end(), [](const auto& s) { return s.first == kSound; });
  *sound = {"synthesize", synthesize_s};
  stages.insert(sound + 1, {"detect", detect_s});
}

void fit_everything(LoopResult& loop, const LoopConfig& config, const StageProgress& progress) {
  const auto samples_of = [&](const Onsets& onsets) {
    return fit::restitution_samples(onsets, restitution_config_of(loop.simulation)).samples;
  };
  fit::FitConfig fit_config;
  fit_config.law.node_speeds_mps = config.node_speeds_mps;
  fit_config.budget = budget_config_of(loop.simulation);
  fit_config.compare_recordings = false;  // each drop is one, all of the same ball
  const auto fit = [&](const RestitutionSamples& samples, fit::FitResult& result, bool memory = false) {
    fit::FitConfig this_config = fit_config;
    if (memory) this_config.memory = fit::UseMemory::where_long;
    result = fit::fit_all(samples, this_config);
  };
  if (const ProgressCallback report = callback(progress, "fit", "fits")) report(0.0, 4.0);
  std::vector<std::function<void()>> fits{[&] {
                                            loop.samples_sound = samples_of(onsets_of(loop.rough.drops));
                                            fit(loop.samples_sound, loop.sound, config.with_memory);
                                          },
                                          [&] {
                                            loop.samples_true =
                                                samples_of(true_onsets_of(loop.rough.drops, loop.rough.name));
                                            fit(loop.samples_true, loop.true_times, config.with_memory);
                                          },
                                          [&] {
                                            loop.samples_direct = direct_samples(loop.rough.impacts);
                                            fit(loop.samples_direct, loop.direct);
                                          }};
  if (!loop.smooth.drops.empty())
    fits.emplace_back([&] { fit(samples_of(onsets_of(loop.smooth.drops)), loop.smooth_sound); });
  parallel_for(fits.size(), config.n_threads, [&](std::size_t k) { fits[k](); });
}

}  // namespace

std::vector<std::string> loop_items(const LoopConfig& config) {
  std::vector<std::string> items;
  for (const auto& [ball, drops] : drops_of_balls(config))
    for (const std::int64_t drop : drops) items.push_back(item_name(ball, drop));
  return items;
}

void run_loop_drops(const LoopConfig& config, const ItemChoice& is_wanted, RunJournal& journal,
                    const StageProgress& progress) {
  sim::SimulationConfig simulation = config.simulation;
  simulation.n_threads = config.n_threads;
  std::optional<DropRecording> recording;
  for (const auto& [ball, drops] : drops_of_balls(config)) {
    std::vector<std::int64_t> wanted;
    for (const std::int64_t drop : drops)
      if (is_wanted(item_name(ball, drop))) wanted.push_back(drop);
    // gain and noise are those of the rough ball's first drops for both balls
    Impacts impacts = recording ? impacts_of(simulation, sim::Surface{}, wanted, progress)
                                : impacts_with_first(simulation, surface_of(config, progress), wanted, progress);
    if (!recording) {
      recording = drop_recording(config.synthesis, impacts);
      recording->folder = config.sound_folder;
    }
    std::set<std::int64_t> left(wanted.begin(), wanted.end());
    std::erase_if(impacts.rows, [&](const Impact& impact) { return left.count(impact.drop) == 0; });
    for (const std::int64_t drop : drops_with_impacts(impacts)) left.erase(drop);
    for (const std::int64_t drop : left) journal.append(item_name(ball, drop), "");
    const DropSink sink = [&, name = ball](const DropResult& drop) {
      journal.append(item_name(name, drop.drop), to_record(name, drop));
    };
    if (!impacts.rows.empty())
      run_drops(impacts, ball, *recording, {}, config.n_threads, sink,
                callback(progress, "synthesize and detect the " + ball + " ball", "drops"));
  }
}

void FinishedDrops::add(std::string_view record) {
  if (record.empty()) return;
  NamedDrop named = drop_from_record(record);
  (named.ball == "smooth" ? smooth : rough).push_back(std::move(named.drop));
}

LoopResult run_loop(const LoopConfig& config, const StageProgress& progress, FinishedDrops finished,
                    RunJournal* journal) {
  LoopResult loop;
  loop.simulation = config.simulation;
  loop.simulation.n_threads = config.n_threads;
  timed(loop, "simulate", [&] { simulate_balls(config, loop, progress); });
  timed(loop, kSound, [&] {
    DropRecording recording = drop_recording(config.synthesis, loop.rough.impacts);
    recording.folder = config.sound_folder;
    record_and_detect(loop.rough, recording, std::move(finished.rough), config.n_threads, journal, progress);
    if (config.with_smooth_ball)
      record_and_detect(loop.smooth, recording, std::move(finished.smooth), config.n_threads, journal, progress);
  });
  split_sound_stage(loop);
  timed(loop, "restitution_and_fit", [&] { fit_everything(loop, config, progress); });
  timed(loop, "theory", [&] {
    const sim::ContactOffset offset =
        contact_offset_of(config.simulation.ball, config.surface ? &*config.surface : nullptr, config.radius_law,
                          config.n_asperities, config.n_threads);
    const auto reservoir = [&] {
      loop.reservoir =
          reservoir_check(loop.rough.impacts, loop.reservoirs, true_onsets_of(loop.rough.drops, loop.rough.name),
                          onsets_of(loop.rough.drops), loop.rough.score.match, loop.samples_sound, loop.sound,
                          loop.simulation.gravity_mps2);
    };
    const auto theory = [&] {
      loop.theory = scatter_theory(loop.simulation, offset, loop.rough.impacts, loop.sound.histograms);
    };
    parallel_for(2, config.n_threads, [&](std::size_t k) { k == 0 ? reservoir() : theory(); });
  });
  return loop;
}

fit::RestitutionConfig restitution_config_of(const sim::SimulationConfig& simulation) {
  fit::RestitutionConfig config;
  config.gravity_mps2 = simulation.gravity_mps2;
  config.ball = simulation.ball;
  return config;
}

fit::BudgetConfig budget_config_of(const sim::SimulationConfig& simulation) {
  fit::BudgetConfig budget;
  budget.ball = simulation.ball;
  budget.gravity_mps2 = simulation.gravity_mps2;
  if (simulation.air) budget.air = *simulation.air;
  budget.drag = simulation.air ? fit::Effect::present : fit::Effect::absent;
  budget.contact_time = budget.travel_time = fit::Effect::absent;
  return budget;
}

double sound_s(const LoopResult& loop) {
  double sum = 0.0;
  for (const BallResult* ball : {&loop.rough, &loop.smooth})
    for (const DropResult& drop : ball->drops) sum += drop.sound_s;
  return sum;
}

}  // namespace bouncelab::loop

// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/synthesis/synthesize.hpp"
#include "render/renderer.hpp"

namespace bouncelab::synthesis {
namespace {

/// Results of the first passage through the impacts.
struct Survey {
  Levels levels;
  double weakest_impulse_ns = 0.0;
  double duration_s = 0.0;
};

Survey survey(const DropSource& drops, const SynthesisConfig& config, const StrikeSound& sound,
              const ProgressCallback& progress) {
  Survey result;
  Scheduler scheduler(config, 0.0);
  double weakest_peak = 0.0, strongest_peak = 0.0;
  std::int64_t drop_before = 0;
  const DropSource groups = in_groups(drops, config.together);
  Impacts group;
  for (std::int64_t k = 0; groups(k, group); ++k) {
    const bool is_first = k == 0;
    validate(group, config);
    if (!is_first && group.rows.front().drop <= drop_before)
      throw InvalidArgument("drop " + std::to_string(group.rows.front().drop) + " comes after drop " +
                            std::to_string(drop_before) + "; sort by drop and time");
    const std::vector<Strike> strikes = scheduler.place_balls(group);
    for (const Strike& strike : strikes) check_contact(strike.duration_s, config);
    const auto weakest_strike = std::min_element(
        strikes.begin(), strikes.end(), [](const auto& a, const auto& b) { return a.impulse_ns < b.impulse_ns; });
    result.weakest_impulse_ns =
        is_first ? weakest_strike->impulse_ns : std::min(result.weakest_impulse_ns, weakest_strike->impulse_ns);
    if (!config.levels) {
      const std::vector<double> peaks = sound.peaks(strikes);
      const auto [weakest, strongest] = std::minmax_element(peaks.begin(), peaks.end());
      weakest_peak = is_first ? *weakest : std::min(weakest_peak, *weakest);
      strongest_peak = std::max(strongest_peak, *strongest);
    }
    drop_before = group.rows.back().drop;
    if (progress) progress(0.0, 0.0);
  }
  result.duration_s = scheduler.duration_s();
  if (result.duration_s == 0.0) validate(Impacts{}, config);  // throws: there are no impacts
  result.levels = config.levels ? *config.levels : levels_for(config, weakest_peak, strongest_peak);
  return result;
}

void check_file(const std::filesystem::path& out, const SynthesisConfig& config) {
  audio::validate(out, {config.rate_hz, static_cast<int>(config.channels.size()), config.encoding});
}

/// One recording from impacts to file. The schedule holds only the drops that sound in the current batch.
class RecordingWriter {
 public:
  RecordingWriter(const SynthesisConfig& config, const StrikeSound& sound, const Survey& survey,
                  std::filesystem::path out, bool may_replace)
      : config_(config),
        sound_(sound),
        survey_(survey),
        out_(std::move(out)),
        scheduler_(config, survey.weakest_impulse_ns),
        renderer_(config, sound, schedule_, survey.levels, waves_),
        n_frames_(static_cast<std::int64_t>(std::ceil(survey.duration_s * config.rate_hz))),
        writer_(out_, {config.rate_hz, static_cast<int>(config.channels.size()), config.encoding}, n_frames_,
                may_replace) {}

  void write(const DropSource& drops, const TruthSink& truth, const ProgressCallback& progress,
             SynthesisResult& result) {
    const std::int64_t batch_frames = resolved_threads(config_.n_threads) * renderer_.segment_frames();
    const DropSource groups = in_groups(drops, config_.together);
    Impacts group;
    std::int64_t n_groups = 0;
    for (std::int64_t first = 0; first < n_frames_; first += batch_frames) {
      const double begin_s = static_cast<double>(first) / config_.rate_hz;
      const double end_s = static_cast<double>(first + batch_frames) / config_.rate_hz;
      while (schedule_.duration_s < end_s + renderer_.reach_ahead_s() && groups(n_groups, group)) {
        ++n_groups;
        add(group, truth, result);
      }
      const std::size_t n_before = schedule_.strikes.size();
      forget(schedule_, begin_s - renderer_.reach_back_s());
      waves_.erase(waves_.begin(), waves_.begin() + static_cast<std::ptrdiff_t>(n_before - schedule_.strikes.size()));
      write_batch(first, std::min(first + batch_frames, n_frames_));
      if (progress) progress(std::min(survey_.duration_s, end_s), survey_.duration_s);
    }
    if (schedule_.duration_s != survey_.duration_s)
      throw InvalidArgument("the impacts changed between the two passages of the synthesis; start again");
    writer_.commit();
    result.duration_s += static_cast<double>(n_frames_) / config_.rate_hz;
  }

 private:
  void add(const Impacts& group, const TruthSink& truth, SynthesisResult& result) {
    const std::size_t n_before = schedule_.strikes.size();
    scheduler_.add_group(group, schedule_);
    std::vector<ContactWave> waves;
    DropTruth true_values{out_, sound_.truth(std::span(schedule_.strikes).subspan(n_before), &waves),
                          std::exchange(schedule_.others, {})};
    std::move(waves.begin(), waves.end(), std::back_inserter(waves_));
    scale_to(survey_.levels, true_values.impacts);
    add_pushes(config_, true_values.impacts, schedule_);
    result.n_impacts += static_cast<std::int64_t>(true_values.impacts.size());
    result.n_other_sounds += static_cast<std::int64_t>(true_values.others.size());
    result.n_clipped += std::count_if(true_values.impacts.begin(), true_values.impacts.end(),
                                      [](const TrueImpact& impact) { return impact.flags.has(Flag::clipped); });
    if (truth) truth(true_values);
  }

  void write_batch(std::int64_t first, std::int64_t end) {
    const std::int64_t step = renderer_.segment_frames();
    std::vector<std::vector<double>> segments(static_cast<std::size_t>((end - first + step - 1) / step));
    parallel_for(segments.size(), config_.n_threads, [&](std::size_t s) {
      const std::int64_t begin = first + static_cast<std::int64_t>(s) * step;
      segments[s] = renderer_.frames(begin, std::min(step, end - begin));
    });
    for (const auto& segment : segments) writer_.write(segment);
  }

  const SynthesisConfig& config_;
  const StrikeSound& sound_;
  Survey survey_;
  std::filesystem::path out_;
  Schedule schedule_;
  std::vector<ContactWave> waves_;  // of its strikes
  Scheduler scheduler_;
  Renderer renderer_;
  std::int64_t n_frames_;
  audio::AudioWriter writer_;
};

void summarise(SynthesisResult& result, const SynthesisConfig& config, const Instrument& instrument) {
  result.n_modes = static_cast<int>(instrument.plate().modes().size());
  const double nyquist_hz = 0.5 * config.rate_hz;
  std::vector<double> left_out_hz;
  if (nyquist_hz < config.max_mode_hz) {
    const PlateModes all(config.ground, config.max_mode_hz);
    for (const PlateMode& mode : all.modes())
      if (mode.frequency_hz >= nyquist_hz) left_out_hz.push_back(mode.frequency_hz);
  }
  if (!left_out_hz.empty()) {
    const auto [lowest, highest] = std::minmax_element(left_out_hz.begin(), left_out_hz.end());
    result.notes.push_back(
        {NoteKind::modes_left_out, {static_cast<double>(left_out_hz.size()), *lowest, *highest, 1.0 * config.rate_hz}});
  }
  if (result.n_clipped > 0)
    result.notes.push_back({NoteKind::synthetic_clipped, {static_cast<double>(result.n_clipped)}});
}

}  // namespace

DropSource drops_of(const Impacts& impacts) {
  std::vector<std::ptrdiff_t> begins;  // of each drop, and the end of the last
  for (std::size_t k = 0; k < impacts.rows.size(); ++k)
    if (k == 0 || impacts.rows[k].drop != impacts.rows[k - 1].drop) begins.push_back(static_cast<std::ptrdiff_t>(k));
  begins.push_back(std::ssize(impacts.rows));
  return [&impacts, begins = std::move(begins)](std::int64_t k, Impacts& drop) {
    if (k + 1 >= std::ssize(begins)) return false;
    const std::ptrdiff_t first = begins[static_cast<std::size_t>(k)], last = begins[static_cast<std::size_t>(k) + 1];
    drop.rows.assign(impacts.rows.begin() + first, impacts.rows.begin() + last);
    drop.states.clear();
    if (!impacts.states.empty()) drop.states.assign(impacts.states.begin() + first, impacts.states.begin() + last);
    return true;
  };
}

DropSource in_groups(const DropSource& drops, int n_together) {
  if (n_together == 1) return drops;
  return [drops, n_together](std::int64_t k, Impacts& group) {
    group = {};
    Impacts drop;
    for (int n = 0; n < n_together && drops(k * n_together + n, drop); ++n) {
      group.rows.insert(group.rows.end(), drop.rows.begin(), drop.rows.end());
      group.states.insert(group.states.end(), drop.states.begin(), drop.states.end());
    }
    return !group.rows.empty();
  };
}

SynthesisConfig config_of_drop(const SynthesisConfig& config, const Levels& levels, std::int64_t drop) {
  SynthesisConfig own = config;
  own.levels = levels;
  own.seed = philox_block(config.seed, RandomStream::noise, 1ull << 63, static_cast<std::uint64_t>(drop))[0];
  return own;
}

std::filesystem::path path_of_drop(const std::filesystem::path& out, std::int64_t drop) {
  std::string number = std::to_string(drop);
  if (number.size() < 4) number.insert(0, 4 - number.size(), '0');
  return out.parent_path() / (out.stem().string() + "." + number + out.extension().string());
}

SynthesisResult synthesize(const DropSource& drops, const SynthesisConfig& config, const std::filesystem::path& out,
                           bool may_replace, const TruthSink& truth, const ProgressCallback& progress) {
  check_file(out, config);
  const StrikeSound sound(config, make_instrument(config));
  const Survey found = survey(drops, config, sound, progress);
  SynthesisResult result;
  result.levels = found.levels;
  RecordingWriter(config, sound, found, out, may_replace).write(drops, truth, progress, result);
  summarise(result, config, sound.instrument());
  return result;
}

SynthesisResult synthesize_each_drop(const DropSource& drops, const SynthesisConfig& config,
                                     const std::filesystem::path& out, bool may_replace, const TruthSink& truth,
                                     const ProgressCallback& progress) {
  if (config.together > 1)
    throw InvalidArgument("together is " + std::to_string(config.together) +
                          ": drops that sound together are in one file, not one in each; ask for one of the two");
  check_file(out, config);
  const auto instrument = make_instrument(config);
  SynthesisResult all;
  all.levels = survey(drops, config, StrikeSound(config, instrument), progress).levels;
  all.n_files = 0;
  Impacts drop;
  for (; drops(all.n_files, drop); ++all.n_files) {
    const std::int64_t number = drop.rows.front().drop;
    const SynthesisConfig of_drop = config_of_drop(config, all.levels, number);
    const StrikeSound sound(of_drop, instrument);
    const DropSource only = drops_of(drop);
    SynthesisResult of_file;
    RecordingWriter(of_drop, sound, survey(only, of_drop, sound, {}), path_of_drop(out, number), may_replace)
        .write(only, truth, {}, of_file);
    all.n_impacts += of_file.n_impacts;
    all.n_clipped += of_file.n_clipped;
    all.n_other_sounds += of_file.n_other_sounds;
    all.duration_s += of_file.duration_s;
    if (progress) progress(static_cast<double>(all.n_impacts), 0.0);
  }
  summarise(all, config, *instrument);
  return all;
}

Description members_of(const SynthesisResult*) {
  using R = SynthesisResult;
  static constexpr Member all[]{
      member<&R::n_impacts>("n_impacts", "Impacts"),
      member<&R::n_other_sounds>("n_other_sounds", "Of things that are not the ball"),
      member<&R::n_modes>("n_modes", "Of the plate, below half the sampling rate"),
      member<&R::n_files>("n_files", "Recordings"),
      member<&R::duration_s>("duration_s", "Of all files"),
      member<&R::levels, &Levels::noise_rms>("noise_rms", "Of the stationary noise, full scale = 1"),
      member<&R::levels, &Levels::weakest_peak>("weakest_peak", "Clean peak of the weakest impact wanted"),
      member<&R::levels, &Levels::gain>("gain", "From the sensor's signal to full scale")};
  return all;
}

}  // namespace bouncelab::synthesis

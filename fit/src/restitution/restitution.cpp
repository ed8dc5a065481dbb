// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/restitution.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <string_view>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {
namespace {

/// The flag for which an onset's time cannot be used. A doubtful one with a standard error states how far it may be
/// off.
std::optional<Flag> breaking_flag(const Onset& onset) {
  if (onset.flags.has(Flag::doubtful) && !onset.sigma_t_s) return Flag::doubtful;
  for (const Flag flag : {Flag::improbable, Flag::inferred})
    if (onset.flags.has(flag)) return flag;
  return std::nullopt;
}

RestitutionSample sample_of(const Onset& here) {
  RestitutionSample sample;
  sample.recording = here.recording;
  sample.drop = here.drop;
  sample.impact = here.impact;
  sample.t_s = here.t_s;
  return sample;
}

RestitutionSample sample_at(std::span<const Onset> piece, std::size_t k, const RestitutionConfig& config) {
  const Onset &before = piece[k - 1], &here = piece[k], &after = piece[k + 1];
  const double before_s = here.t_s - before.t_s, after_s = after.t_s - here.t_s;
  RestitutionSample sample = sample_of(here);
  sample.v_mps = 0.5 * config.gravity_mps2 * before_s;
  sample.eps = after_s / before_s;
  if (!before.sigma_t_s || !here.sigma_t_s) return sample;
  sample.sigma_v_mps = 0.5 * config.gravity_mps2 * hypot(*before.sigma_t_s, *here.sigma_t_s);
  if (after.sigma_t_s)
    sample.sigma_eps =
        hypot(*after.sigma_t_s, (1.0 + sample.eps) * *here.sigma_t_s, sample.eps * *before.sigma_t_s) / before_s;
  return sample;
}

/// The first impact of a drop from a known height.
RestitutionSample first_sample(const Onset& here, const Onset& after, const RestitutionConfig& config) {
  const double g = config.gravity_mps2;
  RestitutionSample sample = sample_of(here);
  sample.v_mps = std::sqrt(2.0 * g * *config.drop_height_m);
  const double interval_s = after.t_s - here.t_s;
  sample.eps = 0.5 * g * interval_s / sample.v_mps;
  const double of_height = 0.5 * config.sigma_height_m.value_or(0.0) / *config.drop_height_m;
  if (config.sigma_height_m) sample.sigma_v_mps = of_height * sample.v_mps;
  if (here.sigma_t_s && after.sigma_t_s)
    sample.sigma_eps = sample.eps * hypot(hypot(*here.sigma_t_s, *after.sigma_t_s) / interval_s, of_height);
  return sample;
}

/// Of heights: what it fell from before the impact, and rose to after it.
RestitutionSample sample_of_heights(const Onset& here, const Onset& after, const RestitutionConfig& config) {
  RestitutionSample sample = sample_of(here);
  const double before_m = *here.fall_m, after_m = *after.fall_m;
  sample.v_mps = std::sqrt(2.0 * config.gravity_mps2 * before_m);
  sample.eps = std::sqrt(after_m / before_m);
  if (here.sigma_fall_m && after.sigma_fall_m) {
    sample.sigma_v_mps = 0.5 * sample.v_mps * *here.sigma_fall_m / before_m;
    sample.sigma_eps = 0.5 * sample.eps * hypot(*here.sigma_fall_m / before_m, *after.sigma_fall_m / after_m);
  }
  return sample;
}

/// Samples at successive impacts: b follows a with nothing between.
bool adjacent(std::span<const RestitutionSample> drop, std::size_t a, std::size_t b) {
  return a < drop.size() && b < drop.size() && drop[b].impact - drop[a].impact == static_cast<std::int64_t>(b - a);
}

/// Flags ratios that only a missed or an invented impact explains. A missed impact makes one interval too long: the
/// ratio there too large, the next too small. An invented one splits an interval: the first ratio that stands out is
/// too small, and the split interval's halves touch up to two samples on either side.
/// Of times whose error is not known, a stop watch's, only what leaves T' = m T by five times what the others do.
void flag_wrong_intervals(std::span<RestitutionSample> drop, bool error_is_known, RestitutionCounts& counts) {
  constexpr std::size_t kEnoughForAMedian = 5;
  if (drop.size() < kEnoughForAMedian) return;
  std::vector<double> ratios;
  for (const auto& s : drop) ratios.push_back(s.eps);
  const double m = upper_median(ratios);
  const double factor = std::sqrt(1.0 + m);
  std::vector<double> off;  // T' - m T, up to a constant
  for (const auto& s : drop) off.push_back(std::abs((s.eps - m) * s.v_mps));
  constexpr double kFarOff = 5.0 * kSdOverMad;  // standard deviations, of a normal distribution, in medians
  const double within = error_is_known ? 0.0 : kFarOff * median(off);
  const auto differ = [&](double a, double b) { return a >= factor * b || b >= factor * a; };
  for (std::size_t k = 0; k < drop.size(); ++k) {
    // a coefficient that falls steeply with the speed leaves the median too, but step by step
    const bool jumps =
        (k > 0 && differ(ratios[k], ratios[k - 1])) || (k + 1 < drop.size() && differ(ratios[k], ratios[k + 1]));
    if (!differ(ratios[k], m) || !jumps || off[k] < within) continue;
    const bool missed = ratios[k] > m;
    const Flag reason = missed ? Flag::missing_impact : Flag::extra_impact;
    ++counts.breaks[reason];
    const std::size_t first = !missed && k > 0 && adjacent(drop, k - 1, k) ? k - 1 : k;
    const std::size_t last = k + (missed ? 1 : 2);
    for (std::size_t j = first; j <= last && adjacent(drop, first, j); ++j) {
      drop[j].flags.add(reason);
      k = std::max(k, j);
    }
  }
  // What then comes to the drop's end with intervals that fall by less than half as much (in ln) as a ball's is its
  // rattle, or what it lies on.
  const auto behind =
      std::find_if(drop.rbegin(), drop.rend(), [](const auto& s) { return s.flags.has(Flag::extra_impact); });
  if (behind == drop.rend() || behind - drop.rbegin() < 2) return;
  const std::span<RestitutionSample> rest(behind.base(), drop.end());
  double ln_product = 0.0;
  for (const auto& s : rest) ln_product += std::log(s.eps);
  if (ln_product <= 0.5 * std::log(m) * static_cast<double>(rest.size())) return;
  for (auto& s : rest) s.flags.add(Flag::extra_impact);
}

double median_of_others(const RestitutionSamples& samples) {
  std::vector<double> eps;
  for (std::size_t k = 1; k < samples.size(); ++k) eps.push_back(samples[k].eps);
  return median(std::move(eps));
}

/// Does the first impact, of a height that was given, leave what the others say by half as much as a missing one would?
bool contradicts(const RestitutionSamples& samples) {
  if (samples.size() < 3) return false;
  const double m = median_of_others(samples), ratio = samples.front().eps / m;
  const double factor = std::sqrt(std::sqrt(1.0 + m));
  return ratio > factor || ratio < 1.0 / factor;
}

/// Samples of one drop, in time order.
RestitutionSamples samples_of_drop(std::span<const Onset> drop, const RestitutionConfig& config,
                                   RestitutionCounts& counts, std::vector<double>& heights_m) {
  RestitutionSamples samples;
  samples.reserve(drop.size());
  std::size_t piece_begin = 0;
  const auto close_piece = [&](std::size_t end) {
    const auto piece = drop.subspan(piece_begin, end - piece_begin);
    if (!piece.empty() && piece.front().fall_m) {
      for (std::size_t k = 0; k + 1 < piece.size(); ++k)
        samples.push_back(sample_of_heights(piece[k], piece[k + 1], config));
      return;
    }
    if (config.drop_height_m && piece.size() >= 2 && piece[0].impact == 0)
      samples.push_back(first_sample(piece[0], piece[1], config));
    for (std::size_t k = 1; k + 1 < piece.size(); ++k) samples.push_back(sample_at(piece, k, config));
  };
  for (std::size_t k = 0; k < drop.size(); ++k) {
    if (k > 0 && !(drop[k].t_s > drop[k - 1].t_s))
      throw InvalidArgument("onset " + std::to_string(drop[k].impact) + " of drop " + std::to_string(drop[k].drop) +
                            ": times must increase within a drop; sort the onsets");
    if (k > 0 && drop[k].impact <= drop[k - 1].impact)
      throw InvalidArgument("drop " + std::to_string(drop[k].drop) + ": impact " + std::to_string(drop[k].impact) +
                            " follows impact " + std::to_string(drop[k - 1].impact) +
                            "; number the impacts of a drop in their order, 0, 1, 2 ...");
    if (const std::optional<Flag> flag = breaking_flag(drop[k])) {
      ++counts.breaks[*flag];
      close_piece(k);
      piece_begin = k + 1;
    } else if (k > piece_begin && drop[k].impact != drop[k - 1].impact + 1) {
      ++counts.breaks[Flag::missing_impact];
      close_piece(k);
      piece_begin = k;
    }
  }
  close_piece(drop.size());
  if (drop.front().fall_m) return samples;
  const bool has_first = config.drop_height_m && !samples.empty() && samples.front().impact == 0;
  flag_wrong_intervals(std::span(samples).subspan(has_first ? 1 : 0), drop.front().errors != kOfDigits, counts);
  if (has_first && contradicts(samples)) {
    ++counts.n_heights_contradicted;
    // as high as the ball must fall to be as fast as the flight after the first impact asks for
    const double eps = median_of_others(samples), launch_mps = samples.front().eps * samples.front().v_mps;
    heights_m.push_back(square(launch_mps / eps) / (2.0 * config.gravity_mps2));
    samples.erase(samples.begin());
  }
  return samples;
}

/// Median of eps over the samples that nothing is said against.
std::optional<double> median_eps(const RestitutionSamples& samples) {
  std::vector<double> eps;
  for (const RestitutionSample& sample : samples)
    if (sample.flags.empty()) eps.push_back(sample.eps);
  if (eps.empty()) return std::nullopt;
  return median(std::move(eps));
}

void check(const RestitutionConfig& config) {
  check_options(config);
  if (!config.ball) return;
  for (const auto& [value, quantity] : {std::pair{config.ball->radius_m, "radius of the ball [m]"},
                                        {config.ball->material.density_kgpm3, "density of the ball [kg/m^3]"}})
    if (!(value > 0.0) || !std::isfinite(value))
      throw InvalidArgument(std::string(quantity) + " " + std::to_string(value) + ": must be positive");
}

SampleConditions conditions_of(const RestitutionConfig& config) {
  SampleConditions conditions;
  conditions.drag_corrected = config.air_kgpm3 == 0.0;
  conditions.contact_time_corrected = config.instant_contacts;
  conditions.gravity_mps2 = config.gravity_mps2;
  conditions.ball = config.ball;
  conditions.plate = config.plate;
  conditions.air_kgpm3 = config.air_kgpm3;
  conditions.wave_speed_mps = config.wave_speed_mps;
  return conditions;
}

}  // namespace

RestitutionInPieces::RestitutionInPieces(const RestitutionConfig& config)
    : config_(config), conditions_(conditions_of(config)) {
  check(config_);
}

RestitutionSamples RestitutionInPieces::add(Onsets onsets) {
  RestitutionSamples samples;
  counts_.n_onsets += onsets.size();
  for (Onset& onset : onsets) {
    if (!drop_.empty() && (onset.recording != drop_.front().recording || onset.drop != drop_.front().drop))
      end_drop(samples);
    drop_.push_back(std::move(onset));
  }
  return samples;
}

RestitutionSamples RestitutionInPieces::finish() {
  RestitutionSamples samples;
  if (!drop_.empty()) end_drop(samples);
  if (!heights_m_.empty()) counts_.height_suggested_m = median(heights_m_);
  return samples;
}

void RestitutionInPieces::end_drop(RestitutionSamples& samples) {
  ++counts_.n_drops;
  for (Onset& onset : drop_) {
    if (onset.errors != kOfDigits) continue;
    const std::optional<double>& said = onset.fall_m ? config_.sigma_height_m : config_.sigma_t_s;
    if (!said) continue;
    (onset.fall_m ? onset.sigma_fall_m : onset.sigma_t_s) = said;
    onset.errors.clear();
  }
  const bool sigma_is_least = drop_.front().errors == kOfDigits, of_heights = drop_.front().fall_m.has_value();
  RestitutionSamples of_drop = samples_of_drop(drop_, config_, counts_, heights_m_);
  counts_.n_samples += of_drop.size();
  for (RestitutionSample& s : of_drop) {
    s.conditions = conditions_;
    s.conditions.sigma_is_least = sigma_is_least;
    s.conditions.of_heights = of_heights;
    s.conditions.contact_time_corrected = s.conditions.contact_time_corrected || of_heights;  // heights have none
    if (!s.flags.empty()) ++counts_.n_flagged;
  }
  drop_ = {};  // a drop may be most of the memory
  if (samples.empty())
    samples = std::move(of_drop);
  else
    std::move(of_drop.begin(), of_drop.end(), std::back_inserter(samples));
}

Restitution restitution_samples(const Onsets& onsets, const RestitutionConfig& config) {
  RestitutionInPieces pieces(config);
  Restitution result{pieces.add(onsets), {}};
  RestitutionSamples last = pieces.finish();
  std::move(last.begin(), last.end(), std::back_inserter(result.samples));
  result.counts = pieces.counts();
  result.counts.eps_median = median_eps(result.samples);
  return result;
}

RestitutionSamples at_the_plate(RestitutionSamples samples) {
  const AirAndContact known = air_and_contact_of(samples);
  return at_the_plate(std::move(samples), known, {});
}

RestitutionSamples at_the_plate(RestitutionSamples samples, std::optional<double> kappa_per_m,
                                std::optional<double> contact_s) {
  AirAndContact known = air_and_contact_of(samples);
  if (!known.ball) {  // all that is known is what the fit found
    known.kappa_per_m = kappa_per_m.value_or(0.0);
    known.contact = {.at_1_mps_s = contact_s.value_or(0.0)};
    known.has_drag = known.has_contact = true;
  }
  known.has_drag = known.has_drag && kappa_per_m;
  known.has_contact = known.has_contact && contact_s;
  const Deviation found{known.has_drag ? log(*kappa_per_m / kappa_at_1_mps(known)) : 0.0,
                        known.has_contact ? log(*contact_s / known.contact.at_1_mps_s) : 0.0};
  return at_the_plate(std::move(samples), known, found);
}

std::vector<IntervalPrediction> predict_intervals(const RestitutionSamples& samples, const std::string& recording,
                                                  std::int64_t drop, const std::optional<RestitutionLaw>& law,
                                                  double gravity_mps2) {
  std::vector<IntervalPrediction> intervals;
  for (const RestitutionSample& s : samples) {
    if (s.recording != recording || s.drop != drop) continue;
    const double before_s = 2.0 * s.v_mps / gravity_mps2;
    IntervalPrediction interval{s.impact, s.eps * before_s, std::nullopt, std::nullopt};
    if (law) interval.predicted_s = restitution(*law, s.v_mps) * before_s;
    if (s.sigma_eps) interval.sigma_s = *s.sigma_eps * before_s;
    intervals.push_back(interval);
  }
  return intervals;
}

namespace {

/// Whether the ball that is named touches the plate for most of the time that a bounce of the sample lasts: what is
/// left of a flight then is the error of the contact time.
class ContactMostOfBounce {
 public:
  bool operator()(const RestitutionSample& s) {
    const SampleConditions& said = s.conditions;
    if (!said.ball || !said.gravity_mps2 || said.contact_time_corrected) return false;
    if (said.ball != ball_ || said.plate != plate_)
      ball_ = said.ball, plate_ = said.plate, contact_ = contact_duration(*ball_, plate_);
    return contact_ && 2.0 * contact_->at(s.v_mps) >= 2.0 * s.v_mps / *said.gravity_mps2 * std::clamp(s.eps, 0.0, 1.0);
  }

 private:
  std::optional<Ball> ball_;
  std::optional<Material> plate_;
  std::optional<ContactDuration> contact_;  ///< of that ball on that plate
};

/// Why a sample cannot be used; empty: it can. The first flag names the reason.
std::string_view reason_to_leave_out(const RestitutionSample& s, ContactMostOfBounce& is_mostly_contact) {
  constexpr double kMost_mps = 1e4, kMost = 1e3;  // as tables have them; beyond, squares overflow
  const auto is_error = [](const std::optional<double>& sigma) {
    return !sigma || (*sigma >= 0.0 && *sigma < kMost_mps);
  };
  if (!(std::abs(s.v_mps) <= kMost_mps && std::abs(s.eps) <= kMost)) return "not_finite";
  if (!is_error(s.sigma_v_mps) || !is_error(s.sigma_eps)) return "not_finite";
  constexpr double kLeast_mps = 1e-6;  // so thrown up a ball rises by less than an atom
  if (!(s.v_mps > kLeast_mps)) return "speed_not_positive";
  if (s.flags.empty() && is_mostly_contact(s)) return "contact_most_of_bounce";
  return s.flags.first_word();
}

}  // namespace

PartOfSamples usable_samples(const RestitutionSamples& samples, LeftOut& left_out) {
  std::vector<std::size_t> unusable;
  ContactMostOfBounce is_mostly_contact;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::string_view reason = reason_to_leave_out(samples[k], is_mostly_contact);
    if (reason.empty()) continue;
    unusable.push_back(k);
    ++left_out.n[std::string(reason)];
    left_out.first.try_emplace(std::string(reason), k + 1);
  }
  return {samples, unusable};
}

PartOfSamples::PartOfSamples(const RestitutionSamples& all, const std::vector<std::size_t>& left_out) : all_(all) {
  if (left_out.empty()) return;
  part_.emplace();
  part_->reserve(all.size() - left_out.size());
  auto next = left_out.begin();
  for (std::size_t k = 0; k < all.size(); ++k)
    if (next != left_out.end() && *next == k)
      ++next;
    else
      part_->push_back(all[k]);
}

}  // namespace bouncelab::fit

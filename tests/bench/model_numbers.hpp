// SPDX-License-Identifier: GPL-3.0-or-later
// The numbers of the detector's models by name, in programs that link bouncelab_changeable_detection: there they may be
// changed before anything is detected.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "candidates/candidates.hpp"
#include "channel_tracks.hpp"
#include "contact/contact_time.hpp"
#include "delay/timed_impact.hpp"
#include "drops/drop_timer.hpp"
#include "template/subband_delay.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

struct Number {
  std::string name;  ///< of the stage and of the number
  std::function<double()> get;
  std::function<void(double)> set;
};

template <class T>
Number number(const char* name, T& value) {
  return {name, [&] { return static_cast<double>(value); }, [&](double x) { value = static_cast<T>(x); }};
}

/// Those of the tracks, which tracking_fit varies, and of the other stages those without which a part does nothing.
inline const std::vector<Number>& numbers() {
#define N(value) number(#value, value)
  static const std::vector<Number> all{
      N(kTracking.start_log_odds),
      N(kTracking.usual_first_flight_s),
      N(kTracking.first_flight_scatter),
      N(kTracking.detection_probability),
      N(kTracking.usual_eps),
      N(kTracking.gains),
      N(kTracking.scatter),
      N(kTracking.scatter_weight),
      N(kTracking.most_scatter),
      N(kTracking.first_scatter),
      N(kTracking.outliers),
      N(kTracking.least_loss),
      N(kTracking.unexplained),
      N(kTracking.usual_first_change),
      N(kTracking.first_change_scatter),
      N(kTracking.loudness_exponent),
      N(kTracking.exponent_scatter),
      N(kTracking.loudness_scatter),
      N(kTracking.loudness_weight),
      N(kTracking.rhythm_log_odds),
      N(kTracking.beat_scatter),
      N(kTracking.beat_weight),
      N(kTracking.machine_scatter),
      N(kTracking.tempo_gain),
      N(kTracking.trend_gain),
      N(kTracking.kernel_width),
      N(kTracking.unseen),
      N(kTracking.excess),
      N(kTracking.excess_per_sample),
      N(kTracking.event_per_sample),
      N(kTracking.lower_band),
      N(kTracking.echo_s),
      N(kTracking.pre_echo_s),
      N(kTracking.known_after),
      N(kCandidates.faint),
      N(kCandidates.independence),
      N(kChannels.explained),
      N(kTemplate.many_close),
      N(kTemplate.most_training),
      N(kTemplate.most_starts),
      N(kTemplate.unrepeated),
      N(kTemplate.residual_order),
      N(kTemplate.fewest_for_coherence),
      N(kTemplate.least_information_share),
      N(kTemplate.amplitude_prior),
      N(kTemplate.prior_subbands),
      N(kTemplate.fewest_subbands),
      N(kDelay.least_in_gap),
      N(kDelay.least_of_outlier),
      N(kDelay.most_explained),
      N(kDelay.much_left),
      N(kDelay.fewest_impacts),
      N(kDelay.far_s),
      N(kDrops.own_template),
      N(kDrops.clearly_less),
      N(kDrops.fewest_shared),
      N(kContact.fewest_impacts),
      N(kContact.shape_sigma),
      N(kContact.duration_times_frequency),
  };
#undef N
  return all;
}

/// @throws InvalidArgument where there is none of that name
inline const Number& number_named(std::string_view name) {
  for (const Number& n : numbers())
    if (name == n.name) return n;
  throw InvalidArgument(std::string(name) + ": no number of the model");
}

/// @param text  NAME=VALUE
inline void set_number(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) throw InvalidArgument(std::string(text) + ": must be NAME=VALUE");
  number_named(text.substr(0, equals)).set(std::stod(std::string(text.substr(equals + 1))));
}

}  // namespace bouncelab::detection

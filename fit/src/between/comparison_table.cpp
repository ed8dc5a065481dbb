// SPDX-License-Identifier: GPL-3.0-or-later
#include <limits>

#include "bouncelab/fit/between_recordings.hpp"

namespace bouncelab::fit {

Table to_table(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings) {
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  const auto texts = [&](auto&& of) {
    std::vector<std::string> values;
    for (std::size_t k = 0; k < recordings.size(); ++k) values.push_back(of(k));
    return values;
  };
  const auto counts = [&](auto&& of) {
    std::vector<std::int64_t> values;
    for (std::size_t k = 0; k < recordings.size(); ++k) values.push_back(static_cast<std::int64_t>(of(k)));
    return values;
  };
  const auto reals = [&](auto&& of) {
    std::vector<double> values;
    for (std::size_t k = 0; k < recordings.size(); ++k) values.push_back(between.rows[k].is_used ? of(k) : kNotKnown);
    return values;
  };
  const auto& rows = between.rows;
  const auto summary = [&](std::size_t k) -> const RecordingSummary& { return recordings[k].summary; };
  const auto date = [&](std::size_t k) {
    const auto& known = recordings[k].origin.date;
    return known ? iso_in_words(*known) : std::string();
  };
  return Table{{{"recording", texts([&](std::size_t k) { return summary(k).recording; })},
                {"plate", texts([&](std::size_t k) { return recordings[k].origin.plate; })},
                {"date", texts(date)},
                {"n", counts([&](std::size_t k) { return summary(k).n; })},
                {"n_drops", counts([&](std::size_t k) { return summary(k).n_drops; })},
                {"n_left_out", counts([&](std::size_t k) { return summary(k).n_left_out; })},
                {"n_outliers", counts([&](std::size_t k) { return summary(k).n_outliers; })},
                {"scatter", reals([&](std::size_t k) { return summary(k).scatter; })},
                {"eps", reals([&](std::size_t k) { return rows[k].eps; })},
                {"sigma_eps", reals([&](std::size_t k) { return rows[k].se; })},
                {"offset", reals([&](std::size_t k) { return rows[k].offset; })},
                {"standardised", reals([&](std::size_t k) { return rows[k].standardised; })},
                {"p_value", reals([&](std::size_t k) { return rows[k].p_value; })},
                {"outlier", counts([&](std::size_t k) { return rows[k].is_outlier; })},
                {"message", texts([&](std::size_t k) { return summary(k).message; })}}};
}

}  // namespace bouncelab::fit

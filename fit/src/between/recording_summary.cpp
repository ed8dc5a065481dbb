// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "between/offset_model.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kDropsOfACovariance = 30;
constexpr std::size_t kWidthKnown = 30;  // samples; below, fit_law takes one term of the scatter without a choice

LawFitConfig config_of(const std::vector<double>& sorted_v_mps) {
  LawFitConfig config;
  config.intervals = IntervalMethod::covariance;
  config.node_speeds_mps = spread_speeds(sorted_v_mps, 3);
  if (sorted_v_mps.size() >= kWidthKnown) config.n_scatter_terms = 2;
  // the twentieths at either end may hold stray speeds, as for fit_law
  const std::size_t n = sorted_v_mps.size();
  if (sorted_v_mps[n - 1 - n / 20] < kOneSpeed * sorted_v_mps[n / 20]) {
    config.kind = LawKind::constant;
    config.node_speeds_mps = {sorted_v_mps[n / 2]};
  }
  return config;
}

void take_nodes(RecordingSummary& summary, const LawFit& fit) {
  summary.n_nodes = fit.nodes.size();
  for (std::size_t i = 0; i < summary.n_nodes; ++i) {
    summary.v_mps[i] = fit.nodes[i].v_mps;
    summary.eps[i] = fit.nodes[i].eps.value;
    for (std::size_t j = 0; j < summary.n_nodes; ++j) summary.covariance[i][j] = fit.node_covariance[i][j];
  }
}

}  // namespace

RecordingSummary summarize_recording(const RestitutionSamples& samples) {
  RecordingSummary summary;
  summary.recording = samples.front().recording;
  LeftOut left_out;
  RestitutionSamples used = *usable_samples(samples, left_out);
  summary.n_left_out = samples.size() - used.size();
  summary.n = used.size();
  std::set<std::int64_t> drops;
  std::vector<double> v_mps;
  for (const RestitutionSample& s : used) {
    drops.insert(s.drop);
    v_mps.push_back(s.v_mps);
  }
  summary.n_drops = drops.size();
  if (used.size() < kFewestOfASummary) {
    summary.why =
        Note{NoteKind::too_few_samples, {static_cast<double>(used.size()), static_cast<double>(kFewestOfASummary)}};
    return summary;
  }
  if (drops.size() < kDropsOfACovariance)
    for (RestitutionSample& s : used) s.drop = 0;
  std::sort(v_mps.begin(), v_mps.end());
  const LawFit fit = fit_law(used, config_of(v_mps));
  summary.n = fit.n;
  summary.n_outliers = fit.outliers.size();
  summary.status = fit.status == FitStatus::not_identifiable ? FitStatus::ok : fit.status;  // the curve is known
  if (summary.status != FitStatus::ok) {
    summary.why = fit.why;
    return summary;
  }
  const auto known = [](const NodeEstimate& node) { return node.eps.se && *node.eps.se > 0.0; };
  if (fit.nodes.empty() || !std::all_of(fit.nodes.begin(), fit.nodes.end(), known)) {
    summary.status = FitStatus::not_identifiable;
    summary.why = fit.why ? fit.why : Note{NoteKind::no_error_of_law};
    return summary;
  }
  take_nodes(summary, fit);
  if (!cholesky(covariance_of(summary))) {  // by whose inverse the values are weighted
    summary.status = FitStatus::not_identifiable;
    summary.why = Note{NoteKind::errors_tied};
  }
  if (fit.scatter) summary.scatter = fit.scatter->mean_distance(v_mps[v_mps.size() / 2]);
  return summary;
}

namespace {

constexpr double kSecondsOfDay = 86400.0;

/// A regular expression of a time of day, from group 5 on: the hour, then minutes and seconds without separators, then
/// minutes and seconds with them.
std::string time_with(const std::string& separators) {
  return "([01]\\d|2[0-3])(?:([0-5]\\d)([0-5]\\d|60)?|[" + separators + "]([0-5]\\d)(?:[" + separators +
         "]([0-5]\\d|60))?)";
}

/// @param found  year, separator, month, day, and maybe the time. @param more_s  added to the time
std::optional<RecordingDate> date_of(const std::cmatch& found, double more_s = 0.0) {
  constexpr int kFirstYear = 1990, kLastYear = 2100;
  const auto number = [&](std::size_t group) { return found[group].matched ? std::stoi(found[group]) : 0; };
  const std::chrono::year_month_day date{std::chrono::year(number(1)),
                                         std::chrono::month(static_cast<unsigned>(number(3))),
                                         std::chrono::day(static_cast<unsigned>(number(4)))};
  if (!date.ok() || number(1) < kFirstYear || number(1) > kLastYear) return std::nullopt;
  const std::int64_t day = std::chrono::sys_days(date).time_since_epoch().count();
  const double time_s = 3600.0 * number(5) + 60.0 * (number(6) + number(8)) + number(7) + number(9) + more_s;
  return RecordingDate{static_cast<double>(day) + (found[5].matched ? time_s / kSecondsOfDay : 0.5), day};
}

}  // namespace

std::optional<RecordingDate> date_from_iso(std::string_view text) {
  static const std::regex iso(R"((\d{4})(-?)(\d\d)\2(\d\d)(?:[T ])" + time_with(":") +
                              R"((?:[.,](\d*))?(?:Z|([+-])(\d\d):?(\d\d)?)?)?)");
  constexpr std::size_t kLongest = 64;  // std::regex takes stack for each character
  std::cmatch found;
  if (text.size() > kLongest || !std::regex_match(text.begin(), text.end(), found, iso)) return std::nullopt;
  const auto number = [&](std::size_t group) { return std::stod("0" + found[group].str()); };
  const double fraction_s = std::stod("0." + found[10].str() + "0"), zone_s = 3600.0 * number(12) + 60.0 * number(13);
  return date_of(found, fraction_s + (found[11] == "-" ? zone_s : -zone_s));
}

std::optional<RecordingDate> date_in_name(std::string_view name) {
  // 20261123999 is no date with a counter behind it but a number
  static const std::regex date(R"((\d{4})([-_]?)(\d\d)\2(\d\d)(?:[T _.-]?)" + time_with("-:._h") + R"((?!\d)|(?!\d)))");
  const auto is_digit = [&](std::size_t at) { return name[at] >= '0' && name[at] <= '9'; };
  std::cmatch found;
  for (std::size_t at = name.size(); at-- > 0;)
    if (is_digit(at) && (at == 0 || !is_digit(at - 1)) &&
        std::regex_search(name.data() + at, name.data() + name.size(), found, date,
                          std::regex_constants::match_continuous))
      if (const auto found_date = date_of(found)) return found_date;
  return std::nullopt;
}

std::string day_in_words(std::int64_t calendar_day) {
  const std::chrono::year_month_day date{std::chrono::sys_days(std::chrono::days(calendar_day))};
  return formatted("%04d-%02u-%02u", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                   static_cast<unsigned>(date.day()));
}

std::string iso_in_words(const RecordingDate& date) {
  const std::chrono::seconds seconds(std::llround(date.day * kSecondsOfDay));
  const auto day = std::chrono::floor<std::chrono::days>(seconds);
  const auto rest = static_cast<int>((seconds - day).count());
  return day_in_words(day.count()) + formatted("T%02d:%02d:%02d", rest / 3600, rest / 60 % 60, rest % 60);
}

namespace {

/// A spreadsheet computes a cell that begins with one of these; an apostrophe before it makes it a text.
std::string as_text(const std::string& name) {
  return !name.empty() && std::string_view("=+-@").find(name.front()) != std::string_view::npos ? "'" + name : name;
}

}  // namespace

Table to_table(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings) {
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  const auto column_of = [&]<class T>(T, auto&& of) {
    std::vector<T> values;
    for (std::size_t k = 0; k < recordings.size(); ++k) values.push_back(static_cast<T>(of(k)));
    return values;
  };
  const auto texts = [&](auto&& of) { return column_of(std::string(), of); };
  const auto counts = [&](auto&& of) { return column_of(std::int64_t{}, of); };
  const auto reals = [&](auto&& of) {
    return column_of(0.0, [&](std::size_t k) { return between.rows[k].is_used ? of(k) : kNotKnown; });
  };
  const auto& rows = between.rows;
  const auto summary = [&](std::size_t k) -> const RecordingSummary& { return recordings[k].summary; };
  const auto of_group = [&](auto&& of) {
    return column_of(0.0, [&](std::size_t k) {
      const std::string &plate = recordings[k].origin.plate, &name = plate.empty() ? summary(k).recording : plate;
      for (const GroupRestitution& group : between.groups)
        if (group.name == name || (plate.empty() && name.ends_with("/" + group.name))) return of(group);
      return kNotKnown;
    });
  };
  const auto date = [&](std::size_t k) {
    const auto& known = recordings[k].origin.date;
    return known ? iso_in_words(*known) : std::string();
  };
  return Table{{{"recording", texts([&](std::size_t k) { return as_text(summary(k).recording); })},
                {"plate", texts([&](std::size_t k) { return as_text(recordings[k].origin.plate); })},
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
                {"group_eps", of_group([](const GroupRestitution& g) { return g.eps.value; })},
                {"group_sigma_eps", of_group([](const GroupRestitution& g) { return *g.eps.se; })},
                {"group_lo95",
                 of_group([&](const GroupRestitution& g) { return g.prediction95 ? g.prediction95->lo : kNotKnown; })},
                {"group_hi95",
                 of_group([&](const GroupRestitution& g) { return g.prediction95 ? g.prediction95->hi : kNotKnown; })},
                {"outlier", counts([&](std::size_t k) { return rows[k].is_outlier; })},
                {"message", texts([&](std::size_t k) {
                   return summary(k).why ? std::string(to_string(summary(k).why->kind)) : std::string();
                 })}}};
}

}  // namespace bouncelab::fit

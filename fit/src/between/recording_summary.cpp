// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "between/speeds.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "law/law_model.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kDropsOfACovariance = 30;  // a covariance by M drops is wrong by about four values' share, 4/M
constexpr std::size_t kWidthKnown = 30;  // samples; below, fit_law takes one term of the scatter without a choice

/// Which samples are outliers, and how the others scatter.
LawFit scatter_about_law(const RestitutionSamples& samples, const std::pair<double, double>& speeds) {
  LawFitConfig config;
  config.intervals = IntervalMethod::covariance;
  if (samples.size() >= kWidthKnown) config.n_scatter_terms = 2;
  if (speeds.second < kOneSpeed * speeds.first) config.kind = LawKind::constant;
  return fit_law(samples, config);
}

/// The mean of eps as a polynomial in ln v, by weighted least squares.
struct Regression {
  double middle = 0.0;  ///< of ln v
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;

  Eigen::VectorXd row(double v_mps) const { return powers(log(v_mps) - middle, coefficients.size()); }
  static Eigen::VectorXd powers(double x, Eigen::Index n) {
    Eigen::VectorXd row = Eigen::VectorXd::Ones(n);
    for (Eigen::Index k = 1; k < n; ++k) row[k] = row[k - 1] * x;
    return row;
  }
};

/// Of a degree by which no law is seen to bend differently (eps ~ v^(-1/4) over a factor seven of speed: by 2e-5), or
/// of the highest that the speeds determine.
/// @param weights  inverse variances
std::optional<Regression> regression(const RestitutionSamples& samples, const Eigen::VectorXd& weights,
                                     const std::pair<double, double>& speeds) {
  constexpr double kDetermined = 1e-9;  // of the information, scaled
  const double ratio = speeds.second / speeds.first;
  Regression found{0.5 * log(speeds.first * speeds.second), {}, {}};
  for (Eigen::Index n = ratio < kOneSpeed ? 2 : ratio < 2.0 ? 3 : ratio < 4.0 ? 4 : 5; n > 0; --n) {
    Eigen::MatrixXd x(weights.size(), n);
    Eigen::VectorXd y(weights.size());
    for (Eigen::Index k = 0; k < weights.size(); ++k) {
      const RestitutionSample& s = samples[static_cast<std::size_t>(k)];
      x.row(k) = Regression::powers(log(s.v_mps) - found.middle, n).transpose();
      y[k] = s.eps;
    }
    const Eigen::MatrixXd weighted = weights.asDiagonal() * x;
    const Eigen::MatrixXd information = transposed_product(x, weighted);
    if (!(scaled_eigenvalues(information).minCoeff() > kDetermined)) continue;
    found.covariance = inverse(information);
    found.coefficients = product(found.covariance, transposed_product(weighted, y));
    const Eigen::VectorXd off = y - product(x, found.coefficients);
    DropNumbers drops;
    std::vector<Eigen::VectorXd> scores;
    for (Eigen::Index k = 0; k < weights.size(); ++k) {
      const std::size_t drop = drops.of(samples[static_cast<std::size_t>(k)]);
      if (drop == scores.size()) scores.emplace_back(Eigen::VectorXd::Zero(n));
      scores[drop] += off[k] * weighted.row(k).transpose();
    }
    if (scores.size() < kDropsOfACovariance) return found;
    const auto n_drops = static_cast<double>(scores.size());
    Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(n, n);
    for (const Eigen::VectorXd& score : scores) squares += score * score.transpose();
    found.covariance = n_drops / (n_drops - 1.0) * congruence(found.covariance, squares);
    return found;
  }
  return std::nullopt;
}

/// Numbers of the speeds of comparison nearest to the slowest and the fastest.
std::pair<int, int> comparison_speeds(const std::pair<double, double>& speeds) {
  return {static_cast<int>(std::lround(10.0 * log10(speeds.first))),
          static_cast<int>(std::lround(10.0 * log10(speeds.second)))};
}

}  // namespace

double comparison_speed_mps(int k) {
  static constexpr double kSeries[]{1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0};
  const int place = (k % 10 + 10) % 10;
  double v_mps = kSeries[place];
  for (int decade = (k - place) / 10; decade != 0; decade += decade < 0 ? 1 : -1)
    v_mps = decade < 0 ? v_mps / 10.0 : v_mps * 10.0;
  return v_mps;
}

std::vector<double> speeds_of_comparison(const RestitutionSamples& samples) {
  std::vector<double> v_mps = speeds_of(samples);
  std::sort(v_mps.begin(), v_mps.end());
  const std::size_t n = v_mps.size();
  // the twentieths at either end may hold stray speeds
  const auto [first, last] = comparison_speeds({v_mps[n / 20], v_mps[n - 1 - n / 20]});
  std::vector<double> speeds;
  for (int k = first; k <= last; ++k) speeds.push_back(comparison_speed_mps(k));
  return speeds;
}

RecordingSummary summarize_recording(const RestitutionSamples& samples) {
  RecordingSummary summary;
  summary.recording = samples.front().recording;
  LeftOut left_out;
  const PartOfSamples usable = usable_samples(samples, left_out);
  summary.n_left_out = samples.size() - usable->size();
  summary.n = usable->size();
  std::set<std::int64_t> drops;
  for (const RestitutionSample& s : *usable) drops.insert(s.drop);
  summary.n_drops = drops.size();
  if (summary.n < kFewestOfASummary) {
    summary.why =
        Note{NoteKind::too_few_samples, {static_cast<double>(summary.n), static_cast<double>(kFewestOfASummary)}};
    return summary;
  }
  const std::vector<double> speeds = speeds_of_comparison(*usable);
  const LawFit fit = scatter_about_law(*usable, {speeds.front(), speeds.back()});
  const PartOfSamples kept(*usable, fit.outliers);
  summary.n = kept->size();
  summary.n_outliers = fit.outliers.size();
  summary.status = FitStatus::not_identifiable;
  summary.why = fit.why ? fit.why : Note{NoteKind::no_error_of_law};
  if (!fit.scatter) return summary;
  Eigen::VectorXd weights(static_cast<Eigen::Index>(kept->size()));
  for (std::size_t k = 0; k < kept->size(); ++k) {
    const RestitutionSample& s = (*kept)[k];
    weights[static_cast<Eigen::Index>(k)] = 1.0 / (fit.scatter->variance(s.v_mps) + square(s.sigma_eps.value_or(0.0)));
  }
  const std::optional<Regression> found =
      weights.allFinite() ? regression(*kept, weights, {speeds.front(), speeds.back()}) : std::nullopt;
  if (!found) return summary;
  for (const double v_mps : speeds) {
    const Eigen::VectorXd row = found->row(v_mps);
    const double variance = congruence(row, found->covariance)(0, 0);
    if (!(variance > 0.0)) return summary;
    const double eps = hypot(row.dot(found->coefficients), std::sqrt(fit.scatter->variance(v_mps)));
    summary.nodes.push_back({v_mps, normal_estimate(eps, std::sqrt(variance))});
  }
  summary.status = FitStatus::ok;
  summary.why.reset();
  summary.scatter = fit.scatter->mean_distance(speeds[speeds.size() / 2]);
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
    return column_of(0.0, [&](std::size_t k) { return between.rows[k].why_not ? kNotKnown : of(k); });
  };
  const auto of_model = [&](double RecordingRow::*value) {
    return reals([&](std::size_t k) { return between.status == FitStatus::ok ? between.rows[k].*value : kNotKnown; });
  };
  const auto& rows = between.rows;
  const auto summary = [&](std::size_t k) -> const RecordingSummary& { return recordings[k].summary; };
  const auto of_group = [&](auto&& of) {
    return column_of(0.0, [&](std::size_t k) {
      const std::string &plate = recordings[k].origin.plate, &name = summary(k).recording;
      if (between.groups_differ())
        for (const GroupRestitution& group : between.differences->groups)
          if (group.name == plate || group.name == name || name.ends_with("/" + group.name)) return of(group);
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
                {"eps", of_model(&RecordingRow::eps)},
                {"sigma_eps", of_model(&RecordingRow::se)},
                {"offset", of_model(&RecordingRow::offset)},
                {"standardised", of_model(&RecordingRow::standardised)},
                {"p_value", of_model(&RecordingRow::p_value)},
                {"group_eps", of_group([](const GroupRestitution& g) { return g.eps.value; })},
                {"group_sigma_eps", of_group([](const GroupRestitution& g) { return *g.eps.se; })},
                {"group_lo95",
                 of_group([&](const GroupRestitution& g) { return g.prediction95 ? g.prediction95->lo : kNotKnown; })},
                {"group_hi95",
                 of_group([&](const GroupRestitution& g) { return g.prediction95 ? g.prediction95->hi : kNotKnown; })},
                {"outlier", counts([&](std::size_t k) { return rows[k].is_outlier; })},
                {"message", texts([&](std::size_t k) {
                   return rows[k].why_not ? std::string(to_string(rows[k].why_not->kind)) : std::string();
                 })}}};
}

}  // namespace bouncelab::fit

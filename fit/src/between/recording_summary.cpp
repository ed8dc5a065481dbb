// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
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
  if (fit.scatter) {
    const double v = v_mps[v_mps.size() / 2], below = fit.scatter->below(v), above = fit.scatter->above(v);
    summary.scatter = (below * below + above * above) / (below + above);
  }
  return summary;
}

namespace {

constexpr double kSecondsOfDay = 86400.0;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A text from left to right; what does not fit leaves the place where it is.
class Reader {
 public:
  Reader(std::string_view text, std::size_t at) : text_(text), at_(at) {}

  std::size_t at() const { return at_; }
  bool at_end() const { return at_ == text_.size(); }
  bool at_digit() const { return !at_end() && is_digit(text_[at_]); }
  std::optional<int> number(std::size_t n_digits) {
    if (at_ + n_digits > text_.size()) return std::nullopt;
    int value = 0;
    for (std::size_t k = at_; k < at_ + n_digits; ++k) {
      if (!is_digit(text_[k])) return std::nullopt;
      value = 10 * value + (text_[k] - '0');
    }
    at_ += n_digits;
    return value;
  }
  /// One of these characters. @return it, or 0
  char one_of(std::string_view characters) {
    if (at_end() || characters.find(text_[at_]) == std::string_view::npos) return '\0';
    return text_[at_++];
  }
  double fraction() {
    double value = 0.0, unit = 0.1;
    for (; at_digit(); unit *= 0.1) value += unit * (text_[at_++] - '0');
    return value;
  }

 private:
  std::string_view text_;
  std::size_t at_;
};

std::optional<std::int64_t> calendar_day(Reader& text, std::string_view separators) {
  constexpr int kFirstYear = 1990, kLastYear = 2100;
  const auto year = text.number(4);
  const char separator = year ? text.one_of(separators) : '\0';
  const auto month = year ? text.number(2) : year;
  if (!month || (separator != '\0' && text.one_of(std::string_view(&separator, 1)) == '\0')) return std::nullopt;
  const auto day = text.number(2);
  if (!day || *year < kFirstYear || *year > kLastYear) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

/// Seconds since midnight.
std::optional<double> time_of_day_s(Reader& text, std::string_view separators) {
  const auto hour = text.number(2);
  const char separator = hour ? text.one_of(separators) : '\0';
  const auto minute = hour ? text.number(2) : hour;
  if (!minute || *hour > 23 || *minute > 59) return std::nullopt;
  double second = 0.0;
  Reader rest = text;
  if (separator == '\0' || rest.one_of(separators) != '\0')
    if (const auto s = rest.number(2); s && *s < 61) {
      second = *s;
      text = rest;
    }
  return 3600.0 * *hour + 60.0 * *minute + second;
}

RecordingDate date_at(std::int64_t day, std::optional<double> time_s) {
  return {static_cast<double>(day) + time_s.value_or(0.5 * kSecondsOfDay) / kSecondsOfDay, day};
}

}  // namespace

std::optional<RecordingDate> date_from_iso(std::string_view text) {
  Reader reader(text, 0);
  const auto day = calendar_day(reader, "-");
  if (!day) return std::nullopt;
  if (reader.at_end()) return date_at(*day, std::nullopt);
  if (reader.one_of("T ") == '\0') return std::nullopt;
  auto time_s = time_of_day_s(reader, ":");
  if (!time_s) return std::nullopt;
  if (reader.one_of(".,") != '\0') *time_s += reader.fraction();
  if (const char sign = reader.one_of("Z+-"); sign == '+' || sign == '-') {
    const auto hours = reader.number(2);
    reader.one_of(":");
    const auto minutes = reader.at_end() ? std::optional(0) : reader.number(2);
    if (!hours || !minutes) return std::nullopt;
    *time_s -= (sign == '+' ? 1.0 : -1.0) * (3600.0 * *hours + 60.0 * *minutes);
  }
  if (!reader.at_end()) return std::nullopt;
  return date_at(*day, time_s);
}

std::optional<RecordingDate> date_in_name(std::string_view name) {
  for (std::size_t at = name.size(); at-- > 0;) {
    if (!is_digit(name[at]) || (at > 0 && is_digit(name[at - 1]))) continue;
    Reader date(name, at);
    const auto day = calendar_day(date, "-_");
    if (!day) continue;
    Reader time = date;
    const bool stands_apart = time.one_of("T _-.") != '\0';
    const auto time_s = time_of_day_s(time, ":-._h");
    // 20261123999 is no date with a counter behind it but a number
    const bool is_time = time_s && !time.at_digit();
    if (!is_time && !stands_apart && date.at_digit()) continue;
    return date_at(*day, is_time ? time_s : std::nullopt);
  }
  return std::nullopt;
}

std::string day_in_words(std::int64_t calendar_day) {
  const std::chrono::year_month_day date{std::chrono::sys_days(std::chrono::days(calendar_day))};
  return formatted("%04d-%02u-%02u", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                   static_cast<unsigned>(date.day()));
}

std::string iso_in_words(const RecordingDate& date) {
  const auto seconds = static_cast<std::int64_t>(std::llround(date.day * kSecondsOfDay));
  constexpr std::int64_t kDay_s = 86400;
  const std::int64_t day = (seconds - (seconds % kDay_s + kDay_s) % kDay_s) / kDay_s;
  const auto rest = static_cast<int>(seconds - day * kDay_s);
  return day_in_words(day) + formatted("T%02d:%02d:%02d", rest / 3600, rest / 60 % 60, rest % 60);
}

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
                {"message", texts([&](std::size_t k) {
                   return summary(k).why ? std::string(to_string(summary(k).why->kind)) : std::string();
                 })}}};
}

}  // namespace bouncelab::fit

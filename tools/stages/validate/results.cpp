// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/validate/results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/wave_preview.hpp"

namespace bouncelab::stages {
namespace {

/// Scores of the recordings of each value, the first ones of the lists in front: name, value, score.
struct FactorScore {
  std::string option, value;
  loop::DetectorScore score;
};

std::vector<FactorScore> factor_scores(const std::vector<loop::SweepAxis>& lists, const std::vector<Case>& cases,
                                       const DetectorResult& result) {
  std::vector<FactorScore> scores;
  for (const loop::SweepAxis& list : lists) {
    scores.push_back({list.option, list.values.front(), result.marks.front().score});
    for (std::size_t k = 0; k < cases.size(); ++k)
      if (!cases[k].settings.empty() && cases[k].settings.front().first == list.option)
        scores.push_back({list.option, cases[k].settings.front().second, result.marks[k].score});
  }
  return scores;
}

loop::DetectorScore score_of_all(const DetectorResult& result) {
  std::vector<loop::DetectorScore> scores;
  for (const Marks& marks : result.marks) scores.push_back(marks.score);
  return loop::pooled(scores);
}

std::string number(const std::optional<double>& value, double unit, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value / unit) : "-";
}

/// Both ends of a name: variants of a command differ there.
std::string shortened(const std::string& name) {
  constexpr std::size_t kMost = 27, kHead = 10;
  return name.size() <= kMost ? name : name.substr(0, kHead) + "..." + name.substr(name.size() - (kMost - kHead - 3));
}

Values times_of(const Onsets& onsets) {
  Values times;
  for (const Onset& onset : onsets) times.emplace_back(onset.t_s);
  return times;
}

}  // namespace

std::size_t n_failed(const DetectorResult& result) {
  return static_cast<std::size_t>(std::count_if(result.marks.begin(), result.marks.end(),
                                                [](const Marks& marks) { return !marks.failure.empty(); }));
}

std::vector<std::string> failures_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results) {
  std::vector<std::string> lines;
  for (const DetectorResult& result : results)
    for (std::size_t k = 0; k < cases.size(); ++k)
      if (!result.marks[k].failure.empty())
        lines.push_back(printable(result.name) + ", " + cases[k].name + ": " + result.marks[k].failure);
  return lines;
}

std::string heading(const std::string& first) {
  return fmt::format("{:<28}{:>7}{:>7}{:>7}{:>7}{:>11}{:>11}{:>10}{:>10}{:>9}{:>10}\n", first, "F 50ms", "F 5ms",
                     "F 1ms", "F .1ms", "recall 5ms", "jitter us", "x bound", "eps err", "pull", "x real t.");
}

std::string line_of(const std::string& name, const loop::DetectorScore& s) {
  const auto& a = s.agreement;
  return fmt::format("{:<28}{:>7}{:>7}{:>7}{:>7}{:>11}{:>11}{:>10}{:>10}{:>9}{:>10}\n", shortened(name),
                     number(a[0].f_measure(), 1.0, "{:.3f}"), number(a[1].f_measure(), 1.0, "{:.3f}"),
                     number(a[2].f_measure(), 1.0, "{:.3f}"), number(a[3].f_measure(), 1.0, "{:.3f}"),
                     number(a[1].recall(), 1.0, "{:.3f}"), number(s.within_drops_s, 1e-6, "{:.3g}"),
                     number(s.bound_ratio_within_drops, 1.0, "{:.3g}"), number(s.eps_error, 1.0, "{:.1e}"),
                     number(s.pull(), 1.0, "{:.2f}"), number(s.times_real_time(), 1.0, "{:.0f}"));
}

std::string text_of(const std::vector<Case>& cases, const std::vector<loop::SweepAxis>& lists,
                    const std::vector<DetectorResult>& results) {
  std::string text = heading(fmt::format("{} recording{}", cases.size(), cases.size() == 1 ? "" : "s"));
  for (const DetectorResult& result : results) text += line_of(result.name, score_of_all(result));
  for (const DetectorResult& result : results)
    if (const std::optional<double> rate = score_of_all(result).invented_per_hour())
      text += fmt::format("{}: {:.3g} onsets an hour where no ball is\n", result.name, *rate);
  for (const DetectorResult& result : results)
    if (const std::size_t n = n_failed(result); n > 0)
      text += fmt::format("{}: failed in {} of {} recordings, whose impacts count as missed\n", result.name, n,
                          cases.size());
  if (!lists.empty())
    for (const DetectorResult& result : results) {
      text += "\n" + heading(shortened(result.name));
      for (const FactorScore& f : factor_scores(lists, cases, result))
        text += line_of("  " + f.option + " " + f.value, f.score);
    }
  return text;
}

Table table_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results) {
  std::vector<std::string> detectors, recordings, settings, failures;
  std::vector<loop::DetectorScore> scores;
  for (const DetectorResult& result : results)
    for (std::size_t k = 0; k < cases.size(); ++k) {
      detectors.push_back(result.name);
      recordings.push_back(cases[k].name);
      settings.push_back(loop::text_of(cases[k].settings));
      failures.push_back(result.marks[k].failure);
      scores.push_back(result.marks[k].score);
    }
  Table table{
      {{"detector", std::move(detectors)}, {"recording", std::move(recordings)}, {"setting", std::move(settings)}}};
  for (const Member& member : members_of(static_cast<const loop::DetectorScore*>(nullptr))) {
    std::vector<double> cells;
    for (const loop::DetectorScore& score : scores) {
      const Value value = member.get(&score);
      const auto* count = std::get_if<std::uint64_t>(&value);
      const auto* real = std::get_if<double>(&value);
      cells.push_back(count != nullptr ? static_cast<double>(*count) : real != nullptr ? *real : std::nan(""));
    }
    table.columns.push_back({std::string(member.name), std::move(cells)});
  }
  table.columns.push_back({"failure", std::move(failures)});
  return table;
}

Object object_of_result(const std::vector<Case>& cases, const std::vector<loop::SweepAxis>& lists,
                        const DetectorResult& result) {
  Values factors, recordings;
  for (const FactorScore& f : factor_scores(lists, cases, result))
    factors.emplace_back(Object{{"option", f.option}, {"value", f.value}, {"score", value_of(f.score)}});
  for (std::size_t k = 0; k < cases.size(); ++k)
    recordings.emplace_back(Object{{"recording", cases[k].name},
                                   {"setting", loop::text_of(cases[k].settings)},
                                   {"score", value_of(result.marks[k].score)},
                                   {"failure", result.marks[k].failure}});
  return {{"detector", result.name},
          {"n_failed", value_of(n_failed(result))},
          {"all", value_of(score_of_all(result))},
          {"factors", std::move(factors)},
          {"recordings", std::move(recordings)}};
}

Values worst_of(const std::vector<Case>& cases, const std::vector<loop::TrueTimes>& truths,
                const DetectorResult& result) {
  constexpr std::size_t kShown = 3;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < cases.size(); ++k)
    if (const std::optional<double> f = result.marks[k].score.agreement[1].f_measure();
        f && *f < 1.0 && result.marks[k].failure.empty())
      order.emplace_back(*f, k);
  std::stable_sort(order.begin(), order.end());
  order.resize(std::min(order.size(), kShown));
  Values worst;
  for (const auto& [f, k] : order) {
    detection::WavePreview wave = detection::wave_preview(cases[k].sound, 0, {});
    wave.copy = {};
    worst.emplace_back(Object{{"recording", cases[k].name},
                              {"f", f},
                              {"wave", value_of(wave)},
                              {"true_s", times_of(truths[k].onsets)},
                              {"marked_s", times_of(result.marks[k].onsets)}});
  }
  return worst;
}

}  // namespace bouncelab::stages

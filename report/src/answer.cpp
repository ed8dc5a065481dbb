// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/answer.hpp"

#include <algorithm>
#include <cctype>

#include "words.hpp"

namespace bouncelab::report {

FitInWords in_words(const fit::FitResult& result, const RestitutionSamples& samples, fit::UseMemory memory) {
  FitInWords words{plain_answer(result, samples), {}, {}, {}, findings_of(result)};
  words.causes = causes_of(result, words.answer, samples);
  warn(result, samples, words);
  if (memory == fit::UseMemory::always && result.memory && !result.memory->holds)
    words.warnings.insert(words.warnings.begin(), in_words(*result.memory));
  return words;
}

void choose_doubt(const std::vector<std::string>& warnings, FitInWords& words) {
  const auto first = std::find_if(warnings.begin(), warnings.end(), [&](const std::string& warning) {
    return words.answer.at || warning.find("do not agree") == std::string::npos;  // which the answer says
  });
  if (first == warnings.end() || words.answer.sentences.empty()) return;
  std::string& doubt = words.answer.doubt = *first;
  if (const auto flag = doubt.find(" (flag "); flag != std::string::npos)  // which is in the tables only
    doubt.erase(flag, doubt.find(')', flag) + 1 - flag);
  const bool begins_with_file = doubt.substr(0, doubt.find_first_of(" :")).find('.') != std::string::npos;
  if (!begins_with_file) doubt.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(doubt.front())));
  if (doubt.back() != '.' && doubt.back() != '?') doubt += '.';
}

void withhold_answer(const std::string& why, FitInWords& words) {
  PlainAnswer none;
  none.seen = words.answer.seen;
  none.sentences = {why + "."};
  std::string& sentence = none.sentences.front();
  sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
  words.answer = std::move(none);
  words.causes.clear();
}

void keep_three(std::vector<std::string>& warnings, FitInWords& words) {
  if (warnings.size() <= kMostWarnings) return;
  words.details.insert(words.details.begin(), warnings.begin() + kMostWarnings, warnings.end());
  warnings.resize(kMostWarnings);
  std::erase_if(words.warnings, [&](const std::string& one) {
    return std::find(warnings.begin(), warnings.end(), one) == warnings.end();
  });
}

const Description& members_of(const DropsSeen*) {
  using D = DropsSeen;
  static const Description all{
      result("n_drops", &D::n_drops, "Drops"),
      result("n_impacts", &D::n_impacts, "Impacts; `null` where the samples' times are not known"),
      result("duration_s", &D::duration_s, "From first to last impact, of several drops the sum"),
      result("drop_height_m", &D::drop_height_m,
             "Height of the release, by the speed of the first impact and the drag of the ball; that speed is the one "
             "at which the flight after it began, over ε. Median of the `n_heights` drops whose first impact was seen, "
             "that is, where one bounce before it would lie within the recording and after any other drop, and no "
             "later flight rose higher"),
      result("drop_height_ci95_m", &D::drop_height_ci95_m,
             "Its 95 % interval, of several drops that of one; not below the rise of any flight; `null` of a height "
             "that was given, and of different heights"),
      result("drop_heights_m", &D::drop_heights_m,
             "Least and greatest height, where drops of different heights are among them: the median then lies "
             "outside of the interval of one of them; else `null`"),
      result("n_heights", &D::n_heights, "Drops with a height")};
  return all;
}

const Description& members_of(const SpeedAndRestitution*) {
  using S = SpeedAndRestitution;
  static const Description all{
      result("v_mps", &S::v_mps, "Speed"), result("eps", path(&S::eps, &fit::Estimate::value), "ε there"),
      result("se", path(&S::eps, &fit::Estimate::se), "Its standard error"),
      result("ci95", path(&S::eps, &fit::Estimate::ci95), "Its 95 % interval"),
      result("energy_lost", &S::energy_lost,
             "1 - ⟨ε²⟩, share of the energy of the vertical motion; `eps` is the peak of p(ε)")};
  return all;
}

const Description& members_of(const RecordingAnswer*) {
  using R = RecordingAnswer;
  static const Description all{
      result("recording", &R::recording, "Its name"), result("at", &R::at, "At a speed common to most"),
      result("missing", &R::missing, "Why `at` is `null`"), result("seen", &R::seen, "Of its drops")};
  return all;
}

const Description& members_of(const PlainAnswer*) {
  using A = PlainAnswer;
  static const Description all{
      result("sentences", &A::sentences,
             "Texts, most important first: what `fit` and `analyze` print first and the report begins with"),
      result("doubt", &A::doubt, "What makes it uncertain, a sentence or empty"),
      result("at", &A::at,
             "`null` (nothing could be fitted, or recordings do not agree), or ε at the node in the middle, see "
             "below"),
      result("elsewhere", &A::elsewhere,
             "The same at the greatest and the least node, each where the 95 % interval of the difference from `at` "
             "leaves 0 out"),
      result("one_value", &A::one_value, "One speed alone, or too few samples for a curve"),
      result("with_memory", &A::with_memory, "The values are those of `memory`, which holds"),
      result("seen", &A::seen, "Of the samples' drops, see below"),
      result("recordings", &A::recordings,
             "`[{recording, at, missing, seen}]`, each alone, at a speed common to most; `missing` says why `at` is "
             "`null`; empty where there is one recording")};
  return all;
}

const Description& members_of(const Cause*) {
  using C = Cause;
  static const Description all{
      result("name", &C::name, "`speed`, `air` or `roughness`"),
      result("size", &C::size,
             "How much it changes ε in these data: from the least to the greatest node; by the air, likewise, in the "
             "intervals; the width of the band that holds two thirds of the bounces. `null`: not known"),
      result("is_seen", &C::is_seen, "The data show it, or the named ball tells it"),
      result("sentence", &C::sentence, "In words")};
  return all;
}

const Description& members_of(const Finding*) {
  static const Description all{result("question", &Finding::question, "Question of a reader"),
                               result("answer", &Finding::answer, "Its answer from the numbers")};
  return all;
}

const Description& members_of(const FitInWords*) {
  using W = FitInWords;
  static const Description all{
      result("answer", &W::answer, "The result for somebody who dropped a ball, see [below](#answer)"),
      result("warnings", &W::warnings, "Texts: what may make another answer, at most three"),
      result("details", &W::details, "Texts: what else is to be said, of the constants for instance"),
      result("causes", &W::causes, "Why ε is not the same at every bounce: three, the largest first, see below"),
      result(
          "answers", &W::findings,
          "`[{question, answer}]`: five questions of a reader, with several recordings and with a fit with memory one "
          "more each, answered from the numbers")};
  return all;
}

Object object_of(const fit::FitResult& result, const FitInWords& words) {
  Object all = bouncelab::object_of(members_of(&words), &words);
  append(all, bouncelab::object_of(members_of(&result), &result));
  return all;
}

Object object_of(const fit::RoughnessResult& result, const std::vector<std::string>& warnings) {
  Object all = bouncelab::object_of(members_of(&result), &result);
  all.emplace_back("warnings", value_of(warnings));
  return all;
}

}  // namespace bouncelab::report

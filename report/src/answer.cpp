// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/answer.hpp"

#include <algorithm>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/text.hpp"

#include "words.hpp"

namespace bouncelab::report {

FitInWords in_words(const fit::FitResult& result, const RestitutionSamples& samples, fit::UseMemory memory) {
  const SampleConditions conditions = samples.empty() ? SampleConditions{} : samples.front().conditions;
  FitInWords words{plain_answer(result, samples),
                   samples.empty() ? std::vector<Taken>{} : taken_of(conditions),
                   notes_of(result, samples, memory),
                   {},
                   findings_of(result, conditions)};
  words.causes = causes_of(result, words.answer, samples);
  take(words.notes, words);
  return words;
}

std::vector<Taken> taken_of(const SampleConditions& of) {
  std::vector<Taken> taken{{"ball", of.ball ? to_text(*of.ball) : "not known"},
                           {"plate", of.plate ? plate_text(*of.plate) : "not known"}};
  if (of.gravity_mps2) taken.push_back({"gravity", formatted("%.6g m/s^2", *of.gravity_mps2)});
  if (of.of_flights())
    taken.push_back(
        {"air", of.drag_corrected ? "none" : formatted("%.4g kg/m^3", of.air_kgpm3.value_or(Air{}.density_kgpm3))});
  return taken;
}

std::vector<Taken> taken_of(const detection::RecordingDetection& recording) {
  const detection::RecordingSummary& of = recording.found.summary;
  std::vector<Taken> taken;
  if (of.n_tracks > 1) taken.push_back({"track", formatted("%d of %d", of.track, of.n_tracks)});
  if (of.n_channels > 1)
    taken.push_back({"channel", formatted("%d of %d (", of.channel, of.n_channels) + of.channel_reason + ")"});
  return taken;
}

std::string in_words(const std::vector<Taken>& taken) {
  std::string text;
  for (const Taken& one : taken) text += (text.empty() ? "Taken: " : ", ") + one.what + " " + one.value;
  return text.empty() ? text : text + ".";
}

void take(const std::vector<Note>& notes, FitInWords& words) {
  PlainAnswer& answer = words.answer;
  if (!notes.empty() && severity_of(notes.front().kind) == Severity::no_answer) {
    PlainAnswer none;
    none.seen = answer.seen;
    none.sentences = {as_sentence(notes.front())};
    answer = std::move(none);
    words.causes.clear();
    return;
  }
  const auto first = std::find_if(notes.begin(), notes.end(), [&](const Note& note) {
    const bool is_said = !answer.at && note.kind == NoteKind::recordings_differ && note.recording.empty();
    return (severity_of(note.kind) == Severity::warning && !is_said) || note.kind == NoteKind::uncertain_air ||
           note.kind == NoteKind::uncertain_contact;
  });
  if (first != notes.end() && !answer.sentences.empty()) answer.doubt = as_sentence(*first);
}

Description members_of(const Taken*) {
  static constexpr Member all[]{member<&Taken::what>("what", "The option that gives it"),
                                member<&Taken::value>("value", "In words, `not known` where nothing is")};
  return all;
}

Description members_of(const DropsSeen*) {
  using D = DropsSeen;
  static constexpr Member all[]{
      member<&D::n_drops>("n_drops", "Drops"),
      member<&D::n_impacts>("n_impacts", "Impacts; `null` where the samples' times are not known"),
      member<&D::duration_s>("duration_s", "From first to last impact, of several drops the sum"),
      member<&D::drop_height_m>(
          "drop_height_m",
          "Height of the release, by the speed of the first impact and the drag of the ball; that speed is the one "
          "at which the flight after it began, over ε. Median of the `n_heights` drops whose first impact was seen, "
          "that is, where one bounce before it would lie within the recording and after any other drop, and no "
          "later flight rose higher"),
      member<&D::drop_height_ci95_m>(
          "drop_height_ci95_m",
          "Its 95 % interval, of several drops that of one; not below the rise of any flight; `null` of a height "
          "that was given, and of different heights"),
      member<&D::drop_heights_m>(
          "drop_heights_m",
          "Least and greatest height, where drops of different heights are among them: the median then lies "
          "outside of the interval of one of them; else `null`"),
      member<&D::n_heights>("n_heights", "Drops with a height")};
  return all;
}

Description members_of(const SpeedAndRestitution*) {
  using S = SpeedAndRestitution;
  static constexpr Member all[]{
      member<&S::v_mps>("v_mps", "Speed"),
      member<&S::eps, &fit::Estimate::value>("eps", "ε there, root mean square over bounces: √⟨ε²⟩"),
      member<&S::eps, &fit::Estimate::se>("se", "Its standard error"),
      member<&S::eps, &fit::Estimate::ci95>("ci95", "Its 95 % interval"),
      member<&S::energy_lost>("energy_lost", "1 - ε², share of the energy of the vertical motion")};
  return all;
}

Description members_of(const RecordingAnswer*) {
  using R = RecordingAnswer;
  static constexpr Member all[]{
      member<&R::recording>("recording", "Its name"), member<&R::at>("at", "At a speed common to most"),
      member<&R::missing>("missing", "Why `at` is `null`"), member<&R::seen>("seen", "Of its drops")};
  return all;
}

Description members_of(const PlainAnswer*) {
  using A = PlainAnswer;
  static constexpr Member all[]{
      member<&A::sentences>(
          "sentences", "Texts, most important first: what `fit` and `analyze` print first and the report begins with"),
      member<&A::doubt>("doubt", "What makes it uncertain, a sentence or empty"),
      member<&A::at>(
          "at",
          "`null` (nothing could be fitted, or recordings do not agree), or ε at the node in the middle, where ε "
          "steps there at another, see below"),
      member<&A::elsewhere>("elsewhere",
                            "The same at the greatest and the least speed, each where the 95 % interval of the "
                            "difference from the middle "
                            "node leaves 0 out; none where ε steps"),
      member<&A::one_value>("one_value", "One speed alone"),
      member<&A::seen>("seen", "Of the samples' drops, see below"),
      member<&A::recordings>(
          "recordings",
          "`[{recording, at, missing, seen}]`, each alone, at a speed common to most; `missing` says why `at` is "
          "`null`; empty where there is one recording")};
  return all;
}

Description members_of(const Cause*) {
  using C = Cause;
  static constexpr Member all[]{
      member<&C::name>("name", "`speed`, `air` or `roughness`"),
      member<&C::size>(
          "size",
          "How much it changes ε in these data: from the least to the greatest speed; by the air, likewise, in the "
          "intervals; the width of the band that holds two thirds of the bounces. `null`: not known"),
      member<&C::is_seen>("is_seen", "The data show it, or the named ball tells it"),
      member<&C::sentence>("sentence", "In words")};
  return all;
}

Description members_of(const Finding*) {
  static constexpr Member all[]{member<&Finding::question>("question", "Question of a reader"),
                                member<&Finding::answer>("answer", "Its answer from the numbers")};
  return all;
}

Description members_of(const FitInWords*) {
  using W = FitInWords;
  static constexpr Member all[]{
      member<&W::answer>("answer", "The result for somebody who dropped a ball, see [below](#answer)"),
      member<&W::taken>("taken",
                        "`[{what, value}]`: what enters the numbers and did not stand on the command line, defaults "
                        "and what files say"),
      computed(
          "notes", [](const W& w) { return values_of(w.notes); },
          "`[{kind, severity, text}]`, the most severe first: what a user should know, see [notes](#notes)"),
      member<&W::causes>("causes", "Why ε is not the same at every bounce: three, the largest first, see below"),
      member<&W::findings>(
          "answers",
          "`[{question, answer}]`: five questions of a reader, with several recordings and with a fit with memory one "
          "more each, answered from the numbers")};
  return all;
}

Object object_of(const fit::FitResult& result, const FitInWords& words) {
  Object all = bouncelab::object_of(words);
  append(all, bouncelab::object_of(result));
  return all;
}

Object object_of(const fit::RoughnessResult& result, const std::vector<Note>& notes) {
  Object all = bouncelab::object_of(result);
  all.emplace_back("notes", values_of(notes));
  return all;
}

}  // namespace bouncelab::report

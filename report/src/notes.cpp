// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/notes.hpp"

#include <algorithm>
#include <cctype>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::report {
namespace {

/// {0} is the first number, {0:.2g} as printf writes it, {0|is|are} the word for one and for others, {s} the subject.
struct Wording {
  NoteKind kind;
  Severity severity;
  std::string_view words;
};
using enum Severity;
using Kind = NoteKind;
constexpr Wording kWordings[]{
    {Kind::no_ball_likely, no_answer,
     "no ε is stated: a bouncing ball is only {0:.1f} times as likely as another sound; listen to the recording "
     "from {1:.1f} s on"},
    {Kind::silence, warning, "no sound is louder than the noise; record nearer to where the ball lands"},
    {Kind::no_three_bounces, warning,
     "only {0} {0|sound|sounds} like an impact {0|was|were} heard, and three bounces in a row are needed; "
     "drop the ball from higher"},
    {Kind::sounds_not_of_ball, warning,
     "{0} sounds like impacts were heard, but no three of them follow each other as a ball's bounces do; drop "
     "one ball, and let it bounce until it rests"},
    {Kind::drops_too_short, warning,
     "{0} {0|drop has|drops have} fewer than {1} impacts and {0|is|are} left out (--min-impacts takes shorter drops)"},
    {Kind::eps_impossible, warning,
     "{0} of {1} samples {0|has|have} ε below 0 or above 1; check the order of the times, the columns and their units"},
    {Kind::odd_speeds, warning,
     "{0} of {1} speeds {0|is|are} not between 0.005 and 20 m/s; check that the {s}, and gravity in m/s^2"},
    {Kind::contradicted_height, warning,
     "the drop height of {0:.4g} m (--drop-height) does not fit {1} of {2} {2|drop|drops}, whose flights suggest "
     "{3:.2g} m; check the height. Their first impact is left out"},
    {Kind::recording_left_out, warning, "{s}; left out"},
    {Kind::recordings_differ, warning,
     "the {0} {2|recordings|plates} differ by more than chance (p = {1:.2g}): {s}; use the value of each, "
     "since the errors of a common value are too small"},
    {Kind::two_kinds_of_drops, warning, "the drops are of two kinds: ε is about {s}. Two balls, or two floors?"},
    {Kind::doubtful_drops, warning,
     "{0} of {1} drops {0|is|are} doubtful (a bouncing ball is less than {2} times as likely as another sound): "
     "{s}; {0|it is|they are} used, listen there"},
    {Kind::balls_at_once, warning,
     "{0} balls bounce at the same time from {1:.1f} s on, each a drop of its own: in the median {s}"},
    {Kind::other_ball, warning,
     "{s}; the samples keep the corrections for their own ball; compute the samples again with the new ball"},
    {Kind::mixed_conditions, warning,
     "{0} of the samples were computed for another ball, gravity, correction or wave speed than the first "
     "sample, and are treated like it; fit them apart"},
    {Kind::no_ball_named, warning,
     "{s} no ball: air drag and contact time are corrected in the other recordings only; name the ball "
     "(--ball)"},
    {Kind::other_conditions, warning,
     "{s} of another ball, plate, gravity or correction than the first: a difference may come from that; "
     "compare like with like"},
    {Kind::repeated_drops, warning,
     "{s} ({0} bounces): is it the same drop twice? Leave copies out, since copies make the errors too small"},
    {Kind::renamed_recordings, warning,
     "{s}: the names of {0} {0|recording|recordings} are in another file too; they count as other recordings, "
     "and the file's name is added to theirs"},
    {Kind::same_content, warning, "{s} (by content); it is counted once"},
    {Kind::many_intervals_odd, warning,
     "{0} of {1} bounces {0|is|are} left out: the time between their impacts is too long or too short, as if an "
     "impact were missing or false; check the times there"},
    {Kind::rows_left_out, warning, "{0} {0|sample is|samples are} left out ({s}); check sample {1}, the first of them"},
    {Kind::outliers, warning,
     "{0} {0|bounce is|bounces are} left out, too far from the curve ε(v); check the times there for missing "
     "or false impacts"},
    {Kind::gaps_of_time, warning,
     "the recording has {0} {0|gap|gaps} between impacts of a drop (by its time stamps), where impacts may be "
     "missing; record without interruption"},
    {Kind::improbable_impacts, warning,
     "{0} of {1} impacts {0|is|are} probably not the ball's; no ε is taken from them"},
    {Kind::memory_fails, warning, "{s}"},
    {Kind::drops_differ, warning,
     "the {0} drops differ by more ({1:.2g} in ε) than the bounces of one drop ({2:.2g}): another ball, spot "
     "or release? More drops make the interval narrower"},
    {Kind::scatter_not_as_fitted, warning,
     "the scatter of ε is not as the fit assumes (χ²/ndf = {0:.2f}, p = {1:.1e}); {s}"},
    {Kind::timing_too_large, warning,
     "ε scatters only {0:.2f} times as much as the stated timing errors alone predict: these are too large, "
     "and so are the errors given here; state smaller ones"},
    {Kind::timing_not_as_stated, warning,
     "neighbouring samples show timing errors of {0:.2g} us, but {1:.2g} us are stated; check the stated "
     "timing errors"},
    {Kind::lossy_coding, warning,
     "lossy coding ({s}): times may be off by more than their stated errors; record as WAV or FLAC"},
    {Kind::clipped, warning, "{0} of {1} impacts {0|is|are} clipped: record with less gain"},
    {Kind::of_file, warning, "{s}"},
    {Kind::beyond_speeds, warning, "ε at {0:.3g} m/s is extrapolated: the measured speeds are {1:.3g} to {2:.3g} m/s"},
    {Kind::track_taken, warning, "audio track {0} of {1} (counted from 0) is used (--track takes another)"},
    {Kind::low_band, detail,
     "the times come from the sound below {0} Hz, where the impacts are clearest; they are less exact than "
     "times from all frequencies"},
    {Kind::several_places, detail,
     "{0} of the {1} impacts found have more than one possible time; their errors include this"},
    {Kind::modes_left_out, warning,
     "{0} modes of vibration from {1:.0f} to {2:.0f} Hz are left out, too high for a sampling rate of {3:.0f} "
     "Hz"},
    {Kind::synthetic_clipped, warning, "{0} {0|impact is|impacts are} clipped at full scale"},
    {Kind::drops_left_plate, warning, "{0} {0|drop|drops} ended early: the ball left the plate"},
    {Kind::impacts_with_gain, warning,
     "in {0} of {1} impacts the ball gained energy, in all {2:.4g} of the energy at release; the contact "
     "model allows it"},
    {Kind::uncertain_air, detail, "most of the uncertainty comes from how strongly the air slows the ball: {s}"},
    {Kind::uncertain_contact, detail, "most of the uncertainty comes from how long the ball touches the floor: {s}"},
    {Kind::law_contradicted, detail,
     "the law does not describe these bounces: at {0:.2g} m/s the curve is off by {1:+.2g} in ε (ln of the "
     "Bayes factor: {2:.0f}); use the curve, not the constants"},
    {Kind::too_few_samples, detail, "{0} usable {0|sample|samples}: at least {1} are needed"},
    {Kind::not_a_sphere, detail,
     "the median ε is not between 0.05 and 1: the law of viscoelastic spheres does not apply"},
    {Kind::not_converged, detail, "the fit did not converge: the log-likelihood could still rise by {0:.3g}"},
    {Kind::not_identifiable, detail,
     "these {0} impacts do not determine the constants of the law (95 % intervals: {s}); use the curve ε(v)"},
    {Kind::one_speed, detail,
     "all speeds are between {0:.3g} and {1:.3g} m/s: there is one ε, at that speed; drop from several "
     "heights to see more"},
    {Kind::two_terms, detail, "{0} samples are too few for more than two terms of the law"},
    {Kind::one_constant, detail, "{0} samples are too few for a law: one ε is fitted to all speeds"},
    {Kind::few_drops, detail,
     "{s}: standard errors of constants and slopes of p(ε) assume independent impacts, those of slopes may be "
     "1.7 times too small at low speeds; record 10 drops or more"},
    {Kind::errors_not_stated, detail,
     "{0} of {1} samples {0|states|state} no timing error: it counts as scatter of ε there"},
    {Kind::memory_without_ball, detail,
     "no ball is named: the fit with memory assumes a solid sphere (J = {0:.3g} m R^2) with a radius of "
     "{1:.3g} m; name the ball (--ball)"},
    {Kind::memory_without_law, detail, "there is no law to start from"},
    {Kind::memory_too_few, detail,
     "the fit with memory needs at least {0} impacts, and a drop with at least {1} impacts in a row"},
    {Kind::memory_not_converged, detail,
     "the search for the most likely parameters did not converge: these fluctuations are not those of a rough "
     "ball with memory"},
    {Kind::memory_without_errors, detail,
     "the errors of the most likely parameters could not be found: too few draws from the posterior have "
     "weight"},
    {Kind::memory_transforms, detail,
     "the impacts do not scatter as the model assumes (Anderson-Darling test of the probability transforms, p "
     "= {0:.2g})"},
    {Kind::memory_mechanism, detail, "the offset and the width of the scatter need different roughness (p = {0:.2g})"},
    {Kind::memory_by_speed, detail, "slow impacts and fast impacts need different roughness (p = {0:.2g})"},
    {Kind::memory_between_drops, detail,
     "the drops differ by more than the scatter of their impacts explains (p = {0:.2g})"},
    {Kind::memory_unlikelier, detail, "a model of independent impacts is more likely than the memory of a rough ball"},
    {Kind::too_few_recordings, detail,
     "{0} of {1} {1|recording has|recordings have} enough samples at a common speed; ε of all needs {2} "
     "such recordings, a comparison needs 2"},
    {Kind::speed_not_reached, detail,
     "its bounces are of {1:.3g} to {2:.3g} m/s; the recordings are compared at {0:.3g} m/s"},
    {Kind::plates_not_in_model, detail,
     "{0} plates in {1} recordings: too few recordings of each plate to tell plates from recordings; the "
     "plates are taken together"},
    {Kind::plates_are_days, detail,
     "each plate has a day of its own, so plates and days cannot be told apart; measure several plates on one "
     "day"},
    {Kind::few_days, detail,
     "{0} days are too few to know how much ε differs from day to day; the error of the drift assumes that it "
     "does not"},
    {Kind::dates_missing, detail, "{0} of {1} recordings have no date and do not count for the drift"},
    {Kind::one_date, detail, "all recordings have the same date: a drift cannot be seen"},
    {Kind::plates_are_times, detail,
     "{s} were measured one after the other, so what they differ by and a drift can hardly be told apart; measure the "
     "plates in turn, or state the times if they were (--groups)"},
    {Kind::rows_without_samples, warning, "{s}"},
    {Kind::no_row, warning, "{s}"},
    {Kind::group_too_small, detail, "{s} has {0} usable {0|sample|samples}: at least {1} are needed"},
    {Kind::no_common_speeds, detail,
     "the recordings have no common speeds: one ends at {0:.2g} m/s, another begins at {1:.2g} m/s; drop from the "
     "same heights"},
    {Kind::no_error_of_law, detail, "ε of this recording has no standard error"},
    {Kind::detector_failed, warning, "{s}"}};

const Wording& wording_of(NoteKind kind) {
  return *std::find_if(std::begin(kWordings), std::end(kWordings),
                       [kind](const Wording& wording) { return wording.kind == kind; });
}

/// What stands between { and }.
std::string filled(std::string_view place, const Note& note) {
  if (place == "s") return note.subject;
  const double number = note.numbers.at(static_cast<std::size_t>(place.front() - '0'));
  if (place.size() == 1) return formatted("%.10g", number);
  if (place[1] == ':') return formatted(("%" + std::string(place.substr(2))).c_str(), number);
  const std::size_t others = place.find('|', 2);
  return std::string(number == 1.0 ? place.substr(2, others - 2) : place.substr(others + 1));
}

/// A recording's name for people.
std::string name_of(const detection::RecordingDetection& r) { return printable(input_name(r.recording)); }

}  // namespace

Severity severity_of(NoteKind kind) { return wording_of(kind).severity; }

/// The words with what `fill` makes of each place.
template <class Fill>
static std::string filled_words(std::string_view words, Fill fill) {
  std::string text;
  while (true) {
    const std::size_t begin = words.find('{');
    text += words.substr(0, begin);
    if (begin == std::string_view::npos) return text;
    const std::size_t end = words.find('}', begin);
    text += fill(words.substr(begin + 1, end - begin - 1));
    words.remove_prefix(end + 1);
  }
}

std::string in_words(const Note& note) {
  return filled_words(wording_of(note.kind).words, [&](std::string_view place) { return filled(place, note); });
}

std::string pattern_of(NoteKind kind) {
  return filled_words(wording_of(kind).words, [](std::string_view place) {
    return place.size() > 1 && place[1] == '|' ? std::string(place.substr(place.find('|', 2) + 1)) : "...";
  });
}

/// With the recording before it, where it does not begin with that.
static std::string with_recording(const Note& note, const std::string& text) {
  const std::string name = note.recording + ": ";
  return note.recording.empty() || text.starts_with(name) ? text : name + text;
}

std::string as_sentence(const Note& note) {
  std::string text = in_words(note);
  const bool begins_with_file = text.substr(0, text.find_first_of(" :")).find('.') != std::string::npos;
  if (!begins_with_file) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  if (text.back() != '.' && text.back() != '?') text += '.';
  return with_recording(note, text);
}

std::vector<std::string> texts_of(const std::vector<Note>& notes, std::optional<Severity> severity) {
  std::vector<std::string> texts;
  for (const Note& note : notes)
    if (!severity || severity_of(note.kind) == *severity) texts.push_back(with_recording(note, in_words(note)));
  return texts;
}

void order(std::vector<Note>& notes) {
  std::stable_sort(notes.begin(), notes.end(), [](const Note& a, const Note& b) {
    return std::pair(severity_of(a.kind), a.kind) < std::pair(severity_of(b.kind), b.kind);
  });
  const auto same = [](const Note& a, const Note& b) {
    return a.kind == b.kind && a.numbers == b.numbers && a.subject == b.subject && a.recording == b.recording;
  };
  notes.erase(std::unique(notes.begin(), notes.end(), same), notes.end());
}

Values values_of(const std::vector<Note>& notes) {
  Values values;
  for (const Note& note : notes)
    values.push_back(Object{{"kind", to_string(note.kind)},
                            {"severity", to_string(severity_of(note.kind))},
                            {"text", texts_of({note}).front()}});
  return values;
}

std::vector<Note> notes_of(const std::vector<detection::RecordingDetection>& recordings, bool named) {
  constexpr std::size_t kMostNamed = 5;
  std::vector<Note> notes;
  std::size_t n_drops = 0, n_doubtful = 0;
  std::string where;
  const detection::RecordingDetection* of = nullptr;
  const detection::DropSummary* likeliest = nullptr;
  for (const detection::RecordingDetection& r : recordings) {
    for (Note note : r.found.notes) {
      if (named) note.recording = name_of(r);
      notes.push_back(std::move(note));
    }
    n_drops += r.found.drops.size();
    for (const detection::DropSummary& drop : r.found.drops) {
      if (!likeliest || drop.odds > likeliest->odds) likeliest = &drop, of = &r;
      if (!drop.is_doubtful() || ++n_doubtful > kMostNamed) continue;
      where += (where.empty() ? "" : ", ") + name_of(r) + formatted(" at %.1f s (%.1f times)", drop.begin_s, drop.odds);
    }
  }
  if (n_doubtful > kMostNamed) where += formatted(" and %zu more", n_doubtful - kMostNamed);
  if (n_doubtful > 0)
    notes.push_back(
        {NoteKind::doubtful_drops,
         {static_cast<double>(n_doubtful), static_cast<double>(n_drops), detection::DropSummary::kDoubtfulOdds},
         where});
  if (likeliest && likeliest->is_doubtful())
    notes.push_back(
        {NoteKind::no_ball_likely, {likeliest->odds, likeliest->begin_s}, {}, named ? name_of(*of) : std::string()});
  return notes;
}

std::vector<Note> notes_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config) {
  if (counts.n_heights_contradicted == 0) return {};
  return {{NoteKind::contradicted_height,
           {*config.drop_height_m, static_cast<double>(counts.n_heights_contradicted),
            static_cast<double>(counts.n_drops), *counts.height_suggested_m}}};
}

}  // namespace bouncelab::report

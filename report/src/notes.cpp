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
     "no ε is stated: it is doubtful whether a ball bounced (odds {0:.1f} to 1 for a ball, from {1:.1f} s on); listen "
     "there, the report shows what was taken for impacts"},
    {Kind::silence, warning, "nothing rises above the noise: too quiet; record nearer to where the ball lands"},
    {Kind::no_three_bounces, warning,
     "{0} {0|sound rises|sounds rise} like {0|an impact|impacts}: three bounces in a row are the least; drop the ball "
     "from higher, or record nearer to where it lands"},
    {Kind::sounds_not_of_ball, warning,
     "{0} sounds rise like impacts, and no three of them follow each other as a ball's bounces do: no ball, two balls "
     "at once, or too few bounces; drop one ball, and let it bounce out"},
    {Kind::drops_too_short, warning,
     "{0} {0|drop|drops} of fewer than {1} impacts, left out: --min-impacts takes shorter ones"},
    {Kind::recording_left_out, warning, "{s}; left out"},
    {Kind::doubtful_drops, warning,
     "{0} of {1} drops {0|is|are} doubtful, odds below {2} to 1 for a bouncing ball: {s}; kept, listen there"},
    {Kind::contradicted_height, warning,
     "--drop-height {0:.4g} m contradicts the flights of {1} of {2} drops, which suggest a fall of {3:.2g} m: is it in "
     "metres, and from rest? Their first impact is left out"},
    {Kind::recordings_differ, warning,
     "the {0} recordings do not agree (p = {1:.2g}): {s}; the pooled values are a mean of unlike balls and their "
     "errors do not hold: use the row of each recording"},
    {Kind::two_kinds_of_drops, warning, "the drops are of two kinds: ε is about {s}. Two balls, or two floors?"},
    {Kind::repeated_drops, warning,
     "{s} ({0} bounces): the same drop twice? Leave copies out, or the errors are too small"},
    {Kind::eps_above_1, warning, "{0} of {1} samples have ε > 1: time order or units of the input?"},
    {Kind::eps_below_0, warning, "{0} of {1} samples have ε < 0: time order or columns of the input?"},
    {Kind::odd_speeds, warning, "{0} of {1} speeds are outside 0.005 to 20 m/s: are {s}, and gravity in m/s^2?"},
    {Kind::rows_left_out, warning, "{0} of the samples left out: {s}; the first is number {1}"},
    {Kind::many_intervals_odd, warning,
     "{0} of {1} bounces are left out, since their intervals look as if an impact was missed or is none: look at the "
     "times there"},
    {Kind::mixed_conditions, warning,
     "{0} of the samples were computed with other corrections, or for another ball, gravity or wave speed than the "
     "first: drag, contact time and error budget are taken as of the first"},
    {Kind::drops_differ, warning,
     "the {0} drops differ by more ({1:.2g} in ε) than bounces of one do ({2:.2g}), which makes the interval wide: "
     "another ball, spot or release? More drops narrow it"},
    {Kind::timing_too_large, warning,
     "the scatter is {0:.2f} of what the stated timing errors alone explain: these are stated too large, and so are "
     "all "
     "errors given here"},
    {Kind::scatter_not_as_fitted, warning,
     "the scatter about the law is not as the fit assumes: χ²/ndf = {0:.2f}, p = {1:.1e}; {s}"},
    {Kind::outliers, warning,
     "{0} {0|bounce is|bounces are} too far from ε(v) for the scatter of the others and left out: missed or invented "
     "impacts?"},
    {Kind::beyond_speeds, warning,
     "ε at {0:.3g} m/s is the law continued: speeds from {1:.3g} to {2:.3g} m/s were measured"},
    {Kind::timing_not_as_stated, warning,
     "neighbouring samples show a timing noise of {0:.2g} us where {1:.2g} us are stated"},
    {Kind::memory_fails, warning, "{s}"},
    {Kind::uncertain_air, detail, "most of the uncertainty is how strongly the air slows the ball: {s}"},
    {Kind::uncertain_contact, detail, "most of the uncertainty is how long the ball touches the floor: {s}"},
    {Kind::other_ball, warning, "{s}: what was taken out of the samples for the one is not put back for the other"},
    {Kind::same_content, warning, "{s} (by content); counted once"},
    {Kind::renamed_recordings, warning,
     "{s}: {0} recordings have the names of recordings in another file: taken as others, with the file's name behind"},
    {Kind::same_drop_in_files, warning,
     "{s}: several files have the same drop of this recording: taken as a recording for each file; give the drops "
     "numbers of their own if it is one"},
    {Kind::of_file, warning, "{s}"},
    {Kind::track_taken, warning, "track {0} of {1} tracks of sound has the ball; --track takes another (from 0)"},
    {Kind::lossy_coding, warning, "lossy coding ({s}): times may be off by more than stated; record as WAV or FLAC"},
    {Kind::gaps_of_time, warning,
     "{0} {0|gap|gaps} of the time stamps between impacts of a drop: an impact there would be missing"},
    {Kind::clipped, warning, "{0} of {1} impacts are clipped: record with less gain"},
    {Kind::low_band, warning,
     "the times were taken from the sound below {0} Hz, where the impacts stand out most: less exact than those of all "
     "frequencies"},
    {Kind::improbable_impacts, warning,
     "{0} of {1} impacts are less likely than not the ball's: no ε is taken from them"},
    {Kind::several_places, warning,
     "{0} of {1} impacts have more than one place where they may have been; their errors cover these"},
    {Kind::second_ball, warning,
     "a second ball seems to bounce at the same time, {0} impacts from {1:.2f} s on: it is not among the results"},
    {Kind::modes_left_out, warning,
     "{0} modes from {1:.0f} to {2:.0f} Hz are left out: a rate of {3:.0f} Hz cannot hold them"},
    {Kind::synthetic_clipped, warning, "{0} impacts are clipped at full scale"},
    {Kind::drops_left_plate, warning, "{0} drops ended early: the ball left the plate"},
    {Kind::impacts_with_gain, warning,
     "{0} of {1} impacts created energy, {2:.4g} of what was released (the contact model allows it)"},
    {Kind::law_contradicted, detail,
     "the law does not describe these bounces: at {0:.2g} m/s the curve is off by {1:+.2g} in ε (ln B = {2:.0f}), and "
     "its constants mean nothing"},
    {Kind::too_few_samples, detail, "{0} usable {0|sample|samples}: at least {1} are needed"},
    {Kind::not_a_sphere, detail, "the median ε is not between 0.05 and 1: no viscoelastic sphere does that"},
    {Kind::not_converged, detail, "the search did not converge: a gain of {0:.3g} in log-likelihood is left"},
    {Kind::not_identifiable, detail,
     "these {0} impacts do not determine the law's constants (95 % intervals at best: {s}); use the curve ε(v)"},
    {Kind::one_speed, detail, "all speeds lie between {0:.3g} and {1:.3g} m/s: one ε, at that speed"},
    {Kind::two_terms, detail, "{0} samples: two terms of the law"},
    {Kind::one_constant, detail, "{0} samples: one ε for all speeds"},
    {Kind::no_bootstrap, detail, "no bootstrap by drop: it needs 8 drops or more"},
    {Kind::few_drops, detail,
     "{0} {0|drop|drops}, fewer than 10: standard errors take impacts as independent, of the constants and of the "
     "slopes of p(ε); those of the slopes may be up to 1.7 times too small at low speeds"},
    {Kind::one_drop_matters, detail,
     "nearly all that is known comes from one drop: standard errors take impacts as independent, of the constants and "
     "of the slopes of p(ε); those of the slopes may be up to 1.7 times too small at low speeds"},
    {Kind::errors_not_stated, detail,
     "{0} of {1} samples state no timing error: it is neglected there, and the scatter includes it"},
    {Kind::memory_without_ball, detail,
     "no ball was named (--ball): the fit with memory takes a solid one, J = {0:.3g} m R^2, of {1:.3g} m radius"},
    {Kind::tied_constants, detail,
     "{s} cannot be told apart with these speeds: their correlation is {0:.4f}; use the curve ε(v), or the constants "
     "with their covariance"},
    {Kind::memory_without_law, detail, "no law to start from"},
    {Kind::memory_too_few, detail, "memory needs {0} impacts, and drops of {1} successive ones"},
    {Kind::memory_not_converged, detail,
     "the search for the likeliest parameters did not converge: these fluctuations are not those of a rough ball's "
     "memory"},
    {Kind::memory_without_errors, detail,
     "the errors of the likeliest parameters could not be found: too few draws from the posterior count"},
    {Kind::memory_transforms, detail,
     "the impacts do not scatter as the model assumes (Anderson-Darling test of the probability transforms)"},
    {Kind::memory_mechanism, detail, "offset and width of the scatter want different roughness"},
    {Kind::memory_by_speed, detail, "slow impacts want another roughness than fast ones"},
    {Kind::memory_between_drops, detail, "drops differ from each other by more than their impacts say"},
    {Kind::memory_unlikelier, detail,
     "impacts taken as independent are likelier: these fluctuations do not remember as those of a rough ball do"},
    {Kind::too_few_recordings, detail,
     "{0} of {1} {1|recording has|recordings have} a law of {0|its|their} own: a law of all needs {2}, a comparison 2"},
    {Kind::undetermined_campaign, detail, "{0} recordings do not determine law, drift and plates together"},
    {Kind::law_of_two_constants, detail, "the speeds determine no more than two constants of the law, A2 and A4"},
    {Kind::one_speed_of_all, detail, "all speeds are near {0:.3g} m/s: one ε for all of them"},
    {Kind::plates_not_in_law, detail,
     "{0} plates of {1} recordings: too few of the same plate for the pooled law to tell what differs from plate to "
     "plate from what differs from recording to recording; it has no plates"},
    {Kind::plates_are_days, detail, "each plate has a day of its own: plates and days cannot be told apart"},
    {Kind::few_days, detail,
     "{0} days: too few to know how much ε differs from day to day, so the error of a drift is that of recordings that "
     "have nothing in common by their day"},
    {Kind::dates_missing, detail, "{0} of {1} recordings have no date and say nothing of a drift"},
    {Kind::one_date, detail, "all recordings have one date: no drift can be seen"},
    {Kind::plates_are_times, detail,
     "what differs from plate to plate cannot be told from a drift: each plate has a time of its own"},
    {Kind::rows_without_samples, warning, "{s}"},
    {Kind::no_row, warning, "{s}"},
    {Kind::no_ball_named, warning,
     "{s} no ball: drag and contact time are taken out of the others alone; name it (--ball)"},
    {Kind::other_conditions, warning,
     "{s} of another ball, plate or gravity than the first, or otherwise corrected: what differs may be that"},
    {Kind::group_too_small, detail, "{s} has {0} usable samples: at least {1} are needed"},
    {Kind::no_common_speeds, detail,
     "no speeds are common to all: one ends at {0:.2g} m/s, another begins at {1:.2g} m/s"},
    {Kind::group_few_at_common, detail, "{s} has {0} samples at the speeds that all share, {1:.2g} to {2:.2g} m/s"},
    {Kind::group_without_law, detail, "{s} has no law of its own"},
    {Kind::no_error_of_law, detail, "its own law has no standard error"},
    {Kind::errors_tied, detail, "the errors of its own law cannot be told apart"},
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

std::string as_sentence(const Note& note) {
  std::string text = in_words(note);
  const bool begins_with_file = text.substr(0, text.find_first_of(" :")).find('.') != std::string::npos;
  if (!begins_with_file) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  if (text.back() != '.' && text.back() != '?') text += '.';
  return note.recording.empty() ? text : note.recording + ": " + text;
}

std::vector<std::string> texts_of(const std::vector<Note>& notes, std::optional<Severity> severity) {
  std::vector<std::string> texts;
  for (const Note& note : notes)
    if (!severity || severity_of(note.kind) == *severity)
      texts.push_back((note.recording.empty() ? "" : note.recording + ": ") + in_words(note));
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
      where += (where.empty() ? "" : ", ") + name_of(r) + formatted(" at %.1f s (%.1f to 1)", drop.begin_s, drop.odds);
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

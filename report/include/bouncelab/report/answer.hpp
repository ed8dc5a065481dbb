// SPDX-License-Identifier: GPL-3.0-or-later
/// What fits say, in sentences: the answer for somebody who dropped a ball, what a user must know before using it, the
/// questions of a reader, comparisons of recordings, the paper's conclusions; and fit.json, which has them beside the
/// numbers. Nothing is computed here.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/fit.hpp"

namespace bouncelab::report {

/// What samples say of the drops that they come from. Where their times are not known everything is absent.
struct DropsSeen {
  std::size_t n_drops = 0;
  std::optional<std::size_t> n_impacts;  ///< that the samples were made from
  std::optional<double> duration_s;      ///< from first to last impact; of several drops the sum
  /// Height of the release [m], through the air (fit::ReleaseHeight). Of several drops the median. Only of drops whose
  /// first impact was seen: the recording began early enough to have heard one bounce before it, and no other drop
  /// ended so shortly before. None where a later flight rose higher.
  std::optional<double> drop_height_m;
  /// Not below the highest flight; absent of a height that was given, and of different heights.
  std::optional<fit::Interval> drop_height_ci95_m;
  /// Least and greatest where drops of different heights are among them, more than their intervals differ.
  std::optional<fit::Interval> drop_heights_m;
  std::size_t n_heights = 0;  ///< drops with a height
};
Description members_of(const DropsSeen*);

/// eps at one speed within the range measured.
struct SpeedAndRestitution {
  double v_mps = 0.0;
  fit::Estimate eps;         ///< root mean square
  double energy_lost = 0.0;  ///< 1 - eps^2: share of the energy of the vertical motion that bounces take
};
Description members_of(const SpeedAndRestitution*);

/// One recording of several, alone.
struct RecordingAnswer {
  std::string recording;
  std::string name;                       ///< in a sentence
  std::optional<SpeedAndRestitution> at;  ///< at a speed common to most of them, else at its own
  std::string missing;                    ///< in words, why there is none
  DropsSeen seen;
};
Description members_of(const RecordingAnswer*);

/// The result for somebody who asks "what is the coefficient of restitution of my ball?".
struct PlainAnswer {
  /// At the node in the middle, or beside a step; absent where nothing could be fitted or recordings do not agree.
  std::optional<SpeedAndRestitution> at;
  /// At the greatest and the least speed, where the 95 % interval of the change from the middle does not hold 0.
  std::vector<SpeedAndRestitution> elsewhere;
  bool one_value = false;  ///< one speed alone
  DropsSeen seen;
  std::vector<RecordingAnswer> recordings;  ///< empty where there is one
  std::vector<std::string> sentences;       ///< all of this in words, most important first
  std::string doubt;                        ///< one sentence, what makes it uncertain; empty: nothing to be named
};
Description members_of(const PlainAnswer*);

/// A reason why eps is not the same at every bounce.
struct Cause {
  std::string name;            ///< "speed", "air", "roughness"
  std::optional<double> size;  ///< by how much it changes eps in this recording; absent: not known
  bool is_seen = false;        ///< the data show it
  std::string sentence;
};
Description members_of(const Cause*);

/// A question that a reader of the report has, and the answer that follows from the fit.
struct Finding {
  std::string question;
  std::string answer;
};
Description members_of(const Finding*);

/// A value that enters the numbers and that the user need not have given: a default, or what a file says.
struct Taken {
  std::string what;   ///< the option that gives it: "ball", "gravity"
  std::string value;  ///< in words, "not known" where nothing is
};
Description members_of(const Taken*);

struct FitInWords {
  PlainAnswer answer;
  std::vector<Taken> taken;
  std::vector<Note> notes;        ///< the most severe first
  std::vector<Cause> causes;      ///< the three, largest first; empty without an answer
  std::vector<Finding> findings;  ///< how eps depends on speed, how sure, what limits it ...; empty without a law
};
Description members_of(const FitInWords*);

/// @param samples  all that were given to the fit, in any order, also those that it left out
/// @param memory   as the fit was asked for: a fit with memory that does not hold is worth a warning where it was
FitInWords in_words(const fit::FitResult& result, const RestitutionSamples& samples,
                    fit::UseMemory memory = fit::UseMemory::where_long);

/// Where a note leaves no answer it stands in its place; else the first warning that the answer does not say itself, or
/// what most of the uncertainty is, becomes its doubt.
/// @param notes  of the recordings and of the fit, ordered
void take(const std::vector<Note>& notes, FitInWords& words);

/// Ball, plate, gravity and air that samples were computed with.
std::vector<Taken> taken_of(const SampleConditions& conditions);
/// Channel and track of a recording that has several.
std::vector<Taken> taken_of(const detection::RecordingDetection& recording);
/// "Taken: ball not known, gravity 9.80665 m/s^2."; empty where nothing was.
std::string in_words(const std::vector<Taken>& taken);

/// "Constants of the law: A2 = 0.0470 ± 0.0010, ...": of one ball, or why there are none.
std::string constants_in_words(const fit::FitResult& result);

/// What a user should know of a fit and of its samples, ordered.
std::vector<Note> notes_of(const fit::FitResult& result, const RestitutionSamples& samples, fit::UseMemory memory);
/// Of a measured roughness. @param samples  all that it was measured from
std::vector<Note> notes_of(const fit::RoughnessResult& result, const RestitutionSamples& samples);
/// Drops that have the bounces of others; absent where there are none (fit::repeated_drops).
std::optional<Note> note_of_repeated_drops(const RestitutionSamples& used);

/// "a.wav: ε = 0.9477 ± 0.0003 (95 %: 0.9470 to 0.9484) at 0.25 m/s", or why there is none.
std::string in_words(const RecordingAnswer& recording);

/// Counts samples that no ball gives, one by one.
class Implausible {
 public:
  void add(const RestitutionSample& sample);
  /// Of each kind of which there are more than a tenth: eps above 1, eps below 0, speeds of no ball.
  std::vector<Note> notes() const;

 private:
  std::size_t n_ = 0, n_impossible_ = 0, n_speeds_ = 0;
  bool of_heights_ = false;
};

/// What samples say of their drops.
/// @param samples  in any order
/// @param heights  of the fit to them, if the first impact heard was the first
DropsSeen drops_seen(const RestitutionSamples& samples, const std::vector<fit::ReleaseHeight>& heights);

/// "135 to 147 cm"
std::string asked_rebound(const ReboundRule& rule);
/// Do the recordings agree: with p, and where they do not with the least and the greatest eps. Empty where there is one
/// recording.
std::string in_words(const fit::Recordings& recordings);
/// What speaks against the fit with memory, or why there is none; empty where nothing does.
std::string objections_in_words(const fit::MemoryFit& memory);
/// Do the fluctuations remember? A sentence with its tests, and where they do not what to use instead.
std::string in_words(const fit::MemoryFit& memory);
/// "q = 1.40e-06 ± 5e-08 (95 %: 1.3e-06 to 1.5e-06), rms tilt of the contact's normal 0.11 degrees without slip"
std::string in_words(const fit::Roughness& roughness);

/// fit.json: the words, then everything of the fit.
Object object_of(const fit::FitResult& result, const FitInWords& words);
/// roughness.json
Object object_of(const fit::RoughnessResult& result, const std::vector<Note>& notes);

// What many recordings say together (fit/between_recordings.hpp).

/// The answer in a few sentences, the most important first: differences of few groups. @param recordings  those
/// compared
std::vector<std::string> in_words(const fit::BetweenRecordings& between,
                                  const std::vector<fit::CampaignRecording>& recordings);

/// comparison.json but for the rows of the recordings, of which it has the outliers and those that could not be used.
Object object_of(const fit::BetweenRecordings& between, const std::vector<fit::CampaignRecording>& recordings);

/// What the page draws: columns of the recordings used, in order of time; of more than `most` every so manieth, and
/// always the outliers.
std::string points_json(const fit::BetweenRecordings& between, const std::vector<fit::CampaignRecording>& recordings,
                        std::size_t most = 4000);

/// Something that the paper concludes from its figures, put to the numbers of one experiment.
struct Conclusion {
  std::string claim;                    ///< "p(eps) is not normal"
  std::string measure;                  ///< what `value` is
  std::string criterion;                ///< when the claim is said to hold
  std::optional<double> value{};        ///< absent where the data do not reach
  std::optional<fit::Interval> ci95{};  ///< of `value`, where it has one
  bool holds = false;
  std::string detail{};  ///< the numbers behind, in words
};
Description members_of(const Conclusion*);

/// What Montaine et al., doi:10.1103/PhysRevE.84.041306, conclude from their figs. 1 and 2:
///   - p(eps) at fixed speed is not normal          every window: AIC(normal) - AIC(two exponentials) > 10
///   - its two slopes differ                        every window: 95 % interval of their ratio excludes 1
///   - its peaks follow eps(v)                      every window: |peak - eps(v)| < 3 standard errors
///   - the scatter comes from the asperities        spread of the smooth ball below a tenth of the rough ball's
///   - it grows as the speed falls                  95 % interval of k in spread ~ v^k below 0
/// @param rough   fitted to the rough ball
/// @param smooth  fitted to the same ball without asperities through the same chain; without: that claim is left out
/// @param truth   the law that went in, where it is known; else the peaks are held against the fitted law
std::vector<Conclusion> paper_conclusions(const fit::FitResult& rough, const fit::FitResult* smooth,
                                          const std::optional<RestitutionLaw>& truth);

}  // namespace bouncelab::report

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/comparison.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::loop {
namespace {

using Groups = std::vector<std::pair<std::string, RestitutionSamples>>;
using Names = std::vector<std::string>;

/// A note on some of the recordings: "2 of the 5 recordings ('a', 'b') WHAT". None of no names.
/// @param one, more  what is true of one, and of several
void note_some(NoteKind kind, const Names& names, std::size_t n_all, const std::string& one, const std::string& more,
               std::vector<Note>& notes) {
  constexpr std::size_t kMostNamed = 5;
  if (names.empty()) return;
  std::string some;
  for (std::size_t k = 0; k < std::min(names.size(), kMostNamed); ++k)
    some += (k > 0 ? ", '" : "'") + printable(names[k]) + "'";
  if (names.size() > kMostNamed) some += formatted(" and %zu more", names.size() - kMostNamed);
  notes.push_back(
      {kind,
       {},
       formatted("%zu of the %zu recordings (", names.size(), n_all) + some + ") " + (names.size() == 1 ? one : more)});
}

/// The recordings by plate where each has its own, else by name, with their samples; none but of two to four.
/// @param kept  usable samples of the recordings, in their order
Groups groups_of(const std::vector<fit::CampaignRecording>& recordings, const std::vector<RestitutionSamples>& kept) {
  if (recordings.size() < 2 || recordings.size() > fit::kMostGroups) return {};
  std::multiset<std::string> plates;
  Names names;
  for (const fit::CampaignRecording& recording : recordings) {
    plates.insert(recording.origin.plate);
    names.push_back(recording.summary.recording);
  }
  names = short_names(names);
  Groups groups;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const std::string& plate = recordings[k].origin.plate;
    groups.emplace_back(!plate.empty() && plates.count(plate) == 1 ? plate : names[k], kept[k]);
  }
  return groups;
}

}  // namespace

std::vector<fit::RecordingOrigin> origins_of(const Names& recordings, const Origins& origins,
                                             std::vector<Note>& notes) {
  std::vector<fit::RecordingOrigin> all(recordings.size());
  if (origins.by_recording.empty()) return all;
  std::map<std::string, std::string> found;  // row -> the recording that it is of
  Names without_row, without_samples;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const std::string& recording = recordings[k];
    auto known = origins.by_recording.find(recording);
    // else that of the longest end of its path
    for (std::size_t at = recording.find('/'); known == origins.by_recording.end() && at != std::string::npos;
         at = recording.find('/', at + 1))
      known = origins.by_recording.find(recording.substr(at + 1));
    if (known == origins.by_recording.end()) {
      without_row.push_back(recording);
      continue;
    }
    all[k] = known->second;
    const std::string& other = found.emplace(known->first, recording).first->second;
    if (other != recording)
      throw FileError(origins.table, "the row '" + printable(known->first) + "' is of '" + printable(other) +
                                         "' and of '" + printable(recording) +
                                         "'; write the path of each, a row for each");
  }
  for (const auto& [name, origin] : origins.by_recording)
    if (!found.contains(name)) without_samples.push_back(name);
  const std::string of_table = "of " + origins.table, in_table = " no row in " + origins.table;
  note_some(NoteKind::rows_without_samples, without_samples, origins.by_recording.size(), of_table + " has no samples",
            of_table + " have no samples", notes);
  note_some(NoteKind::no_row, without_row, recordings.size(), "has" + in_table, "have" + in_table, notes);
  return all;
}

void Comparison::add(RestitutionSamples&& samples) {
  constexpr std::size_t kMost_samples = 100000;  // waiting: some 30 MB
  constexpr std::size_t kMostKept = 100;         // recordings among which drops that are there twice are sought
  const bool is_named = !samples.empty() && samples.front().conditions.ball;
  const std::string recording = samples.empty() ? "" : samples.front().recording;
  (is_named ? of_named_balls_ : of_others_).push_back(recording);
  if (is_named) samples = fit::at_the_plate(std::move(samples));
  if (!samples.empty()) {
    SampleConditions conditions = samples.front().conditions;
    if (!first_) first_ = conditions;
    const bool is_other_plate = conditions.plate != first_->plate;
    conditions.plate = first_->plate;
    if (conditions != *first_ && conditions.ball.has_value() == first_->ball.has_value())
      of_other_conditions_.push_back(recording);
    else if (is_other_plate)
      of_other_plates_.push_back(recording);
  }
  n_waiting_ += samples.size();
  if (kept_.size() < kMostKept) {
    fit::LeftOut left_out;
    kept_.push_back(*fit::usable_samples(samples, left_out));
  }
  waiting_.push_back(std::move(samples));
  if (n_waiting_ > kMost_samples) reduce();
}

void Comparison::reduce() {
  const std::size_t first = recordings_.size();
  recordings_.resize(first + waiting_.size());
  parallel_for(waiting_.size(), 0,
               [&](std::size_t k) { recordings_[first + k].summary = fit::summarize_recording(waiting_[k]); });
  waiting_.clear();
  n_waiting_ = 0;
}

ComparedRecordings Comparison::finish(const Origins& origins) {
  reduce();
  ComparedRecordings all;
  std::vector<Note> notes;
  if (!of_named_balls_.empty())
    note_some(NoteKind::no_ball_named, of_others_, recordings_.size(), "names", "name", notes);
  const auto& by_name = origins.by_recording;
  if (std::all_of(by_name.begin(), by_name.end(), [](const auto& row) { return row.second.plate.empty(); }))
    of_other_conditions_.insert(of_other_conditions_.end(), of_other_plates_.begin(), of_other_plates_.end());
  note_some(NoteKind::other_conditions, of_other_conditions_, recordings_.size(), "is", "are", notes);
  all.recordings = std::move(recordings_);
  Names names;
  for (const fit::CampaignRecording& recording : all.recordings) names.push_back(recording.summary.recording);
  const std::vector<fit::RecordingOrigin> of_names = origins_of(names, origins, notes);
  for (std::size_t k = 0; k < names.size(); ++k) {
    all.recordings[k].origin = of_names[k];
    if (!of_names[k].date) all.recordings[k].origin.date = fit::date_in_name(names[k]);
  }
  all.between = fit::compare_campaign(all.recordings);
  all.between.notes.insert(all.between.notes.end(), notes.begin(), notes.end());
  for (const RestitutionSamples& samples : kept_) all.kept.insert(all.kept.end(), samples.begin(), samples.end());
  if (!all.between.differences)
    if (const Groups groups = groups_of(all.recordings, kept_); !groups.empty())
      all.between.differences = fit::compare_groups(groups);
  return all;
}

}  // namespace bouncelab::loop

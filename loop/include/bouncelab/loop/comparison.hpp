// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/between_recordings.hpp"

namespace bouncelab::loop {

/// Plates and dates by recording, by its name or an end of its path.
struct Origins {
  std::map<std::string, fit::RecordingOrigin> by_recording;
  std::string table;  ///< that they stand in, for notes
};

/// Of each of the recordings; of one that the origins do not know nothing. Rows without a recording and recordings
/// without a row are named in notes. @throws FileError where a row is of two recordings
std::vector<fit::RecordingOrigin> origins_of(const std::vector<std::string>& recordings, const Origins& origins,
                                             std::vector<Note>& notes);

struct ComparedRecordings {
  std::vector<fit::CampaignRecording> recordings;
  fit::BetweenRecordings between;  ///< with all notes, unordered; differences of plates, else of 2 to 4 recordings
  RestitutionSamples kept;         ///< usable ones of the first hundred recordings
};

/// Do recordings agree, and by what do they differ? They are reduced as they come, some at a time on all threads, and
/// of more than a hundred the summaries alone are kept: campaigns are as long as they like.
class Comparison {
 public:
  /// @param samples  of one recording. Of a named ball they are taken to the plate
  void add(RestitutionSamples&& samples);
  std::size_t n_reduced() const { return recordings_.size(); }
  /// The result of all; to be called once. A recording that the origins give no date has that of its name.
  ComparedRecordings finish(const Origins& origins);

 private:
  void reduce();

  std::vector<fit::CampaignRecording> recordings_;
  std::vector<RestitutionSamples> kept_, waiting_;
  std::size_t n_waiting_ = 0;  // samples
  std::vector<std::string> of_named_balls_, of_others_, of_other_conditions_, of_other_plates_;
  std::optional<SampleConditions> first_;
};

}  // namespace bouncelab::loop

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"

namespace bouncelab::audio {

/// A mark in a recording, as sound editors know it.
struct Annotation {
  double t_s = 0.0;  ///< from the first sample
  std::string label;
};

/// The marks of one recording, as they stand in a file.
struct Annotations {
  std::string recording;      ///< as the file names it; empty where it does not
  double resolution_s = 0.0;  ///< the file's times are multiples of this
  std::vector<Annotation> points;
};

/// Onsets of one recording as marks labelled
///
///   DROP.IMPACT [FLAG|FLAG] t_s=... [sigma_t_s=...] [amplitude=...] [snr_db=...]
///
/// with as many digits as read back to the same number.
/// @throws InvalidArgument where there are none, or of several recordings: marks belong to one
Annotations annotations_of(const Onsets& onsets);

/// Annotations as onsets, by time. Where a label's t_s is the mark's time within half the file's resolution, the onset
/// is what it was; where not, somebody moved the mark: its time counts, standard error and loudness are not known, and
/// its only flag is `by_hand`. So it is of a mark without DROP.IMPACT, which joins the drop of the mark before it.
/// Impacts keep their numbers, moved up where a mark came between.
/// @param renumber  impacts are numbered by time in each drop: for marks that were taken away
/// @throws InvalidArgument where there are no marks
Onsets onsets_of(const Annotations& annotations, bool renumber);

/// Label track of Audacity: begin, end, label, tab-separated lines. Written with all digits; Audacity keeps 1e-6 s.
std::string audacity_labels(const Annotations& annotations);
/// Of stretches, the begin counts. @param name  of the file, for messages. @throws FileError naming the line
Annotations parse_audacity_labels(const std::string& text, const std::string& name);

/// Time instants layer of Sonic Visualiser (.svl): times are whole frames. @param n_frames  of the recording
std::string sonic_visualiser_layer(const Annotations& annotations, int rate_hz, std::int64_t n_frames);
/// @throws FileError where the text is no layer of points
Annotations parse_sonic_visualiser_layer(const std::string& text, const std::string& name);

/// TextGrid of Praat with one point tier, named as the recording. @param duration_s  of the recording
std::string text_grid(const Annotations& annotations, double duration_s);
/// The first point tier of a TextGrid, long or short text. @throws FileError where there is none
Annotations parse_text_grid(const std::string& text, const std::string& name);

/// Cue points and their labels (chunks `cue ` and `LIST` of type `adtl`) of a WAV or RF64 file; times are whole frames.
/// @throws FileError where the file is neither, or holds no cue points
Annotations read_cues(const std::filesystem::path& path);
/// Copies a WAV or RF64 file byte for byte, with these cue points in place of those it has.
/// @param name  of the new file, for messages, where `out` is a temporary one
/// @throws FileError where the recording is neither, or a mark lies beyond frame 2^32, or the copy beyond 4 GiB of WAV
void copy_with_cues(const std::filesystem::path& recording, const Annotations& annotations,
                    const std::filesystem::path& out, const std::string& name);

}  // namespace bouncelab::audio

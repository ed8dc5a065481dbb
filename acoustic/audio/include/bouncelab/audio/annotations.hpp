// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/onsets.hpp"

namespace bouncelab::audio {

/// A labelled point in time of a recording: a label of Audacity, a time instant of Sonic Visualiser, a point of a Praat
/// tier, a cue point of a WAV file.
struct Annotation {
  double t_s = 0.0;  ///< from the first sample
  std::string label;
};

/// The annotations of one recording, as a file has them.
struct Annotations {
  std::string recording;      ///< as the file names it; empty if it does not
  double resolution_s = 0.0;  ///< the file's times are multiples of this
  std::vector<Annotation> points;
  std::string taken_for{};  ///< which of several tiers or layers these are, for people; empty: there was one
};

/// Onsets of one recording as points labelled
///
///   DROP.IMPACT [FLAG|FLAG] t_s=... [sigma_t_s=...] [amplitude=...] [snr_db=...] [probability=...]
///
/// with as many digits as read back to the same number.
/// @throws InvalidArgument if there are no onsets, or onsets of several recordings
Annotations annotations_of(const Onsets& onsets);

/// The same points with labels that fit between impacts on a screen, DROP.IMPACT [FLAG|FLAG], at most 20 characters
/// where there are no drops or impacts of more than nine digits: the rest of what is known has to be kept elsewhere.
Annotations shortened(Annotations annotations);

/// Undoes shortened(): points labelled DROP.IMPACT and nothing that is known of the onset get the label that
/// annotations_of() gives the onset of that number.
/// @param onsets  those that were shortened
Annotations completed(Annotations annotations, const Onsets& onsets);

/// Annotations as onsets, by time. If the t_s of a label equals the time of its point within half the file's
/// resolution, the onset is restored as it was. If not, the point was moved by hand: its time is used, standard error
/// and amplitude are unknown, and its only flag is `by_hand`. The same holds for a point without DROP.IMPACT, which
/// joins the drop of the point before it. Impacts keep their numbers, moved up where a point was inserted.
/// Where the labels are not numbered so, all points are marks made by hand, and drops are drops_of() their times.
/// @param renumber  number the impacts of each drop anew by time: for points that were deleted
/// @param name      of the file, for messages
/// @throws FileError if there are no points, or no numbers for them
Onsets onsets_of(Annotations annotations, bool renumber, const std::string& name);

// ---- any of these, by the content of the file

/// Is it a table of onsets as detect writes it, by its first line? @param head  some bytes from the begin, decoded
bool is_own_table(std::string_view head);
/// Marks of Audacity, Sonic Visualiser, Praat or cue points of a WAV file; absent where the content is a table.
/// @param tier  of several, or layer
/// @throws FileError
std::optional<Annotations> marks_of_file(std::string_view bytes, const std::string& name, const std::string& tier);
/// Onsets of a file of any kind: our table, marks, times or intervals of other programs (onsets_from_foreign).
/// @param taken_for  is set where the file is not ours
/// @throws FileError, InvalidArgument
Onsets onsets_of_file(std::string_view bytes, const std::string& name, const ForeignOptions& options,
                      const std::string& tier, std::string& taken_for);
/// Does a file hold times or marks, rather than sound? Text does where it has no column of times that are equally
/// spaced and close enough to be samples.
/// @param head  the first kHeadOfTimes_bytes. @param is_whole  it is the whole file
bool holds_times(std::string_view head, bool is_whole);
inline constexpr std::size_t kHeadOfTimes_bytes = 1 << 14;
/// Files that are longer, some 100,000 impacts, and are no table of ours hold samples of a sound.
inline constexpr std::size_t kLongestOfTimes_bytes = 1 << 22;

// ---- each

/// Label track of Audacity: begin, end, label, tab-separated lines. Written with all digits; Audacity keeps 1e-6 s.
std::string audacity_labels(const Annotations& annotations);
/// Of labels that span an interval the begin is used; decimal commas and clock times are read too.
/// @param text  UTF-8 (decoded_text), as for all readers here. @param name  of the file, for messages
/// @throws FileError where no line begins with a time
Annotations parse_audacity_labels(std::string_view text, const std::string& name);

/// Time instants layer of Sonic Visualiser (.svl): times are whole frames. @param n_frames  of the recording
std::string sonic_visualiser_layer(const Annotations& annotations, int rate_hz, std::int64_t n_frames);
/// @param layer  which of several, by its number from 1; empty: the one that looks most like impacts
/// @throws FileError if the text is not a layer of points
Annotations parse_sonic_visualiser_layer(std::string_view text, const std::string& name, const std::string& layer = {});

/// TextGrid of Praat with one point tier, named as the recording. @param duration_s  of the recording
std::string text_grid(const Annotations& annotations, double duration_s);
/// A point tier of a TextGrid, long or short text. @throws FileError if there is none
/// @param tier  which of several, by its name or its number from 1; empty: the one that looks most like impacts
Annotations parse_text_grid(std::string_view text, const std::string& name, const std::string& tier = {});

/// Cue points and their labels (chunks `cue ` and `LIST` of type `adtl`) of a WAV or RF64 file; times are whole frames.
/// @throws FileError if the file is neither, or holds no cue points
Annotations read_cues(const std::filesystem::path& path);
/// The same of the bytes of a file in memory. @param name  of the file, for messages and as the recording's
Annotations parse_cues(std::span<const std::byte> bytes, const std::string& name);
/// Copies a WAV or RF64 file byte for byte, with these cue points in place of those it has.
/// @param write  takes the copy, piece by piece
/// @param name   of the copy, for messages
/// @throws FileError if the recording is neither, or a point lies beyond frame 2^32, or the copy of a WAV file would
///         exceed 4 GiB
void copy_with_cues(const std::filesystem::path& recording, const Annotations& annotations,
                    const std::function<void(std::string_view)>& write, const std::string& name);

}  // namespace bouncelab::audio

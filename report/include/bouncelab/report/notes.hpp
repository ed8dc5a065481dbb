// SPDX-License-Identifier: GPL-3.0-or-later
/// The words of notes (core/note.hpp): one table of all kinds, with how severe each is. Nobody else makes words of
/// them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::report {

Severity severity_of(NoteKind kind);
/// The words of a kind with "..." for its numbers and its subject, for docs/formats.md.
std::string pattern_of(NoteKind kind);
/// Without a full stop and without the recording's name, small where a word begins it: "3 of 52 impacts are clipped:
/// record with less gain".
std::string in_words(const Note& note);
/// "Drop.wav: ..." where the note is of a recording, and a sentence: with a capital and a full stop.
std::string as_sentence(const Note& note);
/// As texts, each with its recording's name. @param severity  the others are left out; absent: all
std::vector<std::string> texts_of(const std::vector<Note>& notes, std::optional<Severity> severity = {});
/// The most severe first, and of these by kind; each once.
void order(std::vector<Note>& notes);
/// `[{kind, severity, text}]`
Values values_of(const std::vector<Note>& notes);

/// All that is to be known of the recordings in which impacts were looked for. @param named  each note names its own
std::vector<Note> notes_of(const std::vector<detection::RecordingDetection>& recordings, bool named);
/// Flights that contradict the height that was given.
std::vector<Note> notes_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config);

}  // namespace bouncelab::report

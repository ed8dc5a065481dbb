// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/note.hpp"

namespace bouncelab {

const char* to_string(NoteKind kind) {
#define BOUNCELAB_NOTE_KIND(name) #name,
  static constexpr const char* kNames[]{BOUNCELAB_NOTE_KINDS(BOUNCELAB_NOTE_KIND)};
#undef BOUNCELAB_NOTE_KIND
  return kNames[static_cast<std::size_t>(kind)];
}

Description members_of(const Note*) {
  static constexpr Member all[]{
      member<&Note::kind>("kind", "What it is"), member<&Note::numbers>("numbers", "Its numbers"),
      member<&Note::subject>("subject", "What it is about"),
      member<&Note::recording>("recording", "The recording that it is of; empty: of all, or of the only one")};
  return all;
}

const char* to_string(Severity severity) {
  static constexpr const char* kNames[]{"no_answer", "warning", "detail"};
  return kNames[static_cast<std::size_t>(severity)];
}
}  // namespace bouncelab

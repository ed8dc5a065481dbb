// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/report/detection.hpp"

namespace bouncelab::report {
namespace {

/// A recording's name for people.
std::string name_of(const detection::RecordingDetection& r) { return printable(input_name(r.recording)); }

}  // namespace

std::vector<std::string> warnings_of_drops(const std::vector<detection::RecordingDetection>& recordings) {
  constexpr std::size_t kMostNamed = 5;
  std::size_t n_drops = 0, n_doubtful = 0;
  std::string where;
  for (const detection::RecordingDetection& r : recordings) {
    n_drops += r.found.drops.size();
    for (const detection::DropSummary& drop : r.found.drops) {
      if (!drop.is_doubtful() || ++n_doubtful > kMostNamed) continue;
      where += (where.empty() ? "" : ", ") + name_of(r) + formatted(" at %.1f s (%.1f to 1)", drop.begin_s, drop.odds);
    }
  }
  if (n_doubtful == 0) return {};
  if (n_doubtful > kMostNamed) where += formatted(" and %zu more", n_doubtful - kMostNamed);
  return {formatted("%zu of %zu drops %s doubtful, odds below %.0f to 1 for a bouncing ball: ", n_doubtful, n_drops,
                    n_doubtful == 1 ? "is" : "are", detection::DropSummary::kDoubtfulOdds) +
          where + "; kept, listen there"};
}

std::optional<std::string> doubt_of_all_drops(const std::vector<detection::RecordingDetection>& recordings) {
  const detection::RecordingDetection* of = nullptr;
  const detection::DropSummary* likeliest = nullptr;
  for (const detection::RecordingDetection& r : recordings)
    for (const detection::DropSummary& drop : r.found.drops)
      if (likeliest == nullptr || drop.odds > likeliest->odds) likeliest = &drop, of = &r;
  if (likeliest == nullptr || !likeliest->is_doubtful()) return {};
  return "no ε is stated: it is doubtful whether a ball bounced" +
         (recordings.size() == 1 ? std::string() : ", least in " + name_of(*of)) +
         formatted(" (odds %.1f to 1 from %.1f s on); listen there, the report shows what was taken for impacts",
                   likeliest->odds, likeliest->begin_s);
}

std::vector<std::string> warnings_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config) {
  if (counts.n_heights_contradicted == 0) return {};
  return {formatted(
      "--drop-height %.4g m contradicts the flights of %zu of %zu drops, which suggest a fall of %.2g m: is it "
      "in metres, and from rest? Their first impact is left out",
      *config.drop_height_m, counts.n_heights_contradicted, counts.n_drops, *counts.height_suggested_m)};
}

std::vector<std::string> warnings_of(const std::vector<detection::RecordingDetection>& recordings) {
  std::vector<std::string> warnings;
  for (const detection::RecordingDetection& r : recordings) {
    if (r.found.status == detection::DetectionStatus::unreadable) warnings.push_back(r.found.message + "; left out");
    for (const std::string& warning : r.found.warnings) warnings.push_back(name_of(r) + ": " + warning);
  }
  return warnings;
}

}  // namespace bouncelab::report

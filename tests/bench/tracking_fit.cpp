// SPDX-License-Identifier: GPL-3.0-or-later
// Likelihood profiles of the numbers of the model of tracks (tracking/tracking_model.hpp).
//
//     tracking_fit [--list] [--fit] [--vary NAME|all]... [--set NAME=VALUE]... FOLDER...
//
// reads all recordings of the folders, with NAME.truth.csv (header t_s) the impacts of balls, without it no ball. Each
// candidate gets the probability of being an impact that the model states; the score is the mean logarithm of the
// probability of what is true, a proper scoring rule (Good 1952). Each number is varied by factors, the others kept.
// Recordings are in two halves by a hash of their names: on one the numbers are chosen, the other is held out.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "channel_tracks.hpp"
#include "model_numbers.hpp"

namespace {

using namespace bouncelab;
using namespace bouncelab::detection;

constexpr double kTolerance_s = 4e-3;       // of candidates, which are not yet timed by a template
constexpr double kFurthestOffset_s = 6e-3;  // of a recording's annotations as a whole: sound travels, hands are late
constexpr double kLeastScore = -25.0;       // of one recording: none outweighs the others
constexpr double kLeastGain = 2.0;          // of the score, nats: what a number must gain to be changed
constexpr double kLeastProbability = 1e-2;  // that the score counts for what was not found, or wrongly

struct Recording {
  std::string name;
  std::vector<std::unique_ptr<std::vector<float>>> samples;  // of each channel
  std::vector<std::vector<BandOfChannel>> channels;          // in bands, searched for candidates when read
  std::optional<std::vector<double>> truth_s;                // absent where there is no ball
  double duration_s = 0.0;
  bool is_held_out = false;
};

std::optional<std::vector<double>> read_truth(const std::filesystem::path& recording) {
  std::ifstream file(recording.parent_path() / (recording.stem().string() + ".truth.csv"));
  if (!file) return {};
  std::string line;
  std::getline(file, line);
  std::vector<double> t_s;
  while (std::getline(file, line))
    if (!line.empty()) t_s.push_back(std::stod(line));
  return t_s;
}

std::uint32_t fnv1a(std::string_view text) {
  std::uint32_t hash = 2166136261U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

Recording read(const std::filesystem::path& path) {
  Recording r;
  r.name = path.stem().string();
  r.truth_s = read_truth(path);
  r.is_held_out = fnv1a(r.name) % 2 == 1;
  audio::AudioReader reader(path);
  for (int c = 0; c < reader.format().n_channels; ++c) {
    const audio::AudioSource sound = reader.source(c);
    r.duration_s = static_cast<double>(sound.n_samples) / sound.rate_hz;
    // in memory: as many files cannot be open at a time
    std::vector<float>& samples =
        *r.samples.emplace_back(std::make_unique<std::vector<float>>(static_cast<std::size_t>(sound.n_samples)));
    sound.read(0, samples);
    std::vector<BandOfChannel>& bands =
        r.channels.emplace_back(bands_of(audio::source_in_memory(samples, sound.rate_hz)));
    for (std::size_t b = 0; b < bands.size(); ++b) find_candidates_of(bands, b);
  }
  return r;
}

std::vector<Recording> read_folders(const std::vector<std::filesystem::path>& folders) {
  std::vector<std::filesystem::path> paths;
  for (const auto& folder : folders)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      if (entry.path().extension() == ".wav" || entry.path().extension() == ".ogg" ||
          entry.path().extension() == ".flac")
        paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<std::optional<Recording>> read_ones(paths.size());
  parallel_for(paths.size(), 0, [&](std::size_t k) {
    try {
      read_ones[k] = read(paths[k]);
    } catch (const Error& error) {
      fmt::print(stderr, "left out: {}\n", error.what());
    }
  });
  std::vector<Recording> recordings;
  for (auto& r : read_ones)
    if (r) recordings.push_back(std::move(*r));
  return recordings;
}

/// A mark and the probability stated for it.
struct Mark {
  double t_s = 0.0;
  double probability = 0.0;
};

struct Found {
  std::vector<Mark> marks;
  std::vector<Track> tracks;
  const std::vector<Candidate>* candidates = nullptr;
};

Found find(const Recording& r) {
  SearchedChannel best;
  for (std::size_t c = 0; c < r.channels.size(); ++c) {
    SearchedChannel here = search_channel(r.channels[c]);
    here.channel = c;
    if (c == 0 || here.bands[here.best].log_odds() > best.bands[best.best].log_odds()) best = std::move(here);
  }
  Found found;
  found.candidates = &r.channels[best.channel][best.best].candidates;
  found.tracks = std::move(best.bands[best.best].tracks);
  for (const Track& track : found.tracks)
    for (const TrackImpact& impact : track.impacts)
      found.marks.push_back({(*found.candidates)[impact.candidate].t_s, 1.0 / (1.0 + std::exp(-track.log_odds))});
  return found;
}

struct Score {
  double log_score = 0.0;  // sum over impacts and invented marks
  int n_true = 0, n_found = 0, n_marks = 0, n_invented = 0;
  double invented_h = 0.0;

  Score& operator+=(const Score& o) {
    log_score += o.log_score, n_true += o.n_true, n_found += o.n_found, n_marks += o.n_marks;
    n_invented += o.n_invented, invented_h += o.invented_h;
    return *this;
  }
};

/// Marks that belong to impacts, at an offset.
std::vector<bool> matched(const std::vector<Mark>& marks, const std::vector<double>& truth_s, double offset_s) {
  std::vector<bool> is_used(marks.size(), false);
  for (const double t_s : truth_s) {
    std::optional<std::size_t> nearest;
    for (std::size_t k = 0; k < marks.size(); ++k) {
      const double off_s = std::abs(marks[k].t_s - offset_s - t_s);
      if (off_s < kTolerance_s && !is_used[k] && (!nearest || off_s < std::abs(marks[*nearest].t_s - offset_s - t_s)))
        nearest = k;
    }
    if (nearest) is_used[*nearest] = true;
  }
  return is_used;
}

Score score(const Recording& r, const Found& found) {
  Score s;
  std::vector<bool> is_right(found.marks.size(), false);
  if (r.truth_s) {
    for (double offset_s = -kFurthestOffset_s; offset_s <= kFurthestOffset_s; offset_s += 0.25e-3) {
      const std::vector<bool> here = matched(found.marks, *r.truth_s, offset_s);
      if (std::count(here.begin(), here.end(), true) > std::count(is_right.begin(), is_right.end(), true))
        is_right = here;
    }
    s.n_true = static_cast<int>(r.truth_s->size());
  } else {
    s.n_invented = static_cast<int>(found.tracks.size());
    s.invented_h = r.duration_s / 3600.0;
  }
  s.n_marks = static_cast<int>(found.marks.size());
  for (std::size_t k = 0; k < found.marks.size(); ++k) {
    const double p = is_right[k] ? found.marks[k].probability : 1.0 - found.marks[k].probability;
    s.log_score += std::log(std::max(p, kLeastProbability));
    if (is_right[k]) ++s.n_found;
  }
  s.log_score += (s.n_true - s.n_found) * std::log(kLeastProbability);
  s.log_score = std::max(s.log_score, kLeastScore);
  return s;
}

/// Of the half to build on, and of that held out.
std::array<Score, 2> score_all(const std::vector<Recording>& recordings) {
  std::vector<Score> each(recordings.size());
  parallel_for(recordings.size(), 0, [&](std::size_t k) { each[k] = score(recordings[k], find(recordings[k])); });
  std::array<Score, 2> sum;
  for (std::size_t k = 0; k < recordings.size(); ++k) sum[recordings[k].is_held_out ? 1 : 0] += each[k];
  return sum;
}

void print(std::string_view what, const std::array<Score, 2>& parts) {
  fmt::print("{:<36}", what);
  for (const Score& s : parts)
    fmt::print("  {:10.1f}  {:5}/{:<5} {:4} extra {:4} in {:.2f} h", s.log_score, s.n_found, s.n_true,
               s.n_true > 0 ? s.n_marks - s.n_found : 0, s.n_invented, s.invented_h);
  fmt::print("\n");
  std::fflush(stdout);
}

void print_recording(const Recording& r) {
  const Found found = find(r);
  const Score s = score(r, found);
  if (r.truth_s ? s.n_found == s.n_true && s.n_marks == s.n_found && found.tracks.size() == 1 : found.tracks.empty())
    return;
  fmt::print("{}: {} of {} impacts, {} marks; drops", r.name, s.n_found, s.n_true, s.n_marks);
  for (const Track& track : found.tracks)
    fmt::print("  {:.2f} s {}x odds {:.1f}", (*found.candidates)[track.impacts[0].candidate].t_s, track.impacts.size(),
               track.log_odds);
  fmt::print("\n");
}

/// Values around one: log odds by steps of a half, others by factors.
std::vector<double> values_around(std::string_view name, double value) {
  std::vector<double> values;
  if (name.ends_with("log_odds") || name == "kTracking.usual_first_change")
    for (const double step : {-2.0, -1.0, -0.5, 0.5, 1.0, 2.0}) values.push_back(value + step);
  else if (name == "kTracking.detection_probability")
    for (const double miss : {0.02, 0.035, 0.1, 0.15}) values.push_back(1.0 - miss);
  else
    for (const double factor : {0.5, 0.7, 1.4, 2.0}) values.push_back(value * factor);
  return values;
}

bool is_of_tracks(const Number& n) { return n.name.starts_with("kTracking."); }

/// The numbers one after the other, each by the value around it with the best score of the part to build on, until none
/// gains anything.
void fit(const std::vector<Recording>& recordings) {
  double best = score_all(recordings)[0].log_score;
  for (bool is_better = true; is_better;) {
    is_better = false;
    for (const Number& n : numbers()) {
      if (!is_of_tracks(n)) continue;
      const double before = n.get();
      double chosen = before;
      std::array<Score, 2> of_chosen;
      for (const double value : values_around(n.name, before)) {
        n.set(value);
        const std::array<Score, 2> scores = score_all(recordings);
        if (scores[0].log_score > best + kLeastGain) {
          best = scores[0].log_score, of_chosen = scores, chosen = value;
        }
      }
      n.set(chosen);
      if (chosen == before) continue;
      is_better = true;
      print(fmt::format("{} {:.4g} -> {:.4g}", n.name, before, chosen), of_chosen);
    }
  }
}

int run(const std::vector<std::string_view>& arguments) {
  std::vector<std::filesystem::path> folders;
  std::vector<std::string> varied;
  bool is_listed = false;
  bool is_fitted = false;
  for (std::size_t k = 0; k < arguments.size(); ++k) {
    if (arguments[k] == "--list") {
      is_listed = true;
    } else if (arguments[k] == "--fit") {
      is_fitted = true;
    } else if (arguments[k] == "--vary" && k + 1 < arguments.size()) {
      varied.emplace_back(arguments[++k]);
    } else if (arguments[k] == "--set" && k + 1 < arguments.size()) {
      set_number(arguments[++k]);
    } else {
      folders.emplace_back(arguments[k]);
    }
  }
  const std::vector<Recording> recordings = read_folders(folders);
  fmt::print("{:<36}  {:<58}  held out\n", "log score", "to build on");
  print("as it is", score_all(recordings));
  if (is_fitted) fit(recordings);
  if (is_listed)
    for (const Recording& r : recordings) print_recording(r);
  if (varied == std::vector<std::string>{"all"}) {
    varied.clear();
    for (const Number& n : numbers())
      if (is_of_tracks(n)) varied.push_back(n.name);
  }
  for (const std::string& name : varied) {
    const Number& n = number_named(name);
    const double before = n.get();
    for (const double value : values_around(name, before)) {
      n.set(value);
      print(fmt::format("{} {:.4g} -> {:.4g}", name, before, value), score_all(recordings));
    }
    n.set(before);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}

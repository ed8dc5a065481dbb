// SPDX-License-Identifier: GPL-3.0-or-later
#include "campaign/campaign_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"
#include "campaign/path_patterns.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kCommands{"detect", "analyze", "loop", "simulate", "calibrate"};

class CampaignReader {
 public:
  explicit CampaignReader(const fs::path& file) : toml_(read_toml_entries(file)) {
    campaign_.file = file;
    campaign_.folder = fs::absolute(file).parent_path();
  }

  Campaign read() {
    for (const TomlSection& section : toml_.sections)
      if (!is_own(section.name)) campaign_.options.sections.push_back(section);
    for (const TomlEntry& entry : toml_.entries) take(entry);
    if (campaign_.command.empty()) refuse("'command' is missing; which command is to run? " + one_of(kCommands));
    if (campaign_.out.empty()) refuse("'out' is missing; where are the results to go?");
    if (!campaign_.takes_recordings() && !recordings_place_.empty())
      refuse(recordings_place_, campaign_.command + " takes no recordings");
    if (campaign_.takes_recordings() && campaign_.recordings.empty())
      refuse("'recordings' is missing: patterns of files, or list = \"FILE\" of their names");
    if (campaign_.takes_recordings() && fs::path(campaign_.out).has_extension())
      refuse("out = '" + printable(campaign_.out) + "': of recordings it is a folder; the tables lie in it");
    check_patterns(campaign_.plates);
    check_patterns(campaign_.dates);
    return std::move(campaign_);
  }

 private:
  static bool is_own(const std::string& section) {
    return section == "jobs" || section == "plates" || section == "dates";
  }
  static std::string one_of(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

  [[noreturn]] void refuse(const std::string& what) const {
    throw InvalidArgument(campaign_.file.string() + ": " + what);
  }
  [[noreturn]] static void refuse(const std::string& place, const std::string& what) {
    throw InvalidArgument(place + ": " + what);
  }
  std::string place_of(const TomlEntry& entry) const {
    return fmt::format("{}: line {}", campaign_.file.string(), entry.line);
  }

  void take(const TomlEntry& entry) {
    TomlEntry plain = entry;
    if (entry.section != "plates" && entry.section != "dates")
      std::replace(plain.key.begin(), plain.key.end(), '_', '-');
    const auto [first, is_new] = lines_.emplace(std::pair{plain.section, plain.key}, entry.line);
    if (!is_new) refuse(place_of(entry), fmt::format("'{}' is given already in line {}", entry.key, first->second));
    if (entry.section.empty())
      take_top(plain);
    else if (entry.section == "plates")
      campaign_.plates.push_back({entry.key, one(entry), place_of(entry)});
    else if (entry.section == "dates")
      campaign_.dates.push_back({entry.key, one(entry), place_of(entry)});
    else if (entry.section == "jobs")
      take_job(plain);
    else
      take_option(plain);
  }

  /// The value of a key that takes one.
  std::string one(const TomlEntry& entry) const {
    if (entry.depth != 0) refuse(place_of(entry), "'" + printable(entry.key) + "' takes one value");
    return entry.values.front().front();
  }
  std::vector<std::string> several(const TomlEntry& entry) const {
    if (entry.depth > 1) refuse(place_of(entry), "'" + printable(entry.key) + "' takes a list of words");
    std::vector<std::string> words;
    for (const auto& value : entry.values) words.push_back(value.front());
    return words;
  }

  void take_top(const TomlEntry& entry) {
    if (entry.key == "command") {
      campaign_.command = one(entry);
      if (std::find(kCommands.begin(), kCommands.end(), campaign_.command) == kCommands.end())
        refuse(place_of(entry),
               "command '" + printable(campaign_.command) + "' is none of those of campaigns: " + one_of(kCommands));
    } else if (entry.key == "out") {
      campaign_.out = path(one(entry), entry);
      while (campaign_.out.size() > 1 && campaign_.out.back() == '/') campaign_.out.pop_back();
    } else if (entry.key == "recordings") {
      recordings_place_ = place_of(entry);
      for (const std::string& pattern : several(entry)) {
        const auto found = files_of(campaign_.folder, pattern);
        if (found.empty())
          refuse(place_of(entry), fmt::format("no file is called '{}' (in {})", printable(pattern),
                                              printable(campaign_.folder.string())));
        for (const std::string& recording : found) add_recording(recording, entry);
      }
    } else if (entry.key == "list") {
      recordings_place_ = place_of(entry);
      const fs::path list = campaign_.folder / one(entry);
      std::ifstream in(list);
      for (std::string line; std::getline(in, line);)
        if (!line.empty()) add_recording(line, entry);
      if (!in.eof()) refuse(place_of(entry), list.string() + " cannot be read; it holds a recording's name a line");
    } else {
      const std::vector<std::string> keys{"command", "out", "recordings", "list"};
      refuse(place_of(entry), "unknown key '" + printable(entry.key) + "'" + meant(entry.key, keys) +
                                  "; options of a command stand in a section, [" +
                                  (campaign_.command.empty() ? "detect" : campaign_.command) + "]");
    }
  }

  static std::string meant(const std::string& key, const std::vector<std::string>& keys) {
    const std::string nearest = nearest_name(key, keys);
    return nearest.empty() ? "" : "; did you mean '" + nearest + "'?";
  }

  std::string path(std::string text, const TomlEntry& entry) const {
    const bool is_plain =
        std::none_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 32; });
    if (!is_plain) refuse(place_of(entry), "'" + printable(text) + "': a name with a line break cannot be listed");
    return text;
  }

  void add_recording(const std::string& recording, const TomlEntry& entry) {
    if (seen_.insert(recording).second) campaign_.recordings.push_back(path(recording, entry));
  }

  double number(const TomlEntry& entry, double least, double most) const {
    const std::string text = one(entry);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= least && value <= most))
      refuse(place_of(entry),
             fmt::format("{} = '{}': it takes a number from {} to {}", entry.key, printable(text), least, most));
    return value;
  }
  std::int64_t count(const TomlEntry& entry) const {
    const double value = number(entry, 1, 10'000'000);
    if (value != std::floor(value)) refuse(place_of(entry), entry.key + " takes an integer");
    return static_cast<std::int64_t>(value);
  }
  /// A word on a line of #SBATCH, where a blank would begin the next.
  std::string word(const std::string& text, const TomlEntry& entry) const {
    const bool is_word = std::all_of(text.begin(), text.end(), [](char c) {
      return static_cast<unsigned char>(c) > 32 && c != 127 && c != '"' && c != '\'' && c != '\\' && c != '#';
    });
    if (!is_word)
      refuse(place_of(entry), "'" + printable(text) + "': sbatch takes a word without blanks and quotes here");
    return text;
  }

  void take_job(const TomlEntry& entry) {
    JobSettings& jobs = campaign_.jobs;
    const std::map<std::string, std::string*> words{
        {"partition", &jobs.partition}, {"account", &jobs.account},       {"time", &jobs.time},
        {"memory", &jobs.memory},       {"merge-time", &jobs.merge_time}, {"merge-memory", &jobs.merge_memory}};
    const std::map<std::string, std::int64_t*> counts{
        {"shards", &jobs.n_shards}, {"max-jobs", &jobs.n_at_once}, {"cpus", &jobs.n_cpus}};
    if (const auto w = words.find(entry.key); w != words.end()) {
      *w->second = word(one(entry), entry);
    } else if (const auto c = counts.find(entry.key); c != counts.end()) {
      *c->second = count(entry);
    } else if (entry.key == "seconds-per-shard") {
      jobs.seconds_per_shard = number(entry, 1.0, 1e7);
    } else if (entry.key == "sbatch") {
      for (const std::string& option : several(entry)) {
        jobs.sbatch.push_back(word(option, entry));
        if (option.rfind("--", 0) != 0) refuse(place_of(entry), "'" + option + "': options of sbatch begin with --");
      }
    } else {
      std::vector<std::string> keys{"seconds-per-shard", "sbatch"};
      for (const auto& [key, value] : words) keys.push_back(key);
      for (const auto& [key, value] : counts) keys.push_back(key);
      refuse(place_of(entry),
             "unknown key '" + printable(entry.key) + "'" + meant(entry.key, keys) + "; [jobs] has " + one_of(keys));
    }
  }

  void take_option(const TomlEntry& entry) {
    static const std::map<std::string, std::string> elsewhere{{"out", "'out' stands at the top of a campaign's file"},
                                                              {"list", "'list' stands at the top of a campaign's file"},
                                                              {"threads", "a campaign has [jobs] cpus = N"},
                                                              {"shard", "shards are made by [jobs] shards = N"}};
    if (const auto found = elsewhere.find(entry.key); found != elsewhere.end()) refuse(place_of(entry), found->second);
    campaign_.options.entries.push_back(entry);
  }

  /// A pattern that names no recording is a mistake in it.
  void check_patterns(const std::vector<PatternValue>& patterns) const {
    for (const PatternValue& p : patterns)
      if (std::none_of(campaign_.recordings.begin(), campaign_.recordings.end(),
                       [&](const std::string& recording) { return names(p.pattern, recording); }))
        refuse(p.place, "no recording is called '" + printable(p.pattern) + "'");
  }

  TomlEntries toml_;
  Campaign campaign_;
  std::string recordings_place_;
  std::set<std::string> seen_;
  std::map<std::pair<std::string, std::string>, std::int64_t> lines_;
};

bool is_number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && text.back() != '.' &&
         text.find_first_of("xX") == std::string::npos && std::isdigit(static_cast<unsigned char>(text.back())) != 0 &&
         text.front() != '.' && (text.size() == 1 || text.front() != '0' || text[1] == '.');
}

std::string toml_value(const std::string& text) {
  if (text == "true" || text == "false" || is_number(text)) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 32 || c == 127)
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      quoted += c;
  }
  return quoted + "\"";
}

std::string toml_list(const std::vector<std::string>& values) {
  std::vector<std::string> quoted;
  for (const std::string& value : values) quoted.push_back(toml_value(value));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

std::string toml_line(const TomlEntry& entry) {
  if (entry.depth == 0) return fmt::format("{} = {}\n", entry.key, toml_value(entry.values.front().front()));
  std::vector<std::string> values;
  for (const auto& value : entry.values)
    values.push_back(entry.depth == 1 ? toml_value(value.front()) : toml_list(value));
  return fmt::format("{} = [{}]\n", entry.key, fmt::join(values, ", "));
}

}  // namespace

std::string Campaign::command_out() const { return command == "detect" ? out + "/onsets.h5" : out; }

Campaign read_campaign(const fs::path& file) { return CampaignReader(file).read(); }

std::string config_text(const Campaign& campaign, const std::string& out, const std::string& list) {
  std::vector<std::string> sections{campaign.command};
  for (const TomlSection& section : campaign.options.sections)
    if (section.name != campaign.command) sections.push_back(section.name);
  std::string text = "# written by bouncelab campaign; options of its shards\n";
  for (const std::string& name : sections) {
    text += fmt::format("{}[{}]\n", name == campaign.command ? "" : "\n", name);
    if (name == campaign.command) {
      text += fmt::format("out = {}\n", toml_value(out));
      if (!list.empty()) text += fmt::format("list = {}\n", toml_value(list));
      text += fmt::format("threads = {}\n", campaign.jobs.n_cpus);
    }
    for (const TomlEntry& entry : campaign.options.entries)
      if (entry.section == name) text += toml_line(entry);
  }
  return text;
}

}  // namespace bouncelab::cli

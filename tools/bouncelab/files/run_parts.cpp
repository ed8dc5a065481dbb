// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/run_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/version.hpp"
#include "files/provenance.hpp"
#include "files/table_file.hpp"
#include "json/json_text.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

const char* const kEnding = ".part";
const char* const kUnfinishedEnding = ".unfinished";
const std::string kAboutItem;  // of the record that is about the run; no item's name is empty

fs::path folder_of_parts(const fs::path& out) {
  fs::path folder = out;
  if (!folder.has_filename()) folder = folder.parent_path();  // out/ is the folder out
  return folder += ".parts";
}

/// The arguments without --shard.
std::vector<std::string> of_whole_run(const std::vector<std::string>& arguments) {
  std::vector<std::string> whole;
  for (auto argument = arguments.begin(); argument != arguments.end(); ++argument) {
    if (*argument == "--shard" && std::next(argument) != arguments.end())
      ++argument;
    else if (!argument->starts_with("--shard="))
      whole.push_back(*argument);
  }
  return whole;
}

std::string about(const Run& run) {
  nlohmann::json sweep = nlohmann::json::array();
  for (const loop::SweepAxis& axis : run.sweep) sweep.push_back({axis.option, axis.values});
  const nlohmann::json json{{"command", run.command},
                            {"arguments", of_whole_run(run.arguments)},
                            {"sweep", sweep},
                            {"folder", fs::current_path().string()}};
  return json_text(json);
}

std::string shard_text(const Shard& shard) { return fmt::format("shard-{}-of-{}", shard.index, shard.n); }

/// "3, 7, 8 and 12 more"
std::string some_of(const std::vector<int>& numbers) {
  constexpr std::size_t kMost = 8;
  std::string text;
  for (std::size_t k = 0; k < std::min(kMost, numbers.size()); ++k)
    text += (k > 0 ? ", " : "") + std::to_string(numbers[k]);
  if (numbers.size() > kMost) text += fmt::format(" and {} more", numbers.size() - kMost);
  return text;
}

/// In how many shards the run was done, by the name of a part; 0 where the file has another name.
int n_shards(const fs::path& part) {
  const std::string name = part.stem().string();
  const auto at = name.rfind("-of-");
  if (at == std::string::npos) return 0;
  const std::string digits = name.substr(at + 4);
  const bool is_number = !digits.empty() && digits.size() < 9 &&
                         std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  return is_number ? std::stoi(digits) : 0;
}

std::string text_at(FileBytes& file, std::int64_t first_byte, std::int64_t n_bytes) {
  std::string text;
  text.reserve(static_cast<std::size_t>(n_bytes));
  constexpr std::int64_t kAtOnce = 1 << 18;
  for (std::int64_t done = 0; done < n_bytes; done += kAtOnce) {
    const auto bytes = file.at(first_byte + done, std::min(kAtOnce, n_bytes - done));
    text.append(bytes.begin(), bytes.end());
  }
  return text;
}

/// What is missing, and what to do.
[[noreturn]] void refuse_incomplete(const std::vector<std::size_t>& missing, const std::vector<std::string>& items,
                                    int n) {
  std::string shards;
  if (n > 0) {
    std::vector<int> numbers;
    for (const std::size_t k : missing) numbers.push_back(static_cast<int>(k % static_cast<std::size_t>(n)) + 1);
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    shards = fmt::format(": shard{} {} of {}; run {} again", numbers.size() == 1 ? "" : "s", some_of(numbers), n,
                         numbers.size() == 1 ? "it" : "them");
  }
  throw InvalidArgument(fmt::format("the parts are not complete: {} of {} items are missing, the first is '{}'{}",
                                    missing.size(), items.size(), items[missing.front()], shards));
}

}  // namespace

loop::RunIdentity run_identity(const Run& run, const std::vector<fs::path>& inputs,
                               const std::vector<std::string>& left_out) {
  loop::RunIdentity identity{{"version", std::string(version())}, {"commit", std::string(commit())}};
  const std::vector<std::string> only_how{"threads", "quiet", "json", "force", "config", "out", "shard"};
  const auto holds = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto add = [&](const std::string& name, const std::vector<std::string>& values) {
    std::string text;
    for (const std::string& value : values) text += (text.empty() ? "" : ",") + value;
    identity.emplace_back(name, text);
  };
  for (const Parameter& p : run.parameters)
    if (!holds(only_how, p.name) && !holds(left_out, p.name)) add(p.name, p.values);
  for (const loop::SweepAxis& axis : run.sweep) add("list of " + axis.option, axis.values);
  for (const fs::path& input : inputs) identity.emplace_back("SHA-256 of " + input_name(input), sha256_of_file(input));
  return identity;
}

PartFile::PartFile(const Run& run, const fs::path& out, const loop::RunIdentity& identity,
                   const std::vector<std::string>& items, const IsCurrent& is_current)
    : run_(run), items_(items) {
  const fs::path folder = folder_of_parts(out);
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error)) throw FileError(folder.string(), "cannot be made a folder for the parts");
  const std::string name = shard_text(*run.shard);
  part_ = folder / (name + kEnding);
  unfinished_ = folder / (name + kUnfinishedEnding);
  if (run.common.force) {
    fs::remove(part_);
    fs::remove(unfinished_);
  }
  const bool was_complete = !fs::exists(unfinished_) && fs::exists(part_);
  if (was_complete) fs::rename(part_, unfinished_);
  std::unordered_map<std::string, bool> done;
  const auto take = [&](const std::string& item, std::string_view record) {
    done[item] = item == kAboutItem || !is_current || is_current(item, record);
  };
  try {
    journal_ = std::make_unique<loop::RunJournal>(unfinished_, identity, take);
  } catch (const InvalidArgument& failure) {
    throw InvalidArgument(std::string(failure.what()) +
                          "; use the same settings to continue, another --out, or --force to start anew");
  }
  goes_on_ = done.contains(kAboutItem);
  if (!goes_on_) journal_->append(kAboutItem, about(run));
  for (std::size_t k = static_cast<std::size_t>(run.shard->index) - 1; k < items.size();
       k += static_cast<std::size_t>(run.shard->n), ++n_own_)
    if (const auto found = done.find(items[k]); found == done.end() || !found->second) pending_.push_back(k);
  // complete, and yet not: the run has other items than before, and what is here now may have been done elsewhere
  if (was_complete && !pending_.empty()) take_from_other_parts(identity, is_current);
  for (const std::size_t k : pending_) pending_names_.insert(items[k]);
}

void PartFile::take_from_other_parts(const loop::RunIdentity& identity, const IsCurrent& is_current) {
  std::unordered_map<std::string, std::size_t> wanted;
  for (const std::size_t k : pending_) wanted[items_[k]] = k;
  for (const auto& file : fs::directory_iterator(part_.parent_path())) {
    const bool is_part = file.path().extension() == kEnding || file.path().extension() == kUnfinishedEnding;
    if (!is_part || file.path() == unfinished_) continue;
    try {
      const loop::ReadJournal other = loop::read_journal(file.path());
      if (other.identity != identity) continue;
      FileBytes bytes(file.path());
      for (const loop::JournalEntry& entry : other.entries) {
        const auto found = wanted.find(entry.item);
        if (found == wanted.end()) continue;
        const std::string record = text_at(bytes, entry.first_byte, entry.n_bytes);
        if (is_current && !is_current(entry.item, record)) continue;
        keep(found->second, record);
        std::erase(pending_, found->second);
        wanted.erase(found);
      }
    } catch (const Error&) {
      // it got its other name meanwhile, or is none of ours: its items are done here
    }
  }
}

void PartFile::keep(std::size_t item, std::string_view record) { journal_->append(items_[item], record); }

Outcome PartFile::finish(const std::vector<fs::path>& inputs, const std::string& unit) {
  const std::string origin = provenance(run_, inputs);
  journal_.reset();
  fs::rename(unfinished_, part_);
  write_provenance(part_, origin);
  Outcome outcome;
  const std::size_t n_before = n_own_ - pending_.size();
  outcome.text = fmt::format("shard {} of {}: {} {} done{}, in {}\n", run_.shard->index, run_.shard->n, n_own_, unit,
                             n_before > 0 ? fmt::format(" ({} of them before)", n_before) : "", part_.string());
  outcome.json = json_text(nlohmann::ordered_json{{"shard", run_.shard->index},
                                                  {"of", run_.shard->n},
                                                  {"n_items", n_own_},
                                                  {"n_done_before", n_before},
                                                  {"part", part_.string()}},
                           2);
  return outcome;
}

RunParts::RunParts(const Run& run, const loop::RunIdentity& identity, const std::vector<std::string>& items)
    : paths_(run.parts) {
  std::unordered_map<std::string, Place> places;
  for (std::size_t file = 0; file < paths_.size(); ++file) {
    const loop::ReadJournal part = loop::read_journal(paths_[file]);
    if (part.identity != identity)
      throw InvalidArgument(paths_[file].string() + ": is a part of another run (" +
                            loop::first_difference(part.identity, identity) + ")");
    for (const loop::JournalEntry& entry : part.entries) places[entry.item] = {file, entry.first_byte, entry.n_bytes};
  }
  std::vector<std::size_t> missing;
  for (std::size_t k = 0; k < items.size(); ++k) {
    const auto found = places.find(items[k]);
    if (found == places.end())
      missing.push_back(k);
    else
      places_.push_back(found->second);
  }
  if (!missing.empty()) refuse_incomplete(missing, items, n_shards(paths_.front()));
}

std::string RunParts::record(std::size_t item) {
  const Place& place = places_.at(item);
  if (!file_ || open_ != place.file) file_ = std::make_unique<FileBytes>(paths_[open_ = place.file]);
  return text_at(*file_, place.first_byte, place.n_bytes);
}

AboutRun about_run(const fs::path& part) {
  for (const loop::JournalEntry& entry : loop::read_journal(part).entries) {
    if (entry.item != kAboutItem) continue;
    FileBytes file(part);
    const auto bytes = file.at(entry.first_byte, entry.n_bytes);
    const auto json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
    if (!json.is_object()) break;
    try {
      AboutRun run{json.at("command"), json.at("arguments"), {}, std::string(json.at("folder"))};
      for (const auto& axis : json.at("sweep")) run.sweep.push_back({axis.at(0), axis.at(1)});
      return run;
    } catch (const nlohmann::json::exception&) {
      break;
    }
  }
  throw FileError(part.string(), "does not say what run it is a part of");
}

std::vector<fs::path> part_files(const std::vector<fs::path>& given) {
  std::vector<fs::path> files;
  std::string unfinished;
  for (const fs::path& path : given) {
    if (!fs::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(path)) {
      if (entry.path().extension() == kEnding) files.push_back(entry.path());
      if (entry.path().extension() == kUnfinishedEnding) unfinished = entry.path().string();
    }
  }
  if (files.empty() && unfinished.empty())
    throw FileError(given.front().string(), "holds no part of a run; parts are written by COMMAND ... --shard 1/N");
  if (files.empty()) throw FileError(unfinished, "is not finished, and no other part is there; run its shard again");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace bouncelab::cli

// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/provenance.hpp"

#include <fmt/format.h>
#include <nettle/sha2.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ctime>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <tuple>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::stages {
namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

Object object_of_parameters(const Parameters& parameters) {
  Object object;
  for (const Parameter& p : parameters)
    object.emplace_back(p.name, p.values.size() == 1 ? Value(p.values.front()) : Value(p.values));
  return object;
}

std::string computed_sha256(const fs::path& path) {
  FileBytes file(path);
  Sha256 sum;
  std::vector<std::byte> piece(std::size_t{1} << 18);  // stays in the cache between the system's copy and its use
  for (std::int64_t at = 0, n = 1; n > 0; at += n) {
    throw_if_stop_requested();
    n = file.read(at, piece);
    sum.add(piece.data(), static_cast<std::size_t>(n));
  }
  file.check();
  return sum.in_hexadecimal();
}

/// Discarded where it is none, or longer than a provenance is.
Json json_in(const fs::path& path) {
  FileBytes bytes(path);
  constexpr std::int64_t kMost = 1 << 25;  // of 100,000 recordings with long names
  return Json::parse(bytes.text(0, static_cast<std::size_t>(std::min(kMost, bytes.size()))), nullptr, false);
}

/// Options that say what was simulated.
constexpr std::array kConditions{"ball", "plate", "drag", "gravity"};

/// A text of a provenance or of one of its inputs; absent where it has none of that name.
std::optional<std::string> text_in(const Json& object, const std::string& name) {
  if (!object.is_object() || !object.contains(name) || !object[name].is_string()) return std::nullopt;
  return object[name].get<std::string>();
}

/// The inputs that a provenance names, in their order.
Json inputs_in(const Json& meta) {
  return meta.is_object() && meta.contains("inputs") && meta["inputs"].is_array() ? meta["inputs"] : Json::array();
}

/// The sum of the output that a provenance is of, or of an input; empty where it has none.
std::string sum_in(const Json& meta) { return text_in(meta, "sha256").value_or(""); }

/// null where there is none. @throws FileError where it is not JSON
Json provenance_beside(const fs::path& file) {
  const fs::path path = provenance_path(file);
  if (!is_unnamed_file(path)) return {};
  Json meta = json_in(path);
  if (meta.is_discarded())
    throw FileError(path.string(), "is not JSON, as what is known of the file beside it would be; delete it");
  return meta;
}

/// Whether the file has the content that the provenance was written for.
bool is_of(const Json& meta, const fs::path& file) {
  const std::string sum = sum_in(meta);
  return sum.empty() || sum == sha256_of_file(file);
}

}  // namespace

std::string Sha256::in_hexadecimal() {
  std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest{};
  sha256_digest(&state_, digest.size(), digest.data());
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

std::string sha256_of(const std::string& text) {
  Sha256 sum;
  sum.add(text.data(), text.size());
  return sum.in_hexadecimal();
}

bool are_unchanged_and_of(const std::vector<fs::path>& outputs, const std::vector<fs::path>& inputs) {
  std::vector<std::string> of_inputs, named;
  for (const fs::path& input : inputs) of_inputs.push_back(sha256_of_file(input));
  for (const Json& input : inputs_in(provenance_beside(outputs.front())))
    if (const auto sum = text_in(input, "sha256")) named.push_back(*sum);
  if (named != of_inputs) return false;
  return std::all_of(outputs.begin(), outputs.end(), [](const fs::path& output) {
    return !is_unnamed_file(output) || sum_in(provenance_beside(output)) == sha256_of_file(output);
  });
}

bool is_made_of_another(const fs::path& output, const fs::path& input) {
  const Json inputs = inputs_in(provenance_beside(output));
  return std::any_of(inputs.begin(), inputs.end(), [&](const Json& named) {
    const std::optional<std::string> name = text_in(named, "path");
    return name && fs::path(*name).filename() == input.filename() && !sum_in(named).empty() &&
           sum_in(named) != sha256_of_file(input);
  });
}

std::string sha256_of_file(const fs::path& path) {
  // device, inode, size, time of the last change: what tells a content from others, and from its own after a change
  using Content = std::tuple<dev_t, ino_t, off_t, std::time_t, long>;
  static std::mutex mutex;
  static std::map<Content, std::string> known;
  struct stat status {};
  // written to in the clock's last ticks a file may be so again, at the same time as the system counts it
  if (::stat(readable(path).c_str(), &status) != 0 || std::time(nullptr) - status.st_mtim.tv_sec < 2)
    return computed_sha256(path);
  const Content content{status.st_dev, status.st_ino, status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
  {
    const std::lock_guard lock(mutex);
    if (const auto found = known.find(content); found != known.end()) return found->second;
  }
  std::string sum = computed_sha256(path);
  const std::lock_guard lock(mutex);
  return known[content] = std::move(sum);
}

void while_summing(const std::vector<fs::path>& files, int n_threads, const std::function<void()>& work) {
  parallel_for(2, n_threads, [&](std::size_t part) {
    if (part == 0) return work();
    parallel_for(files.size(), n_threads, [&](std::size_t k) {
      try {
        sha256_of_file(files[k]);
      } catch (const FileError&) {  // said by whoever reads the sound
      }
    });
  });
}

fs::path provenance_path(const fs::path& output) { return fs::path(output) += ".meta.json"; }

bool is_provenance(const fs::path& path) {
  const Json meta = json_in(path);
  return meta.is_object() && meta.contains("command_line") && meta.contains("commit");
}

std::optional<std::string> parameter_in_provenance(const fs::path& file, const std::string& option) {
  if (file.empty() || is_stream(file)) return std::nullopt;
  const Json meta = provenance_beside(file);
  if (!meta.is_object() || !meta.contains("parameters") || !is_of(meta, file)) return std::nullopt;
  return text_in(meta["parameters"], option);
}

std::vector<Note> notes_on_provenance(const std::vector<fs::path>& files) {
  std::vector<Note> notes;
  for (const fs::path& file : files) {
    if (file.empty() || is_stream(file)) continue;
    const Json meta = provenance_beside(file);
    if (!meta.is_object() || !meta.contains("parameters") || is_of(meta, file)) continue;
    const bool has_conditions = std::any_of(kConditions.begin(), kConditions.end(), [&](const char* option) {
      return !text_in(meta["parameters"], option).value_or("").empty();
    });
    if (has_conditions)
      notes.push_back({NoteKind::of_file,
                       {},
                       provenance_path(file).string() +
                           " is of another content than this file has now; its ball, plate and gravity are not taken"});
  }
  return notes;
}

std::string provenance(const Run& run, const std::vector<fs::path>& inputs, const std::string& sha256) {
  Values files;
  for (const fs::path& input : inputs)
    files.push_back(Object{{"path", input_name(input)}, {"sha256", sha256_of_file(input)}});
  Object meta{{"command_line", run.command_line},
              {"version", std::string(version())},
              {"commit", std::string(commit())},
              {"seed", run.common.seed},
              {"inputs", files}};
  if (!sha256.empty()) meta.emplace_back("sha256", sha256);
  if (std::string ffmpeg = audio::ffmpeg_version_used(); !ffmpeg.empty()) meta.emplace_back("ffmpeg", ffmpeg);
  meta.emplace_back("parameters", object_of_parameters(run.parameters));
  return json_text(meta, 2) + "\n";
}

void commit_with_provenance(OutputFile& file, const fs::path& output, const std::string& provenance) {
  if (is_stream(output)) return file.commit();
  const fs::path path = provenance_path(output);
  OutputFile beside(path, true);
  beside.write(provenance);
  file.commit();  // both are written: what is left are two changes of names
  beside.commit();
}

void write_provenance(const fs::path& output, const std::string& provenance) {
  if (is_stream(output)) return;  // nothing can lie beside it
  write_whole(provenance_path(output), provenance, true);
}

}  // namespace bouncelab::stages

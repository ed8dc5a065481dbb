// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/recording_records.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <sstream>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/loop/records.hpp"
#include "files/provenance.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

/// Without the sum.
FileContent size_and_time(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
  return {status.st_size, status.st_mtim.tv_sec * kNanosecondsPerSecond + status.st_mtim.tv_nsec, {}};
}

std::string sum_if_readable(const fs::path& file) {
  try {
    return sha256_of_file(file);
  } catch (const FileError&) {
    return {};
  }
}

/// In front of the record: "BYTES NANOSECONDS SHA256 ", without the sum where there is none.
std::string text_of(const FileContent& content) {
  return fmt::format("{} {} {} ", content.n_bytes, content.modified_ns, content.sha256);
}

struct Parsed {
  FileContent content;
  std::string_view detection;
};

Parsed parsed(std::string_view record) {
  const auto begin = record.find('[');
  if (begin == std::string_view::npos) throw InvalidArgument("a record is not of the form expected");
  Parsed result{{}, record.substr(begin)};
  std::istringstream front{std::string(record.substr(0, begin))};
  front >> result.content.n_bytes >> result.content.modified_ns >> result.content.sha256;
  return result;
}

/// A file that was copied has another time and the same content.
bool is_as_it_was(const fs::path& file, const FileContent& before) {
  const FileContent now = size_and_time(file);
  if (now.n_bytes != before.n_bytes) return false;
  return now.modified_ns == before.modified_ns || sum_if_readable(file) == before.sha256;
}

std::vector<std::string> names_of(const std::vector<fs::path>& recordings) {
  std::vector<std::string> names;
  for (const fs::path& recording : recordings) {
    if (recording == "-") throw InvalidArgument("standard input cannot be divided into parts; name a file");
    names.push_back(recording.string());
  }
  return names;
}

/// Recordings are items of their own; what follows detection is done when the parts are put together.
loop::RunIdentity identity(const Run& run) { return run_identity(run, {}, {"recordings", "list", "labels"}); }

}  // namespace

RecordingPart::RecordingPart(const Run& run, const fs::path& out, const std::vector<fs::path>& recordings,
                             bool with_details)
    : with_details_(with_details),
      part_(run, out, identity(run), names_of(recordings), [](const std::string& item, std::string_view record) {
        return is_as_it_was(item, parsed(record).content);
      }) {
  for (const std::size_t k : part_.pending()) {
    pending_.push_back(recordings[k]);
    content_.push_back(size_and_time(recordings[k]));
  }
  for (std::size_t k = static_cast<std::size_t>(run.shard->index) - 1; k < recordings.size();
       k += static_cast<std::size_t>(run.shard->n))
    own_.push_back(recordings[k]);
}

void RecordingPart::keep(std::size_t k, const detection::Detection& found) {
  content_[k].sha256 = sum_if_readable(pending_[k]);
  part_.keep(part_.pending()[k], text_of(content_[k]) + loop::to_record(found, with_details_));
}

Outcome RecordingPart::finish() {
  std::vector<fs::path> readable;
  for (const fs::path& recording : own_)
    if (!sum_if_readable(recording).empty()) readable.push_back(recording);
  return part_.finish(readable, "recordings");
}

RecordingRecords::RecordingRecords(const Run& run, const std::vector<fs::path>& recordings)
    : parts_(run, identity(run), names_of(recordings)) {
  for (std::size_t k = 0; k < recordings.size(); ++k) place_of_[recordings[k]] = k;
  std::vector<fs::path> changed;
  for (const auto& [recording, k] : place_of_) {
    const FileContent content = parsed(parts_.record(k)).content;
    if (!is_as_it_was(recording, content))
      changed.push_back(recording);
    else if (!content.sha256.empty())
      know_sha256(recording, content.sha256);
  }
  if (!changed.empty())
    throw InvalidArgument(fmt::format("{}{} changed after detection; run the shards again, which do what changed",
                                      printable(changed.front().string()),
                                      changed.size() > 1 ? fmt::format(" and {} more", changed.size() - 1) : ""));
}

detection::Detection RecordingRecords::detection(const fs::path& recording) {
  return loop::detection_from_record(parsed(parts_.record(place_of_.at(recording))).detection, input_name(recording));
}

}  // namespace bouncelab::cli

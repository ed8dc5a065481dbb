// SPDX-License-Identifier: GPL-3.0-or-later
/// What was detected in each recording, as records of the parts of a run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "files/run_parts.hpp"

namespace bouncelab::cli {

/// Which content of a file a record is about.
struct FileContent {
  std::int64_t n_bytes = -1;     ///< -1: it could not be read
  std::int64_t modified_ns = 0;  ///< time of its last change
  std::string sha256;            ///< empty: it could not be read
};

/// The recordings of one shard.
class RecordingPart {
 public:
  /// @param with_details  as loop::to_record
  /// @throws as PartFile
  RecordingPart(const Run& run, const std::filesystem::path& out, const std::vector<std::filesystem::path>& recordings,
                bool with_details);
  /// Those to be done: the others are done already, and their files are as they were.
  const std::vector<std::filesystem::path>& pending() const { return pending_; }
  /// @param k  of pending()
  void keep(std::size_t k, const detection::Detection& found);
  Outcome finish();

 private:
  bool with_details_;
  PartFile part_;
  std::vector<std::filesystem::path> pending_, own_;
  std::vector<FileContent> content_;  ///< of the pending ones, before they were read
};

/// The recordings of all shards.
class RecordingRecords {
 public:
  /// @throws as RunParts; InvalidArgument where a recording is not as it was
  RecordingRecords(const Run& run, const std::vector<std::filesystem::path>& recordings);
  detection::Detection detection(const std::filesystem::path& recording);

 private:
  RunParts parts_;
  std::map<std::filesystem::path, std::size_t> place_of_;
};

}  // namespace bouncelab::cli

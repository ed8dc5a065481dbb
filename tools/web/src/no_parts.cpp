// SPDX-License-Identifier: GPL-3.0-or-later
// The page has no runs in several parts: what commands do with them is never called.
#include "bouncelab/core/error.hpp"
#include "bouncelab/loop/records.hpp"
#include "files/recording_records.hpp"
#include "files/run_parts.hpp"

namespace bouncelab::loop {
namespace {

[[noreturn]] void refuse() { throw InvalidArgument("runs in several parts are the program's only"); }

}  // namespace

RunJournal::~RunJournal() = default;
std::string to_record(const sim::DropResult&) { refuse(); }
sim::DropResult simulated_drop_from_record(std::string_view) { refuse(); }
std::string to_record(const synthesis::DropTruth&, const synthesis::SynthesisResult&) { refuse(); }
SynthesizedFile synthesized_file_from_record(std::string_view, const std::filesystem::path&) { refuse(); }
std::string to_record(const fit::Replicate&) { refuse(); }
fit::Replicate replicate_from_record(std::string_view) { refuse(); }

}  // namespace bouncelab::loop

namespace bouncelab::cli {
namespace fs = std::filesystem;
using loop::refuse;

loop::RunIdentity run_identity(const Run&, const std::vector<fs::path>&, const std::vector<std::string>&) { return {}; }

PartFile::PartFile(const Run& run, const fs::path&, const loop::RunIdentity&, const std::vector<std::string>&,
                   const IsCurrent&)
    : run_(run) {
  refuse();
}
void PartFile::keep(std::size_t, std::string_view) { refuse(); }
Outcome PartFile::finish(const std::vector<fs::path>&, const std::string&) { refuse(); }

RunParts::RunParts(const Run&, const loop::RunIdentity&, const std::vector<std::string>&) { refuse(); }
std::string RunParts::record(std::size_t) { refuse(); }

RecordingPart::RecordingPart(const Run& run, const fs::path& out, const std::vector<fs::path>&, bool with_details)
    : with_details_(with_details), part_(run, out, {}, {}) {}
void RecordingPart::keep(std::size_t, const detection::Detection&) { refuse(); }
Outcome RecordingPart::finish() { refuse(); }

RecordingRecords::RecordingRecords(const Run& run, const std::vector<fs::path>&) : parts_(run, {}, {}) {}
detection::Detection RecordingRecords::detection(const fs::path&) { refuse(); }

}  // namespace bouncelab::cli

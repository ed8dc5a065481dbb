// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nettle/sha2.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/files.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// A SHA-256 of bytes that come in pieces.
class Sha256 {
 public:
  Sha256() { sha256_init(&state_); }
  void add(const void* bytes, std::size_t n) { sha256_update(&state_, n, static_cast<const std::uint8_t*>(bytes)); }
  std::string in_hexadecimal();

 private:
  sha256_ctx state_;
};

/// SHA-256 of a file's content, in hexadecimal; computed once, unless the file changes. From any thread.
/// @throws FileError, Interrupted
std::string sha256_of_file(const std::filesystem::path& path);

/// Does `work`, and meanwhile, as a thread has time for it, computes what sha256_of_file() will be asked for. What
/// cannot be read is passed over; of a file that was written to in the last two seconds the sum cannot be kept.
/// @throws Interrupted, what work threw
void while_summing(const std::vector<std::filesystem::path>& files, int n_threads, const std::function<void()>& work);

/// OUTPUT.meta.json
std::filesystem::path provenance_path(const std::filesystem::path& output);

/// Whether a file is a provenance that this program wrote.
bool is_provenance(const std::filesystem::path& path);

/// The value of an option of the command that wrote a file, or of what it kept of its input (keep_world).
/// Absent where no provenance lies beside the file, it is that of another content, or has no such option.
/// @throws FileError where a provenance is none
std::optional<std::string> parameter_in_provenance(const std::filesystem::path& file, const std::string& option);

/// A warning for each file whose provenance states a ball, a plate, gravity or drag of another content: the file was
/// changed or replaced, and none of them is taken. @throws FileError as parameter_in_provenance
std::vector<Note> notes_on_provenance(const std::vector<std::filesystem::path>& files);

/// SHA-256 of a text, in hexadecimal.
std::string sha256_of(const std::string& text);

/// Did this program make the outputs from these very inputs, and has nobody changed one since? So say the provenances:
/// that of the first names the inputs, and each output that is there has the SHA-256 that its own states. @throws
/// FileError where an input cannot be read
bool are_unchanged_and_of(const std::vector<std::filesystem::path>& outputs,
                          const std::vector<std::filesystem::path>& inputs);

/// Does the provenance of an output say that it was made of another content of this file, by its name?
/// @throws FileError where a provenance is none
bool is_made_of_another(const std::filesystem::path& output, const std::filesystem::path& input);

/// What is told of an output: command line, version, commit, seed, inputs with their SHA-256, and all parameters as
/// resolved. Made before the output gets its name, so that an input that cannot be read again leaves no output behind.
/// @param sha256  of the output, where it is known. @throws FileError, Interrupted
std::string provenance(const Run& run, const std::vector<std::filesystem::path>& inputs,
                       const std::string& sha256 = {});

/// Puts an output in its place, and its provenance beside it: both, or neither. @throws FileError
void commit_with_provenance(OutputFile& file, const std::filesystem::path& output, const std::string& provenance);
/// Writes the provenance beside an output, unless that is a stream. @throws FileError
void write_provenance(const std::filesystem::path& output, const std::string& provenance);

}  // namespace bouncelab::stages

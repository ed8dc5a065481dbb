// SPDX-License-Identifier: GPL-3.0-or-later
// Where no other program can be started (a browser, which decodes by itself what ffmpeg would): none is installed.
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/program_output.hpp"

namespace bouncelab {

std::optional<std::filesystem::path> find_program(const std::string&) { return std::nullopt; }

ProgramOutput::ProgramOutput(const std::filesystem::path& program, std::vector<std::string>, std::string file, int,
                             double, bool)
    : file_(std::move(file)) {
  throw FileError(file_, program.string() + " cannot be started here");
}
ProgramOutput::~ProgramOutput() = default;
std::size_t ProgramOutput::read(std::span<std::byte>) { return 0; }
bool ProgramOutput::ended_well() { return false; }

ProgramResult run_program(const std::filesystem::path&, const std::vector<std::string>&, const std::string&, int,
                          double, std::size_t) {
  return {};
}

}  // namespace bouncelab

// SPDX-License-Identifier: GPL-3.0-or-later
// In the page's file system nothing is kept: outputs have no provenance beside them. Sums of content tell recordings
// apart, of which a page has one.
#include "bouncelab/core/input_file.hpp"
#include "files/provenance.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

std::string sha256_of_file(const fs::path& path) { return input_name(path); }
void compute_sha256_ahead(const std::vector<fs::path>&, int) {}
fs::path provenance_path(const fs::path& output) { return fs::path(output) += ".meta.json"; }
std::optional<std::string> parameter_in_provenance(const fs::path&, const std::string&) { return std::nullopt; }
std::string provenance(const Run&, const std::vector<fs::path>&) { return {}; }
void write_provenance(const fs::path&, const std::string&) {}

}  // namespace bouncelab::cli

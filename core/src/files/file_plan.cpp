// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/file_plan.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/text.hpp"
#include "files/file_target.hpp"

namespace bouncelab {
namespace fs = std::filesystem;

namespace {

/// The same for names of the same file: thousands of inputs are compared with each other.
using Identity = std::pair<std::pair<dev_t, ino_t>, fs::path>;
Identity identity_of(const FileTarget& target) {
  if (target.kind == FileTarget::Kind::absent) return {{0, 0}, target.path};
  return {{target.device, target.inode}, {}};
}

/// What is wrong with an input is left to its reader.
FileTarget target_of_input(const fs::path& path) {
  try {
    return target_of(path, 0);
  } catch (const FileError&) {
    return {FileTarget::Kind::absent, path, -1, 0, 0, 0};
  }
}

/// A terminal is read from and written to at once, and the null device holds nothing to lose.
bool is_shared(const FileTarget& target) { return S_ISCHR(target.mode); }

std::string output_name(const fs::path& path) { return path == "-" ? "standard output" : printable(path.string()); }

/// "a and b", or "a" where both have the same name.
std::string both(const std::string& a, const std::string& b) { return a == b ? a : a + " and " + b; }

}  // namespace

void check_files(const std::vector<fs::path>& inputs, const std::vector<fs::path>& outputs,
                 const std::vector<fs::path>& beside, bool may_replace) {
  std::map<Identity, fs::path> read, written;
  for (const fs::path& path : inputs) {
    if (path.empty()) continue;
    const FileTarget target = target_of_input(path);
    const auto [first, is_new] = read.emplace(identity_of(target), path);
    if (!is_new && target.kind == FileTarget::Kind::stream)
      throw InvalidArgument(both(printable(input_name(path)), printable(input_name(first->second))) +
                            ": can be read only once; name it once, or give a file");
  }
  const auto add = [&](const fs::path& path) {
    const FileTarget target = target_of(path, 1);
    if (target.is_null()) return;
    const auto input = read.find(identity_of(target));
    if (input != read.end() && !is_shared(target))
      throw InvalidArgument(output_name(path) + ": is the input " + printable(input_name(input->second)) +
                            ", which would be lost; choose another name for the output");
    const auto [first, is_new] = written.emplace(identity_of(target), path);
    if (!is_new)
      throw InvalidArgument(both(output_name(path), output_name(first->second)) +
                            ": two outputs would go to the same file; choose different names");
  };
  for (const fs::path& path : outputs)
    if (!path.empty()) add(path);
  for (const fs::path& path : beside) add(path);
  for (const fs::path& path : outputs)
    if (!path.empty()) OutputFile probe(path, may_replace);  // vanishes again; throws where nothing can be written
  for (const auto& [identity, path] : read)
    if (target_of_input(path).kind == FileTarget::Kind::stream) readable(path);
}

}  // namespace bouncelab

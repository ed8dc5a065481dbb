// SPDX-License-Identifier: GPL-3.0-or-later
#include "files.hpp"

#include <fstream>
#include <sstream>

#include "bouncelab/core/error.hpp"

namespace bouncelab::web {
namespace fs = std::filesystem;

namespace {

const char* const kFolder = "/bouncelab";

}  // namespace

WorkingFolder::WorkingFolder() {
  fs::remove_all(kFolder);
  fs::create_directories(kFolder);
  fs::current_path(kFolder);
}

WorkingFolder::~WorkingFolder() {
  std::error_code error;
  fs::current_path("/", error);
  fs::remove_all(kFolder, error);
}

std::string file_name(const std::string& name) {
  const std::string last = fs::path(name).filename().string();
  return last.empty() || last == "." || last == ".." || last == "-" ? "recording" : last;
}

void write_file(const fs::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw FileError(path.string(), "there is no memory for it");
}

std::string read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace bouncelab::web

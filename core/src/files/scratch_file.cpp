// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/scratch_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "files/temporary_file.hpp"

namespace bouncelab {

struct ScratchFile::State {
  std::string name;
  Descriptor file;
  std::int64_t size = 0;
};

ScratchFile::ScratchFile(const std::filesystem::path& folder, std::string name) : state_(std::make_unique<State>()) {
  state_->name = std::move(name);
  try {
    state_->file = make_nameless_file(folder);
  } catch (const std::system_error& error) {
    throw FileError(state_->name,
                    "a temporary file in " + folder.string() + " cannot be made: " + error.code().message());
  }
}

ScratchFile::ScratchFile(ScratchFile&&) noexcept = default;
ScratchFile& ScratchFile::operator=(ScratchFile&&) noexcept = default;
ScratchFile::~ScratchFile() = default;

std::int64_t ScratchFile::append(std::string_view bytes) {
  if (const int error = write_all(state_->file.get(), bytes.data(), bytes.size()); error != 0)
    throw FileError(state_->name, why_writing_failed(error));
  return std::exchange(state_->size, state_->size + std::ssize(bytes));
}

std::string ScratchFile::at(std::int64_t first, std::size_t n) const {
  std::string bytes(n, '\0');
  for (std::size_t done = 0; done < n;) {
    const ssize_t got =
        ::pread(state_->file.get(), bytes.data() + done, n - done, first + static_cast<std::int64_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw FileError(state_->name, "its temporary file cannot be read: " + std::string(std::strerror(errno)));
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace bouncelab

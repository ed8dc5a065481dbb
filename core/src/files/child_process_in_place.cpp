// SPDX-License-Identifier: GPL-3.0-or-later
// ChildProcess where there are no processes (a browser): the reader runs in this one. What a damaged file does to it,
// it does within the memory of one page.
#include <unistd.h>

#include <cstdlib>
#include <new>
#include <stdexcept>
#include <utility>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab {

struct ChildProcess::State {
  Answer answer;
  bool has_failed = false;
};

ChildProcess::ChildProcess(const Answer& answer, const std::string&) : state_(std::make_unique<State>()) {
  state_->answer = answer;
}

ChildProcess::~ChildProcess() = default;

bool ChildProcess::is_usable() const { return !state_->has_failed; }

std::string ChildProcess::ask(std::string_view request, const ChildLimits&, const std::string& file,
                              const std::string& remedy, int descriptor) {
  if (std::exchange(state_->has_failed, true)) throw FileError(file, "cannot be read: its reader has ended");
  std::string text;
  try {
    text = state_->answer(request, descriptor >= 0 ? dup(descriptor) : -1);
  } catch (const FileError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw FileError(file, "takes more memory to read than there is: damaged? " + remedy);
  } catch (const std::length_error&) {
    throw FileError(file, "takes more memory to read than there is: damaged? " + remedy);
  } catch (const std::exception& error) {
    throw FileError(file, "cannot be read (" + std::string(error.what()) + "): damaged? " + remedy);
  }
  state_->has_failed = false;
  return text;
}

SharedMemory::SharedMemory(std::size_t n_bytes) {
  void* memory = std::malloc(n_bytes);
  if (memory == nullptr) throw std::bad_alloc();
  bytes_ = {static_cast<std::byte*>(memory), n_bytes};
}

SharedMemory::~SharedMemory() { std::free(bytes_.data()); }

void SharedMemory::discard() {}
void SharedMemory::populate(std::size_t) {}

}  // namespace bouncelab

// SPDX-License-Identifier: GPL-3.0-or-later
// ChildProcess where there are no processes (a browser): the reader runs in this one. What a damaged file does to it,
// it does within the memory of one page.
#include <unistd.h>

#include <cstdlib>
#include <deque>
#include <new>
#include <stdexcept>
#include <utility>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab {

struct ChildProcess::State {
  struct Request {
    std::string text;
    int descriptor = -1;
  };
  Answer answer;
  std::deque<Request> begun;
  bool has_failed = false;
};

ChildProcess::ChildProcess(const Answer& answer, const std::string&, const std::function<void()>&)
    : state_(std::make_unique<State>()) {
  state_->answer = answer;
}

ChildProcess::~ChildProcess() = default;

bool ChildProcess::is_usable() const { return !state_->has_failed && state_->begun.empty(); }

std::string ChildProcess::ask(std::string_view request, const ChildLimits& limits, const std::string& file,
                              const std::string& remedy, int descriptor) {
  begin(request, limits, descriptor);
  return finish(limits, file, remedy);
}

void ChildProcess::begin(std::string_view request, const ChildLimits&, int descriptor) {
  state_->begun.push_back({std::string(request), descriptor >= 0 ? dup(descriptor) : -1});
}

std::string ChildProcess::finish(const ChildLimits&, const std::string& file, const std::string& remedy) {
  if (std::exchange(state_->has_failed, true) || state_->begun.empty())
    throw FileError(file, "cannot be read: its reader has ended");
  const State::Request request = std::move(state_->begun.front());
  state_->begun.pop_front();
  std::string text;
  try {
    text = state_->answer(request.text, request.descriptor);
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

}  // namespace bouncelab

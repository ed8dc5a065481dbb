// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/guarded_decoder.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "io/decoding_service.hpp"
#include "io/sound_bytes.hpp"

namespace bouncelab::audio {
namespace {

// A header takes milliseconds. Then by size: libsndfile goes through a file of MP3 or Ogg, and counts a FLAC without
// length, at over 50 MB/s of the file; every decoder makes over 50 MB/s of floats. 1 s/MB is left for slow machines.
constexpr double kLeast_cpu_s = 5.0;
constexpr double kBytesPerCpuSecond = 1e6;
// Decoders hold a few MB, and tables of the file's parts in proportion to its length.
constexpr std::int64_t kLeast_memory_bytes = 100'000'000;
constexpr std::int64_t kMemoryPerFileByte = 10;
constexpr std::int64_t kLeastOfTwoParts = 1 << 20;  // samples: below, a thread takes longer than it saves

const char* const kRemedy = "repair or convert it: ffmpeg -i IN OUT.wav";

}  // namespace

class DecoderProcess {
 public:
  DecoderProcess(const std::string& file, int n_threads, bool needs_libsndfile)
      : memory_(GuardedDecoder::kMostSamples * sizeof(float)),
        samples_(reinterpret_cast<float*>(memory_.bytes().data()), GuardedDecoder::kMostSamples),
        child_([decoding = std::make_shared<DecodingService>(samples_)](
                   std::string_view request, int descriptor) { return decoding->answer(request, descriptor); },
               file, needs_libsndfile ? load_libsndfile : std::function<void()>()),
        n_threads_(n_threads) {}

  std::span<float> samples() const { return samples_; }
  ChildProcess& child() { return child_; }
  int n_threads() const { return n_threads_; }
  /// Closes the file there, which is not waited for.
  void finish_file(const ChildLimits& limits) {
    child_.begin(bytes_of({DecodingRequest::Action::close}), limits);
    is_closing_ = true;
  }
  /// Another file. @return whether it can be read there
  bool begin_file(const std::string& file) {
    if (std::exchange(is_closing_, false)) child_.finish({}, file, kRemedy);
    return child_.is_usable();  // not where this process is a copy of its owner
  }

 private:
  SharedMemory memory_;
  std::span<float> samples_;
  ChildProcess child_;
  int n_threads_;
  bool is_closing_ = false;
};

namespace {

/// Processes that have no file to read now.
class Idle {
 public:
  /// One that is kept, or a new one.
  std::unique_ptr<DecoderProcess> take(const std::string& file, int n_threads = 1, bool needs_libsndfile = false) {
    {
      const std::lock_guard lock(mutex_);
      while (!processes_.empty()) {
        std::unique_ptr<DecoderProcess> process = std::move(processes_.back());
        processes_.pop_back();
        try {
          if (process->begin_file(file)) return process;
        } catch (const FileError&) {  // the file before was damaged: not this one's concern
        }
      }
    }
    return std::make_unique<DecoderProcess>(file, n_threads, needs_libsndfile);
  }
  void keep(std::unique_ptr<DecoderProcess> process) {
    const std::lock_guard lock(mutex_);
    processes_.push_back(std::move(process));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<DecoderProcess>> processes_;
};

/// Never destroyed: a recording may still be open when static objects go. The processes notice that this one has ended.
Idle& idle() {
  static Idle& processes = *new Idle;
  return processes;
}

ChildLimits limits_for(std::int64_t n_file_bytes, std::int64_t n_sample_bytes) {
  return {kLeast_cpu_s + static_cast<double>(n_file_bytes + n_sample_bytes) / kBytesPerCpuSecond,
          kLeast_memory_bytes + kMemoryPerFileByte * n_file_bytes};
}

}  // namespace

GuardedDecoder::GuardedDecoder(int descriptor, std::string name)
    : name_(std::move(name)), n_bytes_(SoundBytes(descriptor).size()), process_(idle().take(name_)) {
  const std::string answer = process_->child().ask(bytes_of({DecodingRequest::Action::open}) + name_,
                                                   limits_for(n_bytes_, 0), name_, kRemedy, descriptor);
  try {
    info_ = opened_file(answer, name_);
  } catch (const NotForLibsndfile&) {
    idle().keep(std::move(process_));
    throw;
  }
  if (info_.plain != PlainEncoding::none) {
    idle().keep(std::move(process_));
    return;
  }
  const bool in_two_parts =
      process_->n_threads() > 1 && info_.can_begin_anywhere && info_.n_frames * info_.n_channels >= kLeastOfTwoParts;
  pieces_ = FilePieces(info_.n_frames, info_.n_channels, in_two_parts);
}

GuardedDecoder::~GuardedDecoder() {
  if (!process_ || !process_->child().is_usable()) return;
  try {
    process_->finish_file(limits_for(n_bytes_, 0));
    idle().keep(std::move(process_));
  } catch (...) {  // the samples were read; the process ends here
  }
}

void GuardedDecoder::start_process(int n_threads, bool needs_libsndfile) {
  try {
    idle().keep(idle().take("recordings", n_threads, needs_libsndfile));
  } catch (const std::exception&) {  // whoever opens a recording will find out
  }
}

std::span<float> GuardedDecoder::read(std::int64_t first, std::int64_t n_frames) {
  const std::int64_t n_samples = n_frames * info_.n_channels;
  const ChildLimits limits = limits_for_samples(n_samples);
  process_->child().ask(bytes_of({DecodingRequest::Action::read, first, n_frames}), limits, name_, kRemedy);
  return process_->samples().first(static_cast<std::size_t>(n_samples));
}

std::int64_t GuardedDecoder::read_whole(std::int64_t n_frames, std::span<float> whole) {
  for (begin_pieces(); pieces_.frames_with(n_copied_) < std::min(n_frames, info_.n_frames); begin_pieces()) {
    if (finish_piece()) {
      copy_piece(n_copied_++, whole);
      continue;
    }
    while (n_begun_ > n_copied_ + 1) {  // those that were asked for meanwhile are not there either
      finish_piece();
      --n_begun_;
    }
    n_begun_ = n_copied_ = 0;
    pieces_ = FilePieces(info_.n_frames, info_.n_channels, false);
  }
  return pieces_.frames_with(n_copied_);
}

void GuardedDecoder::begin_pieces() {
  for (; n_begun_ < std::min(pieces_.size(), n_copied_ + FilePieces::kMostBegun); ++n_begun_) {
    ChildLimits limits = limits_for_samples(info_.n_frames * info_.n_channels);
    if (n_begun_ > 0) limits.cpu_s = 0.0;  // all pieces share it
    process_->child().begin(bytes_of({DecodingRequest::Action::read_piece, 0, 0, n_begun_, pieces_.in_two_parts()}),
                            limits);
  }
}

bool GuardedDecoder::finish_piece() {
  const ChildLimits limits = limits_for_samples(info_.n_frames * info_.n_channels);
  return has_read_piece(process_->child().finish(limits, name_, kRemedy));
}

void GuardedDecoder::copy_piece(std::int64_t k, std::span<float> whole) const {
  const auto copy = [&](const FilePieces::Piece& piece) {
    const std::span<const float> from = place_of(piece, info_.n_channels, process_->samples());
    std::copy(from.begin(), from.end(), whole.begin() + piece.first * info_.n_channels);
  };
  copy(pieces_.of_first(k));
  if (pieces_.in_two_parts()) copy(pieces_.of_second(k));
}

ChildLimits GuardedDecoder::limits_for_samples(std::int64_t n_samples) const {
  ChildLimits limits = limits_for(n_bytes_, n_samples * static_cast<std::int64_t>(sizeof(float)));
  limits.memory_bytes = 0;  // as for opening it
  return limits;
}

}  // namespace bouncelab::audio

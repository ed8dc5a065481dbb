// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/guarded_decoder.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "io/sound_bytes.hpp"
#include "io/two_part_decoder.hpp"

namespace bouncelab::audio {
namespace {

// A header takes milliseconds. Then by size: libsndfile goes through a file of MP3 or Ogg, and counts a FLAC without
// length, at over 50 MB/s of the file; every decoder makes over 50 MB/s of floats. 1 s/MB is left for slow machines.
constexpr double kLeast_cpu_s = 5.0;
constexpr double kBytesPerCpuSecond = 1e6;
// Decoders hold a few MB, and tables of the file's parts in proportion to its length.
constexpr std::int64_t kLeast_memory_bytes = 100'000'000;
constexpr std::int64_t kMemoryPerFileByte = 10;
// of samples that a process keeps for the next file
constexpr std::size_t kKept_bytes = 1 << 20;
constexpr std::int64_t kSamplesOfPiece = 1 << 15;   // of a file that is read while it is decoded
constexpr std::int64_t kLeastOfTwoParts = 1 << 18;  // samples: below, a thread takes longer than it saves
constexpr std::int64_t kMostPiecesBegun = 16;       // a request and its answer are a few hundred bytes in the socket

const char* const kRemedy = "repair or convert it: ffmpeg -i IN OUT.wav";

enum class Action : std::int32_t { open, read, read_whole, close };

struct Request {
  Action action = Action::open;
  std::int64_t first = 0, n_frames = 0;  // of read
  std::int64_t to = 0;                   // sample of the shared memory
};

/// SoundInfo but for its texts, which follow, each with a 0 at its end.
struct PlainInfo {
  double rate_hz;
  std::int32_t n_channels;
  std::int64_t n_frames;
  bool may_be_infinite;
  PlainEncoding plain;
  std::int64_t first_byte;
};

template <class T>
std::string bytes_of(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string message_of(const SoundInfo& info) {
  return bytes_of(PlainInfo{info.rate_hz, info.n_channels, info.n_frames, info.may_be_infinite, info.plain,
                            info.first_byte}) +
         info.description + '\0' + info.lossy_coding + '\0' + info.warning + '\0';
}

// the first byte of the answer to `open`
constexpr char kOpened = 'o';
constexpr char kNotForLibsndfile = 'n';  // the reason follows

SoundInfo info_of(const std::string& message) {
  PlainInfo info{};
  std::memcpy(&info, message.data(), sizeof info);
  std::size_t at = sizeof info;
  const auto next_text = [&] {
    std::string text = message.c_str() + at;
    at += text.size() + 1;
    return text;
  };
  std::string description = next_text(), lossy_coding = next_text();
  return {info.rate_hz,    info.n_channels,        info.n_frames,           info.may_be_infinite, info.plain,
          info.first_byte, std::move(description), std::move(lossy_coding), next_text()};
}

}  // namespace

/// What the process does: one file at a time.
class DecodingService {
 public:
  /// @param memory  of the samples
  DecodingService(SharedMemory& memory, std::span<float> samples, int n_threads)
      : memory_(memory), samples_(samples), n_threads_(n_threads) {}

  std::string answer(std::string_view message, int descriptor) {
    Request request;
    std::memcpy(&request, message.data(), sizeof request);
    if (request.action == Action::open) return open(descriptor, std::string(message.substr(sizeof request)));
    if (request.action == Action::close) return close();
    if (request.action == Action::read_whole && in_two_parts())
      return two_parts_->read_until(request.first + request.n_frames), std::string();
    const std::int64_t n_samples = request.n_frames * decoder_.value().info().n_channels;
    const auto n_after = static_cast<std::size_t>(request.to + n_samples);
    const std::span<float> out = samples_.first(n_after).last(static_cast<std::size_t>(n_samples));
    if (n_after * sizeof(float) > kKept_bytes) memory_.populate(std::as_bytes(out));
    decoder_->read(request.first, out);
    return {};
  }

 private:
  std::string open(int descriptor, const std::string& name) {
    descriptor_ = descriptor;
    name_ = name;
    try {
      decoder_.emplace(SoundBytes(descriptor), name);
    } catch (const NotForLibsndfile& error) {
      close();
      return kNotForLibsndfile + error.reason;
    }
    std::string info = kOpened + message_of(decoder_->info());
    // the bytes of plain samples are read where they are needed
    if (decoder_->info().plain != PlainEncoding::none) close();
    return info;
  }

  bool in_two_parts() {
    const SoundDecoder& decoder = decoder_.value();
    const bool is_long = decoder.info().n_frames * decoder.info().n_channels >= kLeastOfTwoParts;
    if (!two_parts_ && n_threads_ > 1 && is_long && decoder.can_begin_anywhere())
      two_parts_.emplace(*decoder_, descriptor_, name_, memory_);
    return two_parts_.has_value();
  }

  std::string close() {
    two_parts_.reset();
    decoder_.reset();
    ::close(descriptor_);
    return {};
  }

  SharedMemory& memory_;
  std::span<float> samples_;
  std::optional<SoundDecoder> decoder_;
  std::optional<TwoPartDecoder> two_parts_;
  int descriptor_ = -1, n_threads_;
  std::string name_;
};

class DecoderProcess {
 public:
  DecoderProcess(const std::string& file, int n_threads)
      : memory_(GuardedDecoder::kMostSamples * sizeof(float)),
        samples_(reinterpret_cast<float*>(memory_.bytes().data()), GuardedDecoder::kMostSamples),
        child_([decoding = std::make_shared<DecodingService>(memory_, samples_, n_threads)](
                   std::string_view request, int descriptor) { return decoding->answer(request, descriptor); },
               file, load_libsndfile) {}

  std::span<float> samples() const { return samples_; }
  ChildProcess& child() { return child_; }
  /// Closes the file there, which is not waited for.
  /// @param n_samples  that the file had at most at once
  void finish_file(std::int64_t n_samples, const ChildLimits& limits) {
    holds_many_ |= n_samples > static_cast<std::int64_t>(kKept_bytes / sizeof(float));
    child_.begin(bytes_of(Request{Action::close}), limits);
    is_closing_ = true;
  }
  /// Another file, which may be short. After the last one the pages go with the process, in less time.
  /// @return whether it can be read there
  bool begin_file(const std::string& file) {
    if (std::exchange(is_closing_, false)) child_.finish({}, file, kRemedy);
    if (!child_.is_usable()) return false;  // this process is a copy of its owner
    if (std::exchange(holds_many_, false)) memory_.discard();
    return true;
  }

 private:
  SharedMemory memory_;
  std::span<float> samples_;
  ChildProcess child_;
  bool holds_many_ = false;
  bool is_closing_ = false;
};

namespace {

/// Processes that have no file to read now.
class Idle {
 public:
  /// One that is kept, or a new one.
  std::unique_ptr<DecoderProcess> take(const std::string& file, int n_threads = 1) {
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
    return std::make_unique<DecoderProcess>(file, n_threads);
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
  const std::string answer = process_->child().ask(bytes_of(Request{Action::open}) + name_, limits_for(n_bytes_, 0),
                                                   name_, kRemedy, descriptor);
  const bool is_open = answer.at(0) == kOpened;
  if (is_open) info_ = info_of(answer.substr(1));
  if (!is_open || info_.plain != PlainEncoding::none) idle().keep(std::move(process_));
  if (!is_open) throw NotForLibsndfile(name_, answer.substr(1));
}

GuardedDecoder::~GuardedDecoder() {
  if (!process_ || !process_->child().is_usable()) return;
  try {
    process_->finish_file(std::min(info_.n_frames, kMostSamples) * info_.n_channels, limits_for(n_bytes_, 0));
    idle().keep(std::move(process_));
  } catch (...) {  // the samples were read; the process ends here
  }
}

void GuardedDecoder::start_process(int n_threads) {
  try {
    idle().keep(idle().take("recordings", n_threads));
  } catch (const std::exception&) {  // whoever opens a recording will find out
  }
}

std::span<float> GuardedDecoder::read(std::int64_t first, std::int64_t n_frames) {
  const std::int64_t n_samples = n_frames * info_.n_channels;
  const ChildLimits limits = limits_for_samples(n_samples);
  process_->child().ask(bytes_of(Request{Action::read, first, n_frames}), limits, name_, kRemedy);
  return process_->samples().first(static_cast<std::size_t>(n_samples));
}

std::span<float> GuardedDecoder::read_whole(std::int64_t n_frames) {
  const std::int64_t n_piece = std::max<std::int64_t>(1, kSamplesOfPiece / info_.n_channels);
  const ChildLimits of_all = limits_for_samples(info_.n_frames * info_.n_channels);
  const auto begin_more = [&] {
    for (; n_begun_ < info_.n_frames && n_begun_ < n_read_ + kMostPiecesBegun * n_piece; n_begun_ += n_piece) {
      ChildLimits limits = of_all;
      if (n_begun_ > 0) limits.cpu_s = 0.0;  // all pieces share it
      const Request request{Action::read_whole, n_begun_, std::min(n_piece, info_.n_frames - n_begun_),
                            n_begun_ * info_.n_channels};
      process_->child().begin(bytes_of(request), limits);
    }
  };
  for (begin_more(); n_read_ < std::min(n_frames, info_.n_frames); begin_more()) {
    process_->child().finish(of_all, name_, kRemedy);
    n_read_ = std::min(n_read_ + n_piece, info_.n_frames);
  }
  return process_->samples().first(static_cast<std::size_t>(n_read_ * info_.n_channels));
}

std::span<const float> GuardedDecoder::place_of_whole() const {
  return process_->samples().first(static_cast<std::size_t>(info_.n_frames * info_.n_channels));
}

ChildLimits GuardedDecoder::limits_for_samples(std::int64_t n_samples) const {
  ChildLimits limits = limits_for(n_bytes_, n_samples * static_cast<std::int64_t>(sizeof(float)));
  limits.memory_bytes = 0;  // as for opening it
  return limits;
}

}  // namespace bouncelab::audio

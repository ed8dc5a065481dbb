// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/shared_recording.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {

/// Each is used by one thread at a time.
class SharedRecording::Readers {
 public:
  Readers(const std::filesystem::path& path, std::optional<double> rate_hz, int n_threads, BytesSink bytes_read)
      : path_(path), rate_hz_(rate_hz), first_(path, rate_hz, std::move(bytes_read)) {
    if (!first_.gains_by_more_readers()) return;
    n_most_ = n_threads;
    idle_.reserve(static_cast<std::size_t>(n_most_));  // so that giving back cannot fail
    idle_.push_back({&first_, 0});
    others_.reserve(idle_.capacity());
  }

  AudioReader& first() { return first_; }
  bool are_several() const { return n_most_ > 1; }
  /// For the one that there is where they are not several.
  const std::shared_ptr<std::mutex>& reading() const { return reading_; }

  void read(std::int64_t first, int channel, std::span<float> out) {
    Borrowed borrowed(*this, take(first));
    borrowed.place.reader->read(first, channel, out);
    borrowed.place.next = first + std::ssize(out);
  }

 private:
  struct Place {
    AudioReader* reader = nullptr;
    std::int64_t next = 0;  // sample behind what it has read last
  };

  /// Given back whatever happens.
  struct Borrowed {
    Borrowed(Readers& from_, Place place_) : from(from_), place(place_) {}
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    ~Borrowed() { from.give_back(place); }
    Readers& from;
    Place place;
  };

  /// The nearest to a sample of those that are idle, or another one.
  Place take(std::int64_t first) {
    std::unique_lock lock(mutex_);
    if (idle_.empty() && std::ssize(others_) + 1 < n_most_) {
      if (AudioReader* made = make()) return {made, 0};
    }
    changed_.wait(lock, [&] { return !idle_.empty(); });
    const auto nearest = std::min_element(idle_.begin(), idle_.end(), [&](const Place& a, const Place& b) {
      return std::abs(a.next - first) < std::abs(b.next - first);
    });
    const Place taken = *nearest;
    idle_.erase(nearest);
    return taken;
  }

  /// None where the system has no more files or processes to give: those that there are have to do then.
  AudioReader* make() {
    try {
      return others_.emplace_back(std::make_unique<AudioReader>(path_, rate_hz_)).get();
    } catch (const FileError&) {
      n_most_ = static_cast<int>(std::ssize(others_)) + 1;
      return nullptr;
    }
  }

  void give_back(Place place) {
    {
      const std::lock_guard lock(mutex_);
      idle_.push_back(place);
    }
    changed_.notify_one();
  }

  const std::filesystem::path path_;
  const std::optional<double> rate_hz_;
  AudioReader first_;
  const std::shared_ptr<std::mutex> reading_ = std::make_shared<std::mutex>();

  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::vector<std::unique_ptr<AudioReader>> others_;
  std::vector<Place> idle_;
  int n_most_ = 1;
};

SharedRecording::SharedRecording(const std::filesystem::path& path, std::optional<double> rate_hz, int n_threads,
                                 BytesSink bytes_read)
    : readers_(std::make_unique<Readers>(path, rate_hz, n_threads, std::move(bytes_read))) {}

SharedRecording::~SharedRecording() = default;

const AudioFormat& SharedRecording::format() const { return readers_->first().format(); }

AudioSource SharedRecording::source(int channel) {
  Readers& readers = *readers_;
  if (!readers.are_several()) return one_at_a_time(readers.first().source(channel), readers.reading());
  return {format().rate_hz, format().n_frames,
          [&readers, channel](std::int64_t first, std::span<float> out) { readers.read(first, channel, out); }};
}

}  // namespace bouncelab::audio

// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of detection are called and what they are, key by key (docs/formats.md is made of these texts).
#include <cmath>
#include <cstdint>

#include "bouncelab/core/files.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/detection/score.hpp"
#include "bouncelab/detection/wave_preview.hpp"

namespace bouncelab::detection {
namespace {

std::optional<std::string> if_any(const std::string& text) { return text.empty() ? std::nullopt : std::optional(text); }

/// A WAV file, 16 bit, one channel.
std::string wav_file(const ListeningCopy& copy) {
  std::string bytes;
  const auto put = [&](std::uint32_t value, int n_bytes) {
    for (int k = 0; k < n_bytes; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFFU);
  };
  const auto n_bytes = static_cast<std::uint32_t>(2 * copy.samples.size());
  const auto rate_hz = static_cast<std::uint32_t>(std::llround(copy.rate_hz));
  bytes += "RIFF";
  put(36 + n_bytes, 4);
  bytes += "WAVEfmt ";
  put(16, 4);
  put(1, 2);  // PCM
  put(1, 2);  // one channel
  put(rate_hz, 4);
  put(2 * rate_hz, 4);
  put(2, 2);
  put(16, 2);
  bytes += "data";
  put(n_bytes, 4);
  for (const std::int16_t x : copy.samples) put(static_cast<std::uint16_t>(x), 2);
  return bytes;
}

/// RFC 4648, section 4.
std::string base64(const std::string& bytes) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const auto byte = [&](std::size_t j) {
      return j < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[j])) : 0U;
    };
    const std::uint32_t three = byte(k) << 16U | byte(k + 1) << 8U | byte(k + 2);
    for (std::size_t j = 0; j < 4; ++j) text += k + j > bytes.size() ? '=' : kDigits[three >> (18U - 6U * j) & 63U];
  }
  return text;
}

}  // namespace

const char* to_string(DetectionStatus status) {
  switch (status) {
    case DetectionStatus::ok:
      return "ok";
    case DetectionStatus::too_few_impacts:
      return "too_few_impacts";
    case DetectionStatus::silent:
      return "silent";
    case DetectionStatus::unreadable:
      return "unreadable";
  }
  return "?";
}

const Description& members_of(const DropSummary*) {
  using D = DropSummary;
  static const Description all{result("begin_s", &D::begin_s, "Time of its first impact"),
                               result("n_impacts", &D::n_impacts, "Impacts found"),
                               result("odds", &D::odds, "That it is a ball against rhythms and other sounds, 1 to 10⁶"),
                               result<D>("probability", &D::probability, "odds/(1 + odds)"),
                               result<D>("doubtful", &D::is_doubtful, "Odds below 10")};
  return all;
}

const Description& members_of(const RecordingSummary*) {
  using S = RecordingSummary;
  static const Description all{
      result("n_drops", &S::n_drops, "Drops found"),
      result("n_candidates", &S::n_candidates, "Rises of the variance, impacts or not"),
      result("format", &S::format, "Container and encoding, in words"),
      result<S>(
          "lossy_coding", [](const S& s) { return if_any(s.lossy_coding); },
          "`MP3`, `AAC` ...: its times may be off by more than stated; `null` where it loses nothing"),
      result<S>(
          "ffmpeg", [](const S& s) { return if_any(s.ffmpeg); }, "Version of the ffmpeg that decoded it"),
      result("n_tracks", &S::n_tracks, "Tracks of sound in the file"),
      result("track", &S::track, "The one used"),
      result("n_gaps", &S::n_gaps, "Gaps of the container's time stamps, in which there is no sound"),
      result("rate_hz", &S::rate_hz, "Sampling rate"),
      result("n_channels", &S::n_channels, "Channels"),
      result("channel", &S::channel, "The one used"),
      result("channel_reason", &S::channel_reason, "Why that one, in words"),
      result("duration_s", &S::duration_s, "Length"),
      result("noise_rms", &S::noise_rms, "Of the quiet parts, full scale = 1"),
      result("eps_median", &S::restitution_median, "Median of T_{k+1} / T_k over all drops"),
      result("contact_time_at_1_mps_s", &S::contact_time_at_1_mps_s,
             "τ₁ of τ = τ₁ v^(-1/5), by which the times were moved to the start of contact; `null` where it is not "
             "significant at 4 sigma"),
      result("contact_time_sigma_s", &S::contact_time_sigma_s,
             "Standard error d of the τ₁ used: all times of a drop share an error of d (v^(-1/5) - const) / 2; `null` "
             "where no time was moved")};
  return all;
}

const Description& members_of(const RecordingDetection*) {
  using R = RecordingDetection;
  static const Description all{
      result<R>(
          "recording", [](const R& r) { return input_name(r.recording); }, "As it was given"),
      result("status", path(&R::found, &Detection::status), "`ok`, `too_few_impacts`, `silent` or `unreadable`"),
      result("message", path(&R::found, &Detection::message), "What was found, or why not"),
      result("n_onsets", &R::n_onsets, "Impacts found"),
      result("drops", path(&R::found, &Detection::drops), "`[{begin_s, n_impacts, odds, probability, doubtful}]`"),
      result<R>(
          "", [](const R& r) { return std::get<Object>(value_of(r.found.summary)); }, "Of the recording"),
      result("warnings", path(&R::found, &Detection::warnings), "Texts")};
  return all;
}

const Description& members_of(const LearnedWave*) {
  using W = LearnedWave;
  static const Description all{result("t0_s", &W::t0_s, "Time of the first sample from the start of contact"),
                               result("dt_s", &W::dt_s, "Between samples"),
                               result("mean", &W::mean, "Of impacts scaled to the strongest"),
                               result("spread", &W::spread, "Standard deviation from impact to impact"),
                               result("n_impacts", &W::n_impacts, "That it is the mean of")};
  return all;
}

const Description& members_of(const NoiseSpectrum*) {
  static const Description all{result("frequency_hz", &NoiseSpectrum::frequency_hz, "Frequencies"),
                               result("psd", &NoiseSpectrum::psd, "Power spectral density, in 1/Hz")};
  return all;
}

const Description& members_of(const WaveExcerpt::Mark*) {
  using M = WaveExcerpt::Mark;
  static const Description all{result("t_s", &M::t_s, "Time"), result("sigma_t_s", &M::sigma_t_s, "Its error"),
                               result("impact", &M::impact, "Number of the impact")};
  return all;
}

const Description& members_of(const WaveExcerpt*) {
  using E = WaveExcerpt;
  static const Description all{
      result("title", &E::title, "In words"), result("t0_s", &E::t0_s, "Time of the first sample"),
      result("dt_s", &E::dt_s, "Between samples"), result("samples", &E::samples, "Full scale = 1"),
      result("marks", &E::marks, "`[{t_s, sigma_t_s, impact}]`")};
  return all;
}

const Description& members_of(const ListeningCopy*) {
  using C = ListeningCopy;
  static const Description all{
      result("t0_s", &C::t0_s, "Time of its first sample"),
      result<C>(
          "duration_s", [](const C& c) { return static_cast<double>(c.samples.size()) / c.rate_hz; }, "Length"),
      result<C>(
          "wav_base64", [](const C& c) { return base64(wav_file(c)); },
          "WAV, 16 bit, at most 24 kHz, peak at 0.9, from half a second before the first mark to half a second "
          "after the last, at most 30 s")};
  return all;
}

const Description& members_of(const WavePreview*) {
  using W = WavePreview;
  static const Description all{
      result("recording", &W::recording, "As it was given"),
      result("rate_hz", &W::rate_hz, "Sampling rate"),
      result("channel", &W::channel, "The one used"),
      result("duration_s", &W::duration_s, "Length"),
      result<W>(
          "envelope",
          [](const W& w) {
            return Object{{"t_s", w.column_t_s}, {"lo", w.lo}, {"hi", w.hi}};
          },
          "`t_s`, `lo`, `hi`: extremes of about 2,000 columns, full scale = 1"),
      result<W>(
          "marks",
          [](const W& w) {
            Values marks;
            for (const Onset& mark : w.marks)
              marks.push_back(Object{
                  {"t_s", mark.t_s}, {"drop", mark.drop}, {"impact", mark.impact}, {"flags", mark.flags.text()}});
            return marks;
          },
          "`[{t_s, drop, impact, flags}]`"),
      result("excerpts", &W::excerpts, "3 ms before to 8 ms after four impacts"),
      result<W>(
          "sound", [](const W& w) { return w.copy.samples.empty() ? std::nullopt : std::optional(w.copy); },
          "`null`, or the recording to be listened to")};
  return all;
}

const Description& members_of(const OnsetScore*) {
  using S = OnsetScore;
  static const Description all{
      result("n_impacts", &S::n_true, "True impacts"),
      result("n_found", &S::n_found, "Detected, one to one within a tolerance"),
      result("n_missed", &S::n_missed, "True impacts without"),
      result("n_invented", &S::n_invented, "Detected impacts without a true one"),
      result("time_rms_s", &S::rms_s, "Rms error about the offset").left_out_where_unknown(),
      result("time_rms_within_drops_s", &S::rms_within_drops_s, "The same with each drop's median error removed")
          .left_out_where_unknown(),
      result("time_offset_s", &S::offset_s, "Median of detected minus true time (intervals do not see it)")
          .left_out_where_unknown(),
      result("time_pull_sd", &S::pull_sd, "Root of χ²/ndf of the errors over `sigma_t_s`; 1 for honest standard errors")
          .left_out_where_unknown()};
  return all;
}

}  // namespace bouncelab::detection

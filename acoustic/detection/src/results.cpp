// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of detection are called and what they are, key by key (docs/formats.md is made of these texts).
#include <cmath>
#include <cstdint>

#include "bouncelab/core/files.hpp"
#include "bouncelab/detection/detect.hpp"
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

Description members_of(const DropSummary*) {
  using D = DropSummary;
  static constexpr Member all[]{
      member<&D::begin_s>("begin_s", "Time of its first impact"), member<&D::n_impacts>("n_impacts", "Impacts found"),
      member<&D::odds>("odds", "That it is a ball against rhythms and other sounds, 1 to 10⁶"),
      member<&D::probability>("probability", "odds/(1 + odds)"), member<&D::is_doubtful>("doubtful", "Odds below 10")};
  return all;
}

Description members_of(const RecordingSummary*) {
  using S = RecordingSummary;
  static constexpr Member all[]{
      member<&S::n_drops>("n_drops", "Drops found"),
      member<&S::n_candidates>("n_candidates", "Rises of the variance, impacts or not"),
      member<&S::format>("format", "Container and encoding, in words"),
      computed(
          "lossy_coding", [](const S& s) { return if_any(s.lossy_coding); },
          "`MP3`, `AAC` ...: its times may be off by more than stated; `null` where it loses nothing"),
      computed(
          "ffmpeg", [](const S& s) { return if_any(s.ffmpeg); }, "Version of the ffmpeg that decoded it"),
      member<&S::n_tracks>("n_tracks", "Tracks of sound in the file"),
      member<&S::track>("track", "The one used"),
      member<&S::n_gaps>("n_gaps", "Gaps of the container's time stamps, in which there is no sound"),
      member<&S::rate_hz>("rate_hz", "Sampling rate"),
      member<&S::n_channels>("n_channels", "Channels"),
      member<&S::channel>("channel", "The one used"),
      member<&S::channel_reason>("channel_reason", "Why that one, in words"),
      member<&S::duration_s>("duration_s", "Length"),
      member<&S::noise_rms>("noise_rms", "Of the quiet parts, full scale = 1"),
      member<&S::restitution_median>("eps_median", "Median of T_{k+1} / T_k over all drops"),
      member<&S::contact_time_at_1_mps_s>(
          "contact_time_at_1_mps_s",
          "τ₁ of τ = τ₁ v^(-1/5), by which the times were moved to the start of contact; `null` where it is not "
          "significant at 4 sigma"),
      member<&S::contact_time_sigma_s>(
          "contact_time_sigma_s",
          "Standard error d of the τ₁ used: all times of a drop share an error of d (v^(-1/5) - const) / 2; `null` "
          "where no time was moved")};
  return all;
}

Description members_of(const RecordingDetection*) {
  using R = RecordingDetection;
  static constexpr Member all[]{
      computed(
          "recording", [](const R& r) { return input_name(r.recording); }, "As it was given"),
      member<&R::found, &Detection::status>("status", "`ok`, `too_few_impacts`, `silent` or `unreadable`"),
      member<&R::n_onsets>("n_onsets", "Impacts found"),
      member<&R::found, &Detection::drops>("drops", "`[{begin_s, n_impacts, odds, probability, doubtful}]`"),
      computed(
          "", [](const R& r) { return std::get<Object>(value_of(r.found.summary)); }, "Of the recording"),
      member<&R::found, &Detection::notes>(
          "notes", "`[{kind, numbers, subject, recording}]`: what limits the times; where there are none, why")};
  return all;
}

Description members_of(const LearnedWave*) {
  using W = LearnedWave;
  static constexpr Member all[]{member<&W::t0_s>("t0_s", "Time of the first sample from the start of contact"),
                                member<&W::dt_s>("dt_s", "Between samples"),
                                member<&W::mean>("mean", "Of impacts scaled to the strongest"),
                                member<&W::spread>("spread", "Standard deviation from impact to impact"),
                                member<&W::n_impacts>("n_impacts", "That it is the mean of")};
  return all;
}

Description members_of(const NoiseSpectrum*) {
  static constexpr Member all[]{member<&NoiseSpectrum::frequency_hz>("frequency_hz", "Frequencies"),
                                member<&NoiseSpectrum::psd>("psd", "Power spectral density, in 1/Hz")};
  return all;
}

Description members_of(const WaveExcerpt::Mark*) {
  using M = WaveExcerpt::Mark;
  static constexpr Member all[]{member<&M::t_s>("t_s", "Time"), member<&M::sigma_t_s>("sigma_t_s", "Its error"),
                                member<&M::impact>("impact", "Number of the impact")};
  return all;
}

Description members_of(const WaveExcerpt*) {
  using E = WaveExcerpt;
  static constexpr Member all[]{
      member<&E::title>("title", "In words"), member<&E::t0_s>("t0_s", "Time of the first sample"),
      member<&E::dt_s>("dt_s", "Between samples"), member<&E::samples>("samples", "Full scale = 1"),
      member<&E::marks>("marks", "`[{t_s, sigma_t_s, impact}]`")};
  return all;
}

Description members_of(const ListeningCopy*) {
  using C = ListeningCopy;
  static constexpr Member all[]{
      member<&C::t0_s>("t0_s", "Time of its first sample"),
      computed(
          "duration_s", [](const C& c) { return static_cast<double>(c.samples.size()) / c.rate_hz; }, "Length"),
      computed(
          "wav_base64", [](const C& c) { return base64(wav_file(c)); },
          "WAV, 16 bit, at most 24 kHz, peak at 0.9, from half a second before the first mark to half a second "
          "after the last, at most 30 s")};
  return all;
}

Description members_of(const WavePreview*) {
  using W = WavePreview;
  static constexpr Member all[]{
      member<&W::recording>("recording", "As it was given"),
      member<&W::rate_hz>("rate_hz", "Sampling rate"),
      member<&W::channel>("channel", "The one used"),
      member<&W::duration_s>("duration_s", "Length"),
      computed(
          "envelope",
          [](const W& w) {
            return Object{{"t_s", w.column_t_s}, {"lo", w.lo}, {"hi", w.hi}};
          },
          "`t_s`, `lo`, `hi`: extremes of about 2,000 columns, full scale = 1"),
      computed(
          "marks",
          [](const W& w) {
            Values marks;
            for (const Onset& mark : w.marks)
              marks.push_back(Object{
                  {"t_s", mark.t_s}, {"drop", mark.drop}, {"impact", mark.impact}, {"flags", mark.flags.text()}});
            return marks;
          },
          "`[{t_s, drop, impact, flags}]`"),
      member<&W::excerpts>("excerpts", "3 ms before to 8 ms after four impacts"),
      computed(
          "sound", [](const W& w) { return w.copy.samples.empty() ? std::nullopt : std::optional(w.copy); },
          "`null`, or the recording to be listened to")};
  return all;
}

}  // namespace bouncelab::detection

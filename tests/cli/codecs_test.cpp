// SPDX-License-Identifier: GPL-3.0-or-later
// One recording in the formats that phones, messengers and browsers make: the same impacts must come out.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"
#include "program.hpp"

namespace bouncelab::cli_test {
namespace {

struct Impact {
  double t_s = 0.0, sigma_s = 0.0;
};

class Codecs : public ProgramTest {
 protected:
  void SetUp() override {
    if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed: tools/setup --checks";
    const Result made = shell(
        "\"$B\" simulate --drops 1 --impacts 25 --asperities 1000 --out i.csv --quiet && "
        "\"$B\" synthesize i.csv --out s.wav --rate 48000 --bits 16 --snr-db 40 --max-mode 20000 --quiet");
    ASSERT_EQ(made.exit_code, 0) << made.err;
    original_ = impacts_in("s.wav");
    ASSERT_EQ(original_.size(), 25u);
  }

  /// Also keeps the summary of the recording.
  std::vector<Impact> impacts_in(const std::string& recording) {
    const Result result = run("detect '" + recording + "' --out o.csv --force --json");
    EXPECT_EQ(result.exit_code, 0) << recording << ": " << result.err;
    if (result.exit_code != 0) return {};
    summary_ = Json(result.out)["recordings"][0];
    std::vector<Impact> impacts;
    for (const Onset& onset : onsets_from_table(read_csv(folder_ / "o.csv", onset_columns()), "o.csv"))
      impacts.push_back({onset.t_s, *onset.sigma_t_s});
    return impacts;
  }

  bool encode(const std::string& arguments, const std::string& name) const {
    return shell("ffmpeg -nostdin -v error -i s.wav " + arguments + " -y " + name).exit_code == 0;
  }

  /// Largest difference of the times after one offset, over the error that both state and what the codec may add.
  double largest_pull(const std::vector<Impact>& found, double codec_s) const {
    std::vector<double> differences;
    for (std::size_t k = 0; k < original_.size(); ++k) differences.push_back(found[k].t_s - original_[k].t_s);
    std::vector<double> sorted = differences;
    std::nth_element(sorted.begin(), sorted.begin() + std::ssize(sorted) / 2, sorted.end());
    const double offset_s = sorted[sorted.size() / 2];
    double largest = 0.0;
    for (std::size_t k = 0; k < original_.size(); ++k)
      largest = std::max(
          largest, std::abs(differences[k] - offset_s) / std::hypot(found[k].sigma_s, original_[k].sigma_s, codec_s));
    return largest;
  }

  std::vector<Impact> original_;
  Json summary_;
};

TEST_F(Codecs, LosslessOnesGiveTheSameTimesToTheDigit) {
  for (const auto& [arguments, name] : std::vector<std::pair<std::string, std::string>>{
           {"-c:a flac", "a.flac"}, {"-c:a alac", "a.m4a"}, {"-c:a pcm_s16le", "a.mov"}, {"-c:a flac", "a.mkv"}}) {
    ASSERT_TRUE(encode(arguments, name)) << name;
    const std::vector<Impact> found = impacts_in(name);
    ASSERT_EQ(found.size(), original_.size()) << name;
    for (std::size_t k = 0; k < found.size(); ++k) ASSERT_EQ(found[k].t_s, original_[k].t_s) << name;
    EXPECT_TRUE(summary_["lossy_coding"].is_null()) << name;
    EXPECT_EQ(summary_["ffmpeg"].is_null(), name == "a.flac");
  }
}

TEST_F(Codecs, LossyOnesGiveTheSameImpactsAndAreNamed) {
  // 5 standard errors in a hundred times or so; and up to 3 us that the codec moves the sound by and no template shows
  // (0.1 to 3 us were measured over many drops)
  constexpr double kCodec_s = 3e-6, kMostPull = 5.0;
  struct Case {
    std::string arguments, name, coding;
  };
  const std::string video = "-f lavfi -i testsrc=d=3:s=64x64:r=10 -map 0:a -map 1:v -c:v mpeg4 ";
  int n_tried = 0;
  for (const Case& c : std::vector<Case>{{"-c:a aac -b:a 128k", "a.m4a", "AAC"},
                                         {video + "-c:a aac -b:a 128k", "a phone's video.mp4", "AAC"},
                                         {"-c:a libopus -b:a 96k", "a.webm", "Opus"},
                                         {"-c:a libopus -b:a 96k", "a.opus", "Opus"},
                                         {"-c:a libmp3lame -b:a 128k", "a.mp3", "MP3"},
                                         {"-c:a libvorbis -q:a 4", "a.ogg", "Vorbis"}}) {
    SCOPED_TRACE(c.name);
    if (!encode(c.arguments, "\"" + c.name + "\"")) continue;  // ffmpeg was built without this encoder
    ++n_tried;
    fs::rename(folder_ / c.name, folder_ / "recording");  // the content tells, not the name
    const std::vector<Impact> found = impacts_in("recording");
    ASSERT_EQ(found.size(), original_.size());
    EXPECT_LE(largest_pull(found, kCodec_s), kMostPull);
    EXPECT_EQ(summary_["lossy_coding"], c.coding);
    EXPECT_EQ(summary_["notes"][0]["kind"], "lossy_coding");
    EXPECT_EQ(summary_["notes"][0]["subject"], c.coding);
  }
  EXPECT_GE(n_tried, 2);  // AAC is ffmpeg's own
}

TEST_F(Codecs, WhatASynthesisKeepsOfACodecIsLossyAndOnItsTimeBase) {
  const auto samples_of = [&](const std::string& name) {
    const std::string bytes = content_of(folder_ / name);
    std::vector<float> samples((bytes.size() - bytes.find("data") - 8) / sizeof(float));
    std::memcpy(samples.data(), bytes.data() + bytes.find("data") + 8, samples.size() * sizeof(float));
    return samples;
  };
  // at 44.1 kHz Opus goes by 48 kHz and back
  const std::string options = " --rate 44100 --bits float --snr-db 40 --max-mode 20000 --quiet";
  ASSERT_EQ(run("synthesize i.csv --out plain.wav" + options).exit_code, 0);
  const std::vector<float> plain = samples_of("plain.wav");
  for (const std::string codec : {"aac:64", "mp3:64", "opus:64", "vorbis:64"}) {
    SCOPED_TRACE(codec);
    const Result result = run("synthesize i.csv --out coded.wav --force --codec " + codec + options);
    if (result.exit_code == 2 && result.err.find("Unknown encoder") != std::string::npos) continue;
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(content("coded.truth.csv").size(), content("plain.truth.csv").size());
    const std::vector<float> coded = samples_of("coded.wav");
    ASSERT_EQ(coded.size(), plain.size());
    EXPECT_NE(coded, plain);
    // cross-correlation at lags of at most a frame; encoders add 1000
    double largest = 0.0, energy = 0.0;
    for (const std::size_t lag : {0U, 1U, 2U})
      largest = std::max(largest, std::inner_product(plain.begin() + 1, plain.end() - 1, coded.begin() + lag, 0.0));
    for (const float x : plain) energy += static_cast<double>(x) * x;
    EXPECT_GT(largest, 0.4 * energy) << "what is above 16 kHz is gone";
  }
}

TEST_F(Codecs, WhatNoCodecCanDoIsRefusedInOneLine) {
  for (const auto& [arguments, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"r.wav --codec flac:64", {"--codec", "flac:64", "aac"}},
           {"r.wav --codec aac", {"--codec", "aac:64"}},
           {"r.wav --codec aac:3", {"--codec", "6 to 512"}},
           {"r.mp3 --codec mp3:64", {".mp3", ".wav"}},
           {"r.wav --each-drop --codec aac:64", {"--codec", "--each-drop"}},
           {"- --truth t.csv --codec aac:64", {"--codec", "stream"}},
           {"r.wav --codec mp3:64 --channel 0.1,0 --channel 0,0.05 --channel 0,0",
            {"--codec", "3 channels", "libmp3lame"}}})
    expect_refused("synthesize i.csv --quiet --out " + arguments, 2, words);
  expect_one_line_error(shell("mkdir -p none && PATH=$PWD/none \"$B\" synthesize i.csv --out r.wav --codec aac:64"), 3,
                        {"needs ffmpeg", "apt install ffmpeg"});
}

TEST_F(Codecs, StreamsWithoutALengthAreReadFromFilesAndPipes) {
  for (const std::string format : {"wav", "flac", "w64", "aiff"}) {
    const Result result = shell("ffmpeg -nostdin -v error -i s.wav -f " + format +
                                " pipe:1 | tee streamed | \"$B\" detect - --out p.csv --force");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    // AIFF's header libsndfile corrects without a word
    EXPECT_THAT(result.err, testing::HasSubstr(format == "aiff" ? "" : "gives no length")) << format;
    const std::vector<Impact> found = impacts_in("streamed");
    ASSERT_EQ(found.size(), original_.size()) << format;
    for (std::size_t k = 0; k < found.size(); ++k) ASSERT_EQ(found[k].t_s, original_[k].t_s) << format;
  }
}

TEST_F(Codecs, APhonesRecordingFromAPipeIsAnalyzedAndTheProvenanceNamesFfmpeg) {
  ASSERT_TRUE(encode("-c:a alac", "a.m4a"));
  const Result result = shell("cat a.m4a | \"$B\" detect - --out p.csv");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string version = json("p.csv.meta.json")["ffmpeg"].text();
  EXPECT_THAT(shell("ffmpeg -version").out, testing::HasSubstr("ffmpeg version " + version + " "));
  EXPECT_EQ(run("detect s.wav --out w.csv").exit_code, 0);
  EXPECT_FALSE(json("w.csv.meta.json").contains("ffmpeg"));
}

}  // namespace
}  // namespace bouncelab::cli_test

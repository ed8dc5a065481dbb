// SPDX-License-Identifier: GPL-3.0-or-later
// make_seeds FOLDER: writes inputs that the fuzzers begin with, by the library's own writers, as FOLDER/TARGET/NAME.
#include <sndfile.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/sim/surface.hpp"

namespace {
using namespace bouncelab;
namespace fs = std::filesystem;

constexpr int kRate_hz = 48000;
constexpr int kFrames = 120;  // short: a change of any byte should have an effect

class Seeds {
 public:
  explicit Seeds(fs::path folder) : folder_(std::move(folder)) {}

  fs::path path(const std::string& target, const std::string& name) const {
    fs::create_directories(folder_ / target);
    return folder_ / target / name;
  }
  void write(const std::string& target, const std::string& name, const std::string& content) const {
    std::ofstream(path(target, name), std::ios::binary) << content;
  }

 private:
  fs::path folder_;
};

std::vector<double> ringing(int n_channels) {
  std::vector<double> samples;
  for (int k = 0; k < kFrames * n_channels; ++k) samples.push_back(0.9 * std::exp(-0.02 * k) * std::sin(0.7 * k));
  return samples;
}

Impacts impacts(bool with_states) {
  Impacts result;
  for (std::int64_t drop = 0; drop < 2; ++drop)
    for (std::int64_t k = 0; k < 3; ++k)
      result.rows.push_back({drop, k, 0.1 + 0.25 * static_cast<double>(k), 1.3, 1.27, 1.27 / 1.3, 1.299, 0.978, k - 1});
  if (with_states) result.states.resize(result.rows.size());
  return result;
}

Onsets onsets() {
  Onsets result;
  for (std::int64_t k = 0; k < 4; ++k)
    result.push_back({"a \"b\", c.wav", k / 2, k % 2, 0.0005 * static_cast<double>(k + 1), 1e-8, 0.3, 48.5, {}});
  result[1].flags = {Flag::clipped, Flag::inferred};
  result[2].sigma_t_s.reset();
  return result;
}

RestitutionSamples samples() {
  RestitutionSamples result(3);
  for (RestitutionSample& sample : result) {
    sample = {"a.wav", 0, 1, 0.8, 1.3, 0.97, 1e-6, 2e-5, {}, {true, true, false, 9.81, Ball{}, kGlass, {}, {}}};
  }
  result[1].flags = {Flag::missing_impact};
  return result;
}

std::vector<std::pair<std::string, Table>> tables() {
  return {{"impacts", to_table(impacts(false))},
          {"states", to_table(impacts(true))},
          {"onsets", to_table(onsets())},
          {"samples", to_table(samples())}};
}

std::string csv(const Table& table) {
  std::ostringstream out;
  write_csv(out, table);
  return out.str();
}

void write_tables(const Seeds& seeds) {
  for (const auto& [name, table] : tables()) seeds.write("csv", name, csv(table));
  for (const char* law : {"constant", "uniform", "normal", "lognormal", "exponential"}) {
    const sim::RadiusLaw radii = sim::radius_law_from_text(law);
    seeds.write("surface", law, to_text(radii));
    seeds.write("surface", std::string(law) + ".csv", csv(to_table(sim::make_surface({}, 3, radii, 1))));
  }
  const Table law{{{"v_mps", std::vector<double>{0.1, 0.5, 1.4}}, {"eps", std::vector<double>{0.99, 0.98, 0.95}}}};
  seeds.write("law_table", "table", csv(law));
  for (const char* text : {"series", "series:A2=0.0467,A4=0.1339,A5=-0.2876", "viscoelastic:0.02072", "constant:0.98"})
    seeds.write("law_table", std::string(text).substr(0, 12), text);
}

void write_recordings(const Seeds& seeds) {
  using audio::SampleEncoding;
  for (const char* extension : {".wav", ".rf64", ".w64", ".flac"})
    for (const SampleEncoding encoding :
         {SampleEncoding::pcm16, SampleEncoding::pcm24, SampleEncoding::pcm32, SampleEncoding::float32})
      for (const int n_channels : {1, 2}) {
        const audio::AudioSpec spec{kRate_hz, n_channels, encoding};
        const std::string name = std::to_string(static_cast<int>(encoding)) + std::to_string(n_channels) + extension;
        try {
          validate(name, spec);
        } catch (const InvalidArgument&) {
          continue;  // FLAC has no floats
        }
        audio::AudioWriter writer(seeds.path("audio", name), spec, kFrames, true);
        writer.write(ringing(n_channels));
        writer.commit();
      }
}

int count(int command) {
  int n = 0;
  sf_command(nullptr, command, &n, sizeof n);
  return n;
}

SF_FORMAT_INFO format_info(int command, int index) {
  SF_FORMAT_INFO info{};
  info.format = index;
  sf_command(nullptr, command, &info, sizeof info);
  return info;
}

/// Every container and encoding that libsndfile writes.
void write_foreign_recordings(const Seeds& seeds) {
  const std::vector<double> sound = ringing(1);
  const int n_majors = count(SFC_GET_FORMAT_MAJOR_COUNT), n_subtypes = count(SFC_GET_FORMAT_SUBTYPE_COUNT);
  for (int major = 0; major < n_majors; ++major)
    for (int subtype = 0; subtype < n_subtypes; ++subtype) {
      const SF_FORMAT_INFO container = format_info(SFC_GET_FORMAT_MAJOR, major);
      const SF_FORMAT_INFO encoding = format_info(SFC_GET_FORMAT_SUBTYPE, subtype);
      SF_INFO info{};
      info.samplerate = kRate_hz;
      info.channels = 1;
      info.format = container.format | encoding.format;
      // files without a header cannot be read either
      if (container.format == SF_FORMAT_RAW || !sf_format_check(&info)) continue;
      const std::string name = std::to_string(subtype) + "." + container.extension + std::to_string(major);
      SNDFILE* file = sf_open(seeds.path("audio", name).c_str(), SFM_WRITE, &info);
      if (file == nullptr) continue;
      sf_writef_double(file, sound.data(), kFrames);
      sf_close(file);
    }
}

void write_marks(const Seeds& seeds) {
  const audio::Annotations marks = audio::annotations_of(onsets());
  const double duration_s = static_cast<double>(kFrames) / kRate_hz;
  seeds.write("audacity", "labels", audio::audacity_labels(marks));
  seeds.write("praat", "long", audio::text_grid(marks, duration_s));
  seeds.write(
      "praat", "short",
      "File type = \"ooTextFile\"\nObject class = \"TextGrid\"\n\n0\n1\n<exists>\n2\n\"IntervalTier\"\n\"w\"\n0\n1"
      "\n1\n0\n1\n\"\"\n\"TextTier\"\n\"a.wav\"\n0\n1\n1\n0.5\n\"0.1 t_s=0.5\"\n");
  seeds.write("sonic_visualiser", "layer", audio::sonic_visualiser_layer(marks, kRate_hz, kFrames));
  for (const char* name : {"12.wav", "12.rf64"}) {
    std::string copy;
    audio::copy_with_cues(
        seeds.path("audio", name), marks, [&](std::string_view bytes) { copy += bytes; }, name);
    seeds.write("wav_cues", name, copy);
  }
}

void write_foreign(const Seeds& seeds) {
  seeds.write("foreign", "list", "0.4\n1\n1.51\n1.9435\n");
  seeds.write("foreign", "row", "\"Start (s)\",\"Stop 1 (s)\",\"Stop 2 (s)\"\n4.0E-1,1.0E0,1.51E0\n");
  seeds.write("foreign", "comma", "Nr;Zeit (ms);Notiz\n1;400,0;a\n2;1000,0;b\n3;1510,0;\n");
  seeds.write("foreign", "clock",
              "Name\tStart\tDuration\nMarker 1\t0:00.400\t0:00.000\nMarker 2\t0:01.000\t0:00.000\n");
  seeds.write("foreign", "drops", "drop,dt (ms),level\n1,600,\n,480,3\n2,600,\n,480,\n\n3,590,\n,470,\n");
  seeds.write("foreign", "asked", "trial\tA (s)\tB [ms]\n1\t0,4\t9\n1\t1,0\t8\n2\t1,5\t7\n2\t1,9\t6\n");
  seeds.write("foreign", "fall", "0,6\n0,51\n0,4335\n");
  seeds.write("foreign", "dates", "at\n2026-11-28T10:00:00.5Z\n2026-11-28T11:00:01+01:00\n2026-11-28T10:00:01.5Z\n");
  seeds.write("foreign", "eps", "speed (cm/s);e\n120,5;0,85\n98,0;0,85\n");
  seeds.write("foreign", "utf16",
              std::string("\xFF\xFE"
                          "0\0.\0"
                          "4\0\n\0"
                          "1\0\n\0",
                          14));
}

void write_numbers(const Seeds& seeds) {
  std::string times = "Time (ms);Volt\n", alone;
  for (int k = 0; k < 40; ++k) {
    const std::string value = std::to_string(0.001 * ((k * 37) % 100));
    times += std::to_string(0.02 * k) + ";" + value + "\n";
    alone += value + "\n";
  }
  seeds.write("numbers", "times", times);
  seeds.write("numbers", "alone", alone);
  seeds.write("numbers", "scope", "x-axis,1\nsecond,Volt\n0.0E-5,+1.5E-3\n1.0E-5,-2.5E-3\n2.0E-5,0\n");
  std::string head = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 2), }";
  head.resize(117, ' ');
  seeds.write("numbers", "npy", std::string("\x93NUMPY\x01\0\x76\0", 10) + head + "\n" + std::string(32, '\0'));
}

void write_configs(const Seeds& seeds) {
  seeds.write("toml", "flat",
              "drops = 40\nsnr_db = [0, 6.5, 12]\nradius_law = \"constant:1e-3\"\nheight = [0.09, 0.1]\n");
  seeds.write("toml", "section",
              "# a comment\n[simulate]\ndrops = 0x10\nforce = true\nheight = [[0.05], [0.09, 0.1]]\n");
}

}  // namespace

int main(int n_arguments, char** arguments) {
  if (n_arguments != 2) {
    std::cerr << "usage: make_seeds FOLDER\n";
    return 2;
  }
  try {
    const Seeds seeds(arguments[1]);
    write_tables(seeds);
    write_recordings(seeds);
    write_foreign(seeds);
    write_numbers(seeds);
    write_foreign_recordings(seeds);
    write_marks(seeds);
    write_configs(seeds);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
}

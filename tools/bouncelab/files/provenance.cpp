// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/provenance.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/file_bytes.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/version.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

using namespace nlohmann::literals;

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Parameters& parameters) {
  Json json = Json::object();
  for (const Parameter& p : parameters) json[p.name] = p.values.size() == 1 ? Json(p.values.front()) : Json(p.values);
  return json;
}

Json json_of(const Corrections& c) {
  return {{"drag", c.drag},
          {"contact_time", c.contact_time},
          {"travel_time", c.travel_time},
          {"wave_speed_mps", c.wave_speed_mps},
          {"ball_radius_m", c.ball_radius_m},
          {"ball_density_kgpm3", c.ball_density_kgpm3},
          {"gravity_mps2", c.gravity_mps2}};
}

Json read_json(const fs::path& path) {
  std::ifstream in(path);
  try {
    return Json::parse(in);
  } catch (const Json::parse_error& error) {
    throw FileError(path.string(), std::string("is not JSON: ") + error.what());
  }
}

/// For a checksum no configuration of the system need be read.
const EVP_MD* sha256() {
  OPENSSL_init_crypto(OPENSSL_INIT_NO_LOAD_CONFIG, nullptr);
  return EVP_sha256();
}

using Digest = std::array<unsigned char, EVP_MAX_MD_SIZE>;

std::string in_hexadecimal(const Digest& digest, unsigned int size) {
  std::string text;
  for (unsigned int k = 0; k < size; ++k) text += fmt::format("{:02x}", digest[k]);
  return text;
}

}  // namespace

std::string sha256_of_file(const fs::path& path) {
  FileBytes file(path);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  EVP_DigestInit_ex(context.get(), sha256(), nullptr);
  constexpr std::int64_t kAtOnce = 1 << 18;
  for (std::int64_t done = 0; done < file.size(); done += kAtOnce) {
    const auto bytes = file.at(done, std::min(kAtOnce, file.size() - done));
    EVP_DigestUpdate(context.get(), bytes.data(), bytes.size());
  }
  Digest digest{};
  unsigned int size = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &size);
  return in_hexadecimal(digest, size);
}

void write_provenance(const Run& run, const fs::path& output, const std::vector<fs::path>& inputs,
                      const std::optional<Corrections>& corrections) {
  Json meta;
  meta["command_line"] = run.command_line;
  meta["version"] = version();
  meta["commit"] = commit();
  meta["seed"] = run.common.seed;
  meta["inputs"] = Json::array();
  for (const fs::path& input : inputs)
    meta["inputs"].push_back({{"path", input.string()}, {"sha256", sha256_of_file(input)}});
  meta["parameters"] = json_of(run.parameters);
  if (corrections) meta["parameters"]["corrections"] = json_of(*corrections);
  write_whole(output.string() + ".meta.json", meta.dump(2) + "\n", true);
}

void apply_corrections(const fs::path& samples, fit::BudgetConfig& budget) {
  const fs::path path = samples.string() + ".meta.json";
  if (!fs::exists(path)) return;
  const Json corrections = read_json(path).value("/parameters/corrections"_json_pointer, Json::object());
  const auto set = [&](const char* key, fit::Effect& effect) {
    if (effect == fit::Effect::present && corrections.value(key, false)) effect = fit::Effect::corrected;
  };
  set("drag", budget.drag);
  set("contact_time", budget.contact_time);
  set("travel_time", budget.travel_time);
  budget.wave_speed_mps = corrections.value("wave_speed_mps", budget.wave_speed_mps);
  budget.ball.radius_m = corrections.value("ball_radius_m", budget.ball.radius_m);
  budget.ball.material.density_kgpm3 = corrections.value("ball_density_kgpm3", budget.ball.material.density_kgpm3);
  budget.gravity_mps2 = corrections.value("gravity_mps2", budget.gravity_mps2);
}

}  // namespace bouncelab::cli

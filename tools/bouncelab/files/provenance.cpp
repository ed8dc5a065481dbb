// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/provenance.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/file_bytes.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/version.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Parameters& parameters) {
  Json json = Json::object();
  for (const Parameter& p : parameters) json[p.name] = p.values.size() == 1 ? Json(p.values.front()) : Json(p.values);
  return json;
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

void write_provenance(const Run& run, const fs::path& output, const std::vector<fs::path>& inputs) {
  Json meta;
  meta["command_line"] = run.command_line;
  meta["version"] = version();
  meta["commit"] = commit();
  meta["seed"] = run.common.seed;
  meta["inputs"] = Json::array();
  for (const fs::path& input : inputs)
    meta["inputs"].push_back({{"path", input.string()}, {"sha256", sha256_of_file(input)}});
  meta["parameters"] = json_of(run.parameters);
  write_whole(output.string() + ".meta.json", meta.dump(2) + "\n", true);
}

}  // namespace bouncelab::cli

#include "core/fingerprint.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "core/error.h"

namespace backsight {

struct Fingerprint::State {
  State() : xxh(XXH3_createState()) { XXH3_128bits_reset(xxh); }
  ~State() { XXH3_freeState(xxh); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  XXH3_state_t* xxh;
};

Fingerprint::Fingerprint() : state_(std::make_unique<State>()) {}
Fingerprint::~Fingerprint() = default;
Fingerprint::Fingerprint(Fingerprint&&) noexcept = default;
Fingerprint& Fingerprint::operator=(Fingerprint&&) noexcept = default;

void Fingerprint::Add(std::span<const std::byte> bytes) {
  XXH3_128bits_update(state_->xxh, bytes.data(), bytes.size());
}

void Fingerprint::Add(std::string_view text) {
  Add(static_cast<std::uint64_t>(text.size()));
  XXH3_128bits_update(state_->xxh, text.data(), text.size());
}

void Fingerprint::Add(std::uint64_t value) {
  XXH3_128bits_update(state_->xxh, &value, sizeof(value));
}

std::string Fingerprint::Hex() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(state_->xxh);
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::uint64_t Fingerprint::Value64() const { return XXH3_128bits_digest(state_->xxh).low64; }

std::string FingerprintText(std::string_view text) {
  Fingerprint fingerprint;
  fingerprint.Add(text);
  return fingerprint.Hex();
}

std::string FingerprintFile(const std::string& path, const std::function<void()>& between) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw InputError(
        {path, std::string("cannot be opened: ") + std::strerror(errno), "a readable file", ""});
  }
  Fingerprint fingerprint;
  std::vector<char> buffer(1U << 20U);
  while (file) {
    if (between) between();
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    fingerprint.Add(
        std::as_bytes(std::span(buffer.data(), static_cast<std::size_t>(file.gcount()))));
  }
  if (file.bad()) throw InputError({path, "reading failed", "", "check the disk"});
  return fingerprint.Hex();
}

}  // namespace backsight

#include "io/artifact_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <span>

#include "core/error.h"
#include "core/fingerprint.h"
#include "io/atomic_file.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".artifact";
constexpr std::string_view kMagic = "backsight artifact 1\n";
constexpr std::size_t kDigestBytes = 32;
constexpr std::uint64_t kLongestKey = std::uint64_t{1} << 28U;

/// File: magic, length of key, length of bytes, checksum of both, key, bytes.
struct Header {
  std::uint64_t key_bytes = 0;
  std::uint64_t payload_bytes = 0;
  std::string digest;
};
constexpr std::size_t kHeaderBytes = kMagic.size() + 2 * sizeof(std::uint64_t) + kDigestBytes;

/// Of key and bytes, before the bytes are added.
Fingerprint BeginDigest(std::string_view key, std::uint64_t payload_bytes) {
  Fingerprint fingerprint;
  fingerprint.Add(key);
  fingerprint.Add(payload_bytes);
  return fingerprint;
}

void AddPiece(std::string_view piece, Fingerprint* fingerprint) {
  fingerprint->Add(std::as_bytes(std::span(piece)));
}

std::string DigestOf(std::string_view key, std::string_view payload) {
  Fingerprint fingerprint = BeginDigest(key, payload.size());
  AddPiece(payload, &fingerprint);
  return fingerprint.Hex();
}

std::string HeaderBytes(const Header& header) {
  const std::uint64_t lengths[2] = {header.key_bytes, header.payload_bytes};
  std::string bytes(kMagic);
  bytes.append(reinterpret_cast<const char*>(lengths), sizeof(lengths));
  return bytes + header.digest;
}

/// A file being read; `fault` says what is wrong with it so far.
struct Opened {
  std::ifstream file;
  Header header;
  std::string key;
  std::string fault;
};

Opened Open(const std::string& path) {
  Opened opened;
  opened.file.open(path, std::ios::binary);
  std::string start(kHeaderBytes, '\0');
  if (!opened.file.read(start.data(), static_cast<std::streamsize>(start.size()))) {
    opened.fault = "it cannot be read or is too short";
    return opened;
  }
  if (!start.starts_with(kMagic)) {
    opened.fault = "it does not begin as an artifact";
    return opened;
  }
  std::uint64_t lengths[2];
  std::memcpy(lengths, start.data() + kMagic.size(), sizeof(lengths));
  opened.header = {lengths[0], lengths[1], start.substr(kHeaderBytes - kDigestBytes)};
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  const bool plausible = !error && lengths[0] <= kLongestKey && lengths[1] <= size &&
                         kHeaderBytes + lengths[0] + lengths[1] == size;
  if (!plausible) {
    opened.fault = fmt::format("it holds {} bytes, not the {} + {} + {} it states", size,
                               kHeaderBytes, lengths[0], lengths[1]);
    return opened;
  }
  opened.key.resize(lengths[0]);
  if (!opened.file.read(opened.key.data(), static_cast<std::streamsize>(opened.key.size()))) {
    opened.fault = "its key cannot be read";
  }
  return opened;
}

}  // namespace

void ArtifactKey::Add(std::string_view name, std::string_view value) {
  text_.append(name).append(": ");
  for (const char c : value) text_ += c == '\n' ? std::string("\\n") : std::string(1, c);
  text_ += '\n';
}

void ArtifactKey::Add(std::string_view name, double value) {
  Add(name, fmt::format("{:a}", value));
}

void ArtifactKey::AddLines(std::string_view lines) {
  while (!lines.empty()) {
    const std::size_t end = std::min(lines.find('\n'), lines.size());
    const std::string_view line = lines.substr(0, end);
    const std::size_t equals = std::min(line.find('='), line.size());
    Add(line.substr(0, equals), line.substr(std::min(equals + 1, line.size())));
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
}

ArtifactKey ArtifactKey::OfText(std::string text) {
  ArtifactKey key;
  key.text_ = std::move(text);
  return key;
}

std::string ArtifactKey::Digest() const { return FingerprintText(text_); }

ArtifactStore::ArtifactStore(std::string folder, std::function<void(const std::string&)> report)
    : folder_(std::move(folder)), report_(std::move(report)) {}

std::string ArtifactStore::PathOf(const std::string& name) const {
  return (fs::path(folder_) / (name + std::string(kExtension))).string();
}

bool ArtifactStore::Load(const std::string& name, const ArtifactKey& key,
                         std::string* bytes) const {
  std::error_code error;
  if (!keeps() || !fs::exists(PathOf(name), error)) return false;
  Opened opened = Open(PathOf(name));
  if (opened.fault.empty()) {
    bytes->resize(opened.header.payload_bytes);
    opened.file.read(bytes->data(), static_cast<std::streamsize>(bytes->size()));
    const bool whole = opened.file && DigestOf(opened.key, *bytes) == opened.header.digest;
    if (whole) return opened.key == key.text();
    opened.fault = "its checksum does not fit its content";
  }
  ReportDamaged(name, opened.fault);
  return false;
}

void ArtifactStore::ReportDamaged(const std::string& name, const std::string& fault) const {
  if (!report_) return;
  report_(fmt::format("{} is damaged: {}; it is made anew", PathOf(name), fault));
}

void ArtifactStore::Store(const std::string& name, const ArtifactKey& key,
                          std::string_view bytes) const {
  Store(name, key, {bytes.size(), [&](const auto& put) { put(bytes); }});
}

void ArtifactStore::Store(const std::string& name, const ArtifactKey& key,
                          const ArtifactBytes& bytes) const {
  if (!keeps()) return;
  const std::string path = PathOf(name);
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);  // the file tells what is wrong
  AtomicFile file(path);
  Header header{key.text().size(), bytes.size, std::string(kDigestBytes, ' ')};
  file.Write(HeaderBytes(header));
  file.Write(key.text());
  Fingerprint fingerprint = BeginDigest(key.text(), bytes.size);
  std::uint64_t written = 0;
  bytes.write([&](std::string_view piece) {
    file.Write(piece);
    AddPiece(piece, &fingerprint);
    written += piece.size();
  });
  BACKSIGHT_CHECK(written == bytes.size, "an artifact has another size than it said");
  header.digest = fingerprint.Hex();
  file.Overwrite(0, HeaderBytes(header));
  file.Commit();
}

ArtifactState ArtifactStore::Look(const std::string& name, const ArtifactKey& key) const {
  std::error_code error;
  if (!keeps() || !fs::exists(PathOf(name), error)) return {};
  const Opened opened = Open(PathOf(name));
  if (!opened.fault.empty()) return {ArtifactState::Kind::kDamaged, {opened.fault}, {}};
  if (opened.key == key.text()) return {ArtifactState::Kind::kUpToDate, {}, opened.key};
  return {ArtifactState::Kind::kOutdated, DifferingLines(opened.key, key.text()), opened.key};
}

void ArtifactStore::Remove(const std::string& name) const {
  std::error_code error;
  if (keeps()) fs::remove(PathOf(name), error);
}

std::multimap<std::string, std::string> KeyLines(std::string_view text) {
  std::multimap<std::string, std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const std::size_t colon = line.find(": ");
    if (colon != std::string_view::npos)
      lines.emplace(line.substr(0, colon), line.substr(colon + 2));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string> DifferingLines(std::string_view a, std::string_view b) {
  const auto lines_a = KeyLines(a);
  const auto lines_b = KeyLines(b);
  std::set<std::string> names;
  const auto add_missing = [&](const auto& from, const auto& in) {
    for (const auto& [name, value] : from) {
      const auto [begin, end] = in.equal_range(name);
      const bool there =
          std::any_of(begin, end, [&v = value](const auto& l) { return l.second == v; });
      if (!there) names.insert(name);
    }
  };
  add_missing(lines_a, lines_b);
  add_missing(lines_b, lines_a);
  return {names.begin(), names.end()};
}

}  // namespace backsight

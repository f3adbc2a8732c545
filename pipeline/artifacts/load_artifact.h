#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/archive.h"
#include "io/artifact_store.h"

namespace backsight {

/// What `decode` makes of the bytes stored under the key; nothing where none are, or where they
/// hold something else (DamagedArchive), which is reported, so that the result is computed anew.
template <class Decode>
std::optional<std::invoke_result_t<Decode, std::string_view>> LoadArtifact(
    const ArtifactStore& store, const std::string& name, const ArtifactKey& key, Decode decode) {
  std::string bytes;
  if (!store.Load(name, key, &bytes)) return std::nullopt;
  try {
    return decode(std::string_view(bytes));
  } catch (const DamagedArchive& damage) {
    store.ReportDamaged(name, damage.what());
    return std::nullopt;
  }
}

/// The stored result of the key, or else a new one, which is stored then.
template <class Encode, class Decode, class Compute>
std::invoke_result_t<Compute> Once(const ArtifactStore& store, const std::string& name,
                                   const ArtifactKey& key, Encode encode, Decode decode,
                                   Compute compute) {
  if (auto stored = LoadArtifact(store, name, key, decode)) return *std::move(stored);
  std::invoke_result_t<Compute> result = compute();
  if (store.keeps()) store.Store(name, key, encode(result));
  return result;
}

}  // namespace backsight

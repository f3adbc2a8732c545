#include "pipeline/artifacts/fault_record.h"

#include <algorithm>
#include <filesystem>

#include "core/error.h"

namespace backsight {
namespace {

std::string RecordOf(const std::string& name) { return name + "-fault"; }

}  // namespace

void KeepFault(const ArtifactStore& store, const std::string& name, const ArtifactKey& key,
               const std::string& fault) {
  if (!store.keeps()) return;
  try {
    store.Store(RecordOf(name), key, fault);
  } catch (const StorageFailure&) {
    store.Remove(RecordOf(name));
  }
}

bool HoldsFault(const ArtifactStore& store, const std::string& name) {
  std::error_code error;
  return std::filesystem::exists(store.PathOf(RecordOf(name)), error);
}

std::optional<std::string> KnownFault(const ArtifactStore& store, const std::string& name,
                                      const ArtifactKey& key,
                                      const std::function<bool(const std::string&)>& may_differ) {
  const ArtifactState state = store.Look(RecordOf(name), key);
  if (state.kind != ArtifactState::Kind::kUpToDate &&
      state.kind != ArtifactState::Kind::kOutdated) {
    return std::nullopt;
  }
  if (!std::all_of(state.why.begin(), state.why.end(), may_differ)) return std::nullopt;
  std::string fault;
  if (!store.Load(RecordOf(name), ArtifactKey::OfText(state.key_text), &fault)) return std::nullopt;
  return fault;
}

void ForgetFault(const ArtifactStore& store, const std::string& name) {
  store.Remove(RecordOf(name));
}

}  // namespace backsight

#include "pipeline/artifacts/fault_record.h"

namespace backsight {
namespace {

std::string RecordOf(const std::string& name) { return name + "-fault"; }

}  // namespace

void KeepFault(const ArtifactStore& store, const std::string& name, const ArtifactKey& key,
               const std::string& fault) {
  if (store.keeps()) store.Store(RecordOf(name), key, fault);
}

std::optional<std::string> KnownFault(const ArtifactStore& store, const std::string& name,
                                      const ArtifactKey& key) {
  std::string fault;
  if (!store.Load(RecordOf(name), key, &fault)) return std::nullopt;
  return fault;
}

void ForgetFault(const ArtifactStore& store, const std::string& name) {
  if (store.keeps()) store.Remove(RecordOf(name));
}

}  // namespace backsight

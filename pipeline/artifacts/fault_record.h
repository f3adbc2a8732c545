#pragma once

#include <optional>
#include <string>

#include "io/artifact_store.h"

namespace backsight {

/// Keeps beside the artifact `name` why what `key` says could not be made, for plans and status
/// only: a run tries again, whatever is kept. Throws StorageFailure.
void KeepFault(const ArtifactStore& store, const std::string& name, const ArtifactKey& key,
               const std::string& fault);

/// Why what `key` says could not be made, where the last attempt at `name` was one at just that.
std::optional<std::string> KnownFault(const ArtifactStore& store, const std::string& name,
                                      const ArtifactKey& key);

/// The artifact `name` could be made.
void ForgetFault(const ArtifactStore& store, const std::string& name);

}  // namespace backsight

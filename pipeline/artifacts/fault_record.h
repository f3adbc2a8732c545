#pragma once

#include <functional>
#include <optional>
#include <string>

#include "io/artifact_store.h"

namespace backsight {

/// Keeps beside the artifact `name` why what `key` says could not be made, for plans and status
/// only: a run tries again, whatever is kept. Where it cannot be kept, nothing happens: the run is
/// worth more.
void KeepFault(const ArtifactStore& store, const std::string& name, const ArtifactKey& key,
               const std::string& fault);

/// Whether some fault is kept beside the artifact `name`, whatever it is of.
bool HoldsFault(const ArtifactStore& store, const std::string& name);

/// Why what `key` says could not be made, where the last attempt at `name` was one at just that,
/// but for lines of the key that `may_differ`.
std::optional<std::string> KnownFault(const ArtifactStore& store, const std::string& name,
                                      const ArtifactKey& key,
                                      const std::function<bool(const std::string&)>& may_differ);

/// The artifact `name` is tried anew.
void ForgetFault(const ArtifactStore& store, const std::string& name);

}  // namespace backsight

#pragma once

#include <functional>
#include <string>

#include "core/execution.h"
#include "io/artifact_store.h"
#include "pipeline/output_source.h"

namespace backsight {

/// Writes an output unless it lies there as an earlier run wrote it: made from the same `key`, with
/// the same sizes and times of change. `path` names the output.
OutputFiles WriteOnce(const ArtifactStore& store, const std::string& path, ArtifactKey key,
                      const ExecutionContext& context, const std::function<OutputFiles()>& write);

/// Whether all files of an output lie there as WriteOnce knows them, whatever they were made from.
bool LiesAsWritten(const ArtifactStore& store, const std::string& path);

/// Where WriteOnce keeps what it knows of an output, and under what key.
std::string OutputArtifactName(const std::string& path);

}  // namespace backsight

#pragma once

#include <string_view>

#include "io/artifact_store.h"
#include "pipeline/station_pipeline.h"

namespace backsight {

/// What is computed of a usable station, as bytes; neither what the project says of it nor what its
/// model implies (index, range image). The station must outlive them
/// and not change.
ArtifactBytes StationBytes(const Station& station);
ArtifactBytes StationBytes(Station&&) = delete;

/// Fills what StationBytes keeps, and what follows from it, into a station whose `spec` is set.
/// Throws DamagedArchive.
void RestoreStation(std::string_view bytes, Station* station);

}  // namespace backsight

#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/execution.h"
#include "io/artifact_store.h"
#include "io/run_records.h"
#include "io/scan_reader.h"
#include "io/survey_project.h"
#include "pipeline/artifacts/scan_fingerprints.h"
#include "pipeline/prepared_station.h"
#include "pipeline/survey_options.h"
#include "pipeline/work_queue.h"
#include "stages/cloud_agreement.h"
#include "stages/station_model.h"
#include "stages/surface.h"

namespace backsight {

/// The fault of stations and pairs that memory does not suffice for, even alone.
inline constexpr const char* kShortOfMemory =
    "needs more memory than the budget leaves; raise resources.memory_gb or --memory-gb";

/// What is to be said of a station whose scanner was forgotten.
inline constexpr const char* kScannerForgotten =
    "its scanner does not seem to have stood at the scan's origin: from there it would have seen "
    "through surfaces that several other stations measured, which all place the station alike; "
    "the scan was taken as one whose scanner is unknown; give scanner_origin_m if you know it";

/// One station from scan file to features. A station that cannot be used carries the reason; the
/// others go on.
struct Station {
  StationSpec spec;
  StationModel model;
  StationFeatures features;
  std::shared_ptr<const CloudIndex> index;  ///< of the model; set where usable
  std::vector<RigidTransform> symmetries;   ///< of the station's own cloud
  PreparedStation prepared;                 ///< what pairs need of it alone
  ScanInfo info;
  ScanRecord record;
  std::string fault;                ///< empty: usable
  bool short_of_memory = false;     ///< its fault is that memory ran out
  std::string content_fingerprint;  ///< of the voxel clusters
  ScanIdentity scan;                ///< of the scan file; empty where nothing is kept
  std::string digest;  ///< stands for all that led here (StationKey); empty where nothing is kept

  bool usable() const { return fault.empty(); }
  Surface surface() const { return {model, features.normals, features.scanner_credible}; }
};

/// The stations before they are loaded.
std::vector<Station> ListStations(const std::vector<StationSpec>& specs);

/// What pairs needed of the stations is made anew for those to come.
void ForgetPrepared(std::vector<Station>* stations);

/// Told of every station that is there and usable, from any thread; works that it adds are begun
/// where no station waits for a thread, and only until the last one is there. It throws nothing.
using StationLoaded = std::function<void(std::size_t station, WorkQueue* queue)>;

/// Reads and describes all stations, side by side. A station whose scan equals an earlier station's
/// is refused as a copy: it would register perfectly and prove nothing. What the store holds is not
/// computed again. Throws StorageFailure where it does not take what was computed.
void LoadStations(const SurveyOptions& options, const ExecutionContext& context,
                  const ArtifactStore& store, const StationLoaded& loaded,
                  std::vector<Station>* stations);
std::vector<Station> LoadStations(const std::vector<StationSpec>& specs,
                                  const SurveyOptions& options, const ExecutionContext& context,
                                  const ArtifactStore& store = {});

/// The digest of a station whose scanner was forgotten.
std::string WithoutScanner(const std::string& digest);

/// Takes the station as one whose scanner may have stood anywhere, and describes its surface anew.
/// What is thrown leaves the station as it was.
void ForgetScanner(const SurveyOptions& options, const ExecutionContext& context, Station* station);

}  // namespace backsight

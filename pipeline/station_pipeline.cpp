#include "pipeline/station_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/fingerprint.h"
#include "core/free_memory.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/fault_record.h"
#include "pipeline/artifacts/load_artifact.h"
#include "pipeline/artifacts/station_artifact.h"
#include "stages/station_symmetries.h"

namespace backsight {
namespace {

double ExtentOf(const StationModel& model) {
  std::vector<double> ranges;
  ranges.reserve(model.leaves.size());
  for (const Eigen::Vector3d& mean : model.leaves.means()) ranges.push_back(mean.norm());
  const auto place = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 95 / 100);
  std::nth_element(ranges.begin(), place, ranges.end());
  return *place;
}

std::string FingerprintOf(const StationModel& model) {
  Fingerprint fingerprint;
  for (std::size_t i = 0; i < model.leaves.size(); ++i) {
    fingerprint.Add(model.leaves.Key(i));
    const Eigen::Vector3d mean = model.leaves.Mean(i);
    const double values[4] = {model.leaves.Count(i), mean.x(), mean.y(), mean.z()};
    fingerprint.Add(std::as_bytes(std::span(values)));
  }
  return fingerprint.Hex();
}

void FillRecord(const IngestResult& ingest, Station* station) {
  ScanRecord& record = station->record;
  record.format = station->info.format;
  record.records = ingest.tally.records;
  record.points = ingest.model.points;
  record.dropped = ingest.tally.records - ingest.model.points;
  record.leaves = ingest.model.leaves.size();
  const std::vector<std::string>* const all_notes[] = {&station->info.notes, &ingest.tally.notes,
                                                       &ingest.notes};
  for (const auto* notes : all_notes) {
    record.notes.insert(record.notes.end(), notes->begin(), notes->end());
  }
  const auto note_count = [&](std::uint64_t count, const char* what) {
    if (count > 0) record.notes.push_back(fmt::format("{} {}", count, what));
  };
  note_count(ingest.tally.not_finite, "points with NaN or infinite coordinates dropped");
  note_count(ingest.tally.no_return, "empty records (no return) passed over");
  note_count(ingest.tally.withheld, "points flagged as withheld (deleted) passed over");
  note_count(ingest.out_of_range, "points outside the range limits dropped");
}

/// Features, and where the cloud looks like itself.
void DescribeSurface(const SurveyOptions& options, const ExecutionContext& context,
                     Station* station) {
  station->features = ComputeFeatures(station->model, options.features, context);
  station->record.keypoints = station->features.keypoints.size();
  station->symmetries = FindSymmetries(station->surface(), station->features, *station->index,
                                       options.matching, options.coarse, context);
}

void ComputeStation(const SurveyOptions& options, const ExecutionContext& context,
                    Station* station) {
  const std::unique_ptr<ScanReader> reader =
      OpenScan(station->spec.scan, station->spec.scan_index, station->spec.columns,
               [&context] { context.CheckStop(); });
  station->info = reader->info();
  IngestResult ingest = IngestScan(station->spec.id, *reader, station->spec.scanner_origin_m,
                                   options.ingest, context);
  FillRecord(ingest, station);
  station->model = std::move(ingest.model);
  station->record.extent_m = ExtentOf(station->model);
  station->content_fingerprint = FingerprintOf(station->model);
  station->index = std::make_shared<const CloudIndex>(station->model);
  DescribeSurface(options, context, station);
  if (!station->features.scanner_credible) {
    station->record.notes.push_back(
        "the scan does not look as if its scanner had stood at (0, 0, 0); normals were oriented by "
        "the surface itself; give scanner_origin_m if you know it");
  }
}

/// From the store where it holds the station, otherwise from the scan.
void LoadStation(const SurveyOptions& options, const ExecutionContext& context,
                 const ArtifactStore& store, ScanFingerprints* scans, Station* station) {
  if (!store.keeps()) return ComputeStation(options, context, station);
  station->scan = scans->Of(station->spec.scan, context);
  const ArtifactKey key =
      StationKey({options, context.seed()}, station->spec, station->scan.fingerprint);
  const std::string name = StationArtifactName(station->spec.id);
  station->digest = key.Digest();
  auto restored = LoadArtifact(store, name, key, [&](std::string_view bytes) {
    Station stored = *station;
    RestoreStation(bytes, &stored);
    return stored;
  });
  if (restored) {
    *station = *std::move(restored);
    return;
  }
  ForgetFault(store, name);
  ComputeStation(options, context, station);
  RequireUnchanged(station->spec.scan, station->scan, context);
  ReturnFreeMemory();  // of the points and histograms on the way there
  store.Store(name, key, StationBytes(*station));
}

void RefuseCopies(std::vector<Station>* stations) {
  for (std::size_t i = 0; i < stations->size(); ++i) {
    Station& station = (*stations)[i];
    for (std::size_t j = 0; j < i && station.usable(); ++j) {
      const Station& earlier = (*stations)[j];
      if (!earlier.usable() || earlier.content_fingerprint != station.content_fingerprint) continue;
      station.fault = fmt::format(
          "{} holds the same points as station {} ({}); name the right file, or take the station "
          "out",
          station.spec.scan, earlier.spec.id, earlier.spec.scan);
    }
  }
}

/// What goes wrong ends in the station's `fault`.
void LoadGuarded(const SurveyOptions& options, const ExecutionContext& context,
                 const ArtifactStore& store, ScanFingerprints* scans, Station* station) {
  try {
    context.CheckStop();
    LoadStation(options, context, store, scans, station);
  } catch (const Interrupted&) {
    throw;
  } catch (const StorageFailure&) {
    throw;
  } catch (const std::bad_alloc&) {
    station->fault = kShortOfMemory;
    station->short_of_memory = true;
  } catch (const std::exception& error) {
    station->fault = error.what();
  }
  if (station->usable()) return;
  const std::string scan = station->scan.fingerprint.empty() ? UnreadFingerprint(station->spec.scan)
                                                             : station->scan.fingerprint;
  KeepFault(store, StationArtifactName(station->spec.id),
            StationKey({options, context.seed()}, station->spec, scan), station->fault);
}

/// Of the scan file, which says roughly how long the station takes.
double ScanBytes(const StationSpec& spec) {
  std::error_code error;
  const auto size = std::filesystem::file_size(spec.scan, error);
  return error ? 0.0 : static_cast<double>(size);
}

Station MakeStation(const StationSpec& spec, PreparedStation prepared) {
  Station station;
  station.spec = spec;
  station.prepared = std::move(prepared);
  station.record.station = spec.id;
  station.record.path = spec.scan;
  return station;
}

/// Loads stations, the largest scans first, and does meanwhile what `loaded` adds.
void LoadSideBySide(const SurveyOptions& options, const ExecutionContext& context,
                    const ArtifactStore& store, const StationLoaded& loaded,
                    ScanFingerprints* scans, std::vector<Station>* stations) {
  std::atomic<std::size_t> done = 0;
  context.Progress("stations", 0, stations->size());
  WorkQueue queue(context);
  for (std::size_t i = 0; i < stations->size(); ++i) {
    constexpr int kBeforeOthers = 1;
    Station& station = (*stations)[i];
    queue.Add({.rank = kBeforeOthers, .weight = ScanBytes(station.spec)}, [&, i] {
      LoadGuarded(options, context, store, scans, &station);
      if (station.usable() && loaded) loaded(i, &queue);
      const std::size_t ended = ++done;
      if (ended == stations->size()) {
        queue.Clear();
      } else {
        context.Progress("stations", ended, stations->size());
      }
    });
  }
  queue.Run();
  context.Progress("stations", stations->size(), stations->size());
}

}  // namespace

std::string WithoutScanner(const std::string& digest) {
  return digest.empty() ? digest : digest + " without scanner";
}

void ForgetScanner(const SurveyOptions& options, const ExecutionContext& context,
                   Station* station) {
  Station forgetful = *station;
  forgetful.model.scanner_place = ScannerPlace::kUnknown;
  DescribeSurface(options, context, &forgetful);
  forgetful.digest = WithoutScanner(station->digest);
  forgetful.record.notes.emplace_back(kScannerForgotten);
  *station = std::move(forgetful);
}

void ForgetPrepared(std::vector<Station>* stations) {
  const auto last_planes = std::make_shared<LastPlanes>();
  for (Station& station : *stations) station.prepared = PreparedStation(last_planes);
  ReturnFreeMemory();
}

std::vector<Station> ListStations(const std::vector<StationSpec>& specs) {
  std::vector<Station> stations;
  stations.reserve(specs.size());
  for (const StationSpec& spec : specs) stations.push_back(MakeStation(spec, PreparedStation()));
  ForgetPrepared(&stations);
  return stations;
}

void LoadStations(const SurveyOptions& options, const ExecutionContext& context,
                  const ArtifactStore& store, const StationLoaded& loaded,
                  std::vector<Station>* stations) {
  ScanFingerprints scans(store);
  LoadSideBySide(options, context, store, loaded, &scans, stations);
  for (Station& station : *stations) {  // what found no memory beside others, alone
    if (!station.short_of_memory) continue;
    ForgetPrepared(stations);
    station = MakeStation(station.spec, std::move(station.prepared));
    LoadGuarded(options, context, store, &scans, &station);
  }
  RefuseCopies(stations);
  for (const Station& station : *stations) {
    if (!station.usable()) context.Warning("station " + station.spec.id + ": " + station.fault);
  }
}

std::vector<Station> LoadStations(const std::vector<StationSpec>& specs,
                                  const SurveyOptions& options, const ExecutionContext& context,
                                  const ArtifactStore& store) {
  std::vector<Station> stations = ListStations(specs);
  LoadStations(options, context, store, {}, &stations);
  return stations;
}

}  // namespace backsight

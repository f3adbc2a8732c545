#include "pipeline/artifacts/station_artifact.h"

#include "core/archive.h"

namespace backsight {

template <class Archive>
void Transfer(Archive& archive, StationModel& model) {
  archive(model.id, model.scanner_origin, model.scanner_place, model.leaves, model.min, model.max,
          model.points);
  double pixel_deg = 180.0 / model.range_image.rows();
  archive(pixel_deg);
  if constexpr (Archive::kReads) model.range_image = ImageOf(model.leaves, pixel_deg);
}

template <class Archive>
void Transfer(Archive& archive, StationFeatures& features) {
  archive(features.normals, features.keypoints, features.descriptors, features.scanner_credible);
}

template <class Archive>
void Transfer(Archive& archive, ScanInfo& info) {
  archive(info.format, info.scan_index, info.scan_count, info.point_count, info.has_intensity,
          info.has_rgb, info.rgb_16_bit, info.has_classification, info.has_gps_time, info.rows,
          info.columns, info.guid, info.name, info.world_from_scan, info.crs, info.notes);
}

template <class Archive>
void Transfer(Archive& archive, ScanRecord& record) {
  archive(record.format, record.records, record.points, record.dropped, record.moving,
          record.leaves, record.keypoints, record.extent_m, record.notes);
}

template <class Archive>
void Transfer(Archive& archive, Station& station) {
  archive(station.model, station.features, station.symmetries, station.info, station.record,
          station.content_fingerprint);
}

ArtifactBytes StationBytes(const Station& station) {
  return {SizeInBytes(station), [&](const auto& put) { PutBytes(station, put); }};
}

void RestoreStation(std::string_view bytes, Station* station) {
  ArchiveReader reader(bytes);
  Transfer(reader, *station);
  if (reader.left() > 0) throw DamagedArchive();
  station->info.path = station->spec.scan;
  station->index = std::make_shared<const CloudIndex>(station->model);
}

}  // namespace backsight

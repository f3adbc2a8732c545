#pragma once

#include <concepts>
#include <optional>
#include <type_traits>

#include "io/report_document.h"

namespace backsight {

/// The keys of report.json, once for writing and reading. A visitor has
///   Field(key, value)               a value of its own type,
///   FieldIf(shown, key, value)      null unless shown; null leaves the value as it is,
///   Word(key, value, yes, no)       a bool as one of two words,
///   Derived(key, function)          only written: what follows from the other fields.
template <typename Given, typename Wanted>
concept RecordOf = std::same_as<std::remove_const_t<Given>, Wanted>;

template <typename Visitor, RecordOf<ErrorEllipse> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("semi_major_m", r.semi_major_m);
  v.Field("semi_minor_m", r.semi_minor_m);
  v.Field("azimuth_deg", r.azimuth_deg);
}

/// What follows from a motion's covariance.
template <typename Visitor>
void VisitSigmas(Visitor& v, const RigidTransform& motion,
                 const std::optional<Matrix6d>& covariance) {
  std::optional<PoseSigma> sigma;
  if (covariance) sigma = SigmaOf(motion, *covariance);
  const auto part = [&](auto member) {
    return [&sigma, member] { return sigma ? std::optional((*sigma).*member) : std::nullopt; };
  };
  v.Derived("sigma_position_m", part(&PoseSigma::position_m));
  v.Derived("sigma_worst_m", part(&PoseSigma::worst_position_m));
  v.Derived("sigma_rotation_deg", part(&PoseSigma::rotation_deg));
  v.Derived("error_ellipse", [&] {
    return covariance ? std::optional(EllipseOf(motion, *covariance)) : std::nullopt;
  });
}

template <typename Visitor, RecordOf<GroundPose> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("enu_from_station", r.enu_from_station);
  v.Field("covariance", r.covariance);
  VisitSigmas(v, r.enu_from_station, r.covariance);
  v.Field("crs_position", r.position);
}

template <typename Visitor, RecordOf<PoseRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("station", r.station);
  v.Field("status", r.status);
  const bool placed = r.status == StationStatus::kRegistered;
  v.Field("reason", r.reason);
  v.FieldIf(placed, "component", r.component);
  v.Field("links", r.link_count);
  v.FieldIf(placed, "survey_from_station", r.survey_from_station);
  v.FieldIf(placed, "covariance", r.covariance);
  VisitSigmas(v, r.survey_from_station, placed ? r.covariance : std::nullopt);
  v.FieldIf(placed, "ground", r.ground);
}

template <typename Visitor, RecordOf<HeldOutRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("planes", r.planes);
  v.Field("rms_before_m", r.rms_before_m);
  v.Field("rms_after_m", r.rms_after_m);
  v.Field("bias_before_m", r.bias_before_m);
  v.Field("bias_after_m", r.bias_after_m);
}

template <typename Visitor, RecordOf<WorstPlaceRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("direction", r.direction);
  v.Field("sigma_m", r.sigma_m);
}

template <typename Visitor, RecordOf<LinkRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("source", r.source);
  v.Field("target", r.target);
  v.Field("status", r.status);
  v.Field("reason", r.reason);
  v.Field("target_from_source", r.fine);
  v.Field("coarse_target_from_source", r.coarse);
  const bool refined = r.fine.has_value();
  const bool aligned = refined || r.coarse.has_value();
  v.Field("candidates", r.candidates);
  v.Field("predicted", r.predicted);
  v.FieldIf(aligned, "conflict", r.conflict);
  v.FieldIf(aligned, "agreement", r.agreement);
  v.FieldIf(aligned, "overlap", r.overlap);
  v.Field("rms_m", r.rms_m);
  v.Field("fine_status", r.fine_status);
  v.Field("correspondences", r.correspondences);
  v.Field("consensus", r.consensus);
  v.Field("consensus_null", r.consensus_null);
  v.FieldIf(refined, "planes", r.planes);
  v.Field("weakest_sigma_m", r.weakest_sigma_m);
  v.Field("worst_place", r.worst_place);
  v.FieldIf(refined, "iterations", r.iterations);
  v.Field("network_weight", r.network_weight);
  v.Field("network_residual_m", r.network_residual_m);
  v.Field("network_residual_deg", r.network_residual_deg);
  v.Field("network_residual_sigmas", r.network_residual_sigmas);
  v.Field("loop_controlled", r.loop_controlled);
  v.Field("covariance", r.covariance);
  v.Field("held_out", r.held_out);
}

template <typename Visitor, RecordOf<ClosureRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("stations", r.stations);
  v.Field("coarse_m", r.coarse_m);
  v.Field("coarse_deg", r.coarse_deg);
  v.Field("fine_m", r.fine_m);
  v.Field("fine_deg", r.fine_deg);
}

template <typename Visitor, RecordOf<ComponentRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("component", r.component);
  v.Field("stations", r.stations);
  v.Field("links", r.links);
  v.Field("redundancy", r.redundancy);
  v.Field("sigma_factor", r.sigma_factor);
  v.Field("refinement", r.refinement);
  v.Field("planes", r.planes);
  v.Field("observations", r.observations);
  v.Field("rounds", r.rounds);
  v.Field("iterations", r.iterations);
  v.Field("anderson_accepted", r.anderson_accepted);
  v.Field("plane_sigma_factor", r.plane_sigma_factor);
  v.Field("weakest_station", r.weakest_station);
  v.Field("weakest_sigma_m", r.weakest_sigma_m);
}

template <typename Visitor, RecordOf<SurveyPointRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("id", r.id);
  v.Word("role", r.check, "check", "control");
  v.Field("position", r.position);
  v.Field("excluded", r.excluded);
  v.Field("sightings", r.sightings);
  v.Field("residual_m", r.residual_m);
  v.Field("free_residual_m", r.free_residual_m);
  v.Field("w", r.w);
  v.Field("checked", r.checked);
  v.Field("sigma_m", r.sigma_m);
}

template <typename Visitor, RecordOf<CheckRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("points", r.points);
  v.Field("rmse_m", r.rmse_m);
  v.Field("rmse_horizontal_m", r.rmse_horizontal_m);
  v.Field("rmse_3d_m", r.rmse_3d_m);
  v.Field("predicted_3d_m", r.predicted_3d_m);
}

template <typename Visitor, RecordOf<ScaleRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("off_ppm", r.off_ppm);
  v.Field("sigma_ppm", r.sigma_ppm);
}

template <typename Visitor, RecordOf<GeoreferenceRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("component", r.component);
  v.Field("status", r.status);
  v.Field("crs", r.crs);
  v.Field("heights", r.heights);
  v.Field("origin_deg_deg_m", r.origin_deg_deg_m);
  v.Field("origin_crs_m", r.origin_crs_m);
  v.Field("convergence_deg", r.convergence_deg);
  v.Field("point_scale", r.point_scale);
  const bool placed = r.placed();
  v.FieldIf(placed, "enu_from_survey", r.enu_from_survey);
  v.FieldIf(placed, "scale", r.scale);
  v.Field("scale_test", r.scale_test);
  v.FieldIf(placed, "redundancy", r.redundancy);
  v.FieldIf(placed, "variance_factor", r.variance_factor);
  v.Field("points", r.points);
  v.Field("check", r.check);
}

template <typename Visitor, RecordOf<ScanRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("station", r.station);
  v.Field("path", r.path);
  v.Field("format", r.format);
  v.Field("records", r.records);
  v.Field("points", r.points);
  v.Field("dropped", r.dropped);
  v.Field("moving", r.moving);
  v.Field("leaves", r.leaves);
  v.Field("keypoints", r.keypoints);
  v.Field("extent_m", r.extent_m);
  v.Field("notes", r.notes);
}

template <typename Visitor, RecordOf<OutputRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("path", r.path);
  v.Field("format", r.format);
  v.Field("selection", r.selection);
  v.Field("points", r.points);
}

template <typename Visitor, RecordOf<GateRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("name", r.name);
  v.Field("limit", r.limit);
  v.Field("value", r.value);
  v.Field("passed", r.passed);
}

template <typename Visitor, RecordOf<DistanceFigures> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("samples", r.samples);
  v.Field("median_m", r.median_m);
  v.Field("p68_m", r.p68_m);
  v.Field("p95_m", r.p95_m);
}

template <typename Visitor, RecordOf<PairDistanceRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("stations", r.stations);
  v.Field("figures", r.figures);
}

template <typename Visitor, RecordOf<DistanceRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("search_m", r.search_m);
  v.Field("total", r.total);
  v.Field("bin_m", r.bin_m);
  v.Field("bins", r.bins);
  v.Field("beyond", r.beyond);
  v.Field("pairs", r.pairs);
}

template <typename Visitor, RecordOf<PictureKey> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("label", r.label);
  v.Field("rgb", r.rgb);
}

template <typename Visitor, RecordOf<PictureStop> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("value", r.value);
  v.Field("rgb", r.rgb);
}

template <typename Visitor, RecordOf<PictureScale> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("label", r.label);
  v.Field("stops", r.stops);
  v.Field("open_below", r.open_below);
  v.Field("open_above", r.open_above);
}

template <typename Visitor, RecordOf<PictureLine> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("label", r.label);
  v.Field("from", r.from);
  v.Field("to", r.to);
}

template <typename Visitor, RecordOf<PictureRecord> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("kind", r.kind);
  v.Field("title", r.title);
  v.Field("caption", r.caption);
  v.Field("width_px", r.width_px);
  v.Field("height_px", r.height_px);
  v.Field("metres_per_pixel", r.metres_per_pixel);
  v.Field("left_top", r.left_top);
  v.Field("across", r.across);
  v.Field("up", r.up);
  v.Field("keys", r.keys);
  v.Field("scale", r.scale);
  v.Field("lines", r.lines);
  v.Field("png_base64", r.png_base64);
}

template <typename Visitor, RecordOf<ReportDocument> Record>
void VisitFields(Visitor& v, Record& r) {
  v.Field("project_name", r.run.project_name);
  v.Field("version", r.run.version);
  v.Field("verdict", r.run.verdict);
  v.Field("exit_code", r.run.exit_code);
  v.Field("gates", r.run.gates);
  v.Field("network", r.run.network);
  v.Field("components", r.run.components);
  v.Field("closures", r.run.closures);
  v.Field("survey_points", r.run.survey_points);
  v.Field("georeference", r.run.georeference);
  v.Field("poses", r.run.poses);
  v.Field("links", r.run.links);
  v.Field("skipped_pairs", r.skipped_pairs);
  v.Field("scans", r.run.scans);
  v.Field("outputs", r.run.outputs);
  v.Field("warnings", r.run.warnings);
  v.Field("distances", r.run.distances);
  v.Field("pictures", r.pictures);
}

}  // namespace backsight

#pragma once

#include <string>
#include <vector>

#include "io/run_records.h"

namespace backsight {

/// The text of poses.csv, one line per station. Columns: station, component, status, tx_m ty_m tz_m
/// qw qx qy qz (survey_from_station), reason, links, sigma_x_m sigma_y_m sigma_z_m
/// sigma_worst_m (position of the station, survey axes), sigma_rx_deg sigma_ry_deg sigma_rz_deg.
/// Cells are empty where a station is not placed or has no covariance. Numbers read back exactly;
/// a non-finite one is an InternalError that names the field.
std::string PosesCsv(const std::vector<PoseRecord>& poses);

/// The text of links.csv, one line per pair, tried or skipped: every field of LinkRecord, units in
/// the names; tx_m ... qz is the fine and coarse_tx_m ... coarse_qz the coarse target_from_source.
/// Cells are empty for what was never computed.
std::string LinksCsv(const std::vector<LinkRecord>& links);

}  // namespace backsight

#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/rigid_transform.h"
#include "io/run_records.h"

namespace backsight {

/// The stations of a poses.csv with all columns but the sigmas (station, tx_m, ty_m, tz_m, qw, qx,
/// qy, qz are required; status "registered", "ok" or none means placed). Throws InputError with
/// file, line and column for what is damaged.
std::vector<PoseRecord> ReadPoseRecords(const std::string& path);

/// survey_from_station of every placed station: from a CSV file like poses.csv, or from a folder
/// with a truth.csv of that kind (a simulated campaign) or else gt_pose<i>.txt (4x4 by rows,
/// station i -> reference frame; the station's id is "s<i>").
/// Throws InputError; a file without any pose is an error too.
std::map<std::string, RigidTransform> ReadPoses(const std::string& path);

/// A 3DMatch gt.log: blocks "i j n" and a 4x4 matrix T with p_i = T p_j. The key is (source,
/// target) = ("cloud_bin_<j>", "cloud_bin_<i>"), the value target_from_source. Throws InputError.
std::map<std::pair<std::string, std::string>, RigidTransform> ReadRelativeLog(
    const std::string& path);

}  // namespace backsight

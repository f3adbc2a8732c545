#include "graph/plane_judge.h"

namespace backsight {

void PlaneJudge::Erase(std::size_t i) {
  const auto at = static_cast<std::ptrdiff_t>(i);
  stations_.erase(stations_.begin() + at);
  locals_.erase(locals_.begin() + at);
  world_.erase(world_.begin() + at);
  fits_.erase(fits_.begin() + at);
}

/// Leaves the stations that see one plane in the cell, moved to the world and with their normals.
void PlaneJudge::KeepPlanar() {
  fits_.resize(size());
  FitPlanes(locals_, /*normals=*/true, fits_);
  world_ = locals_;
  for (std::size_t i = size(); i-- > 0;) {
    if (!IsPlanar(fits_[i], options_)) Erase(i);
  }
  if (size() < 2) return;
  for (std::size_t i = 0; i < size(); ++i) {
    const RigidTransform& pose = poses_[stations_[i]];
    world_[i] = Transformed(pose.rotation, pose.translation, locals_[i]);
    fits_[i].normal = pose.rotation * fits_[i].normal;
  }
}

/// How far station i is from the joint plane, in units of what is allowed; below 1 it agrees.
double PlaneJudge::Disagreement(std::size_t i, const PointCluster& joint,
                                const PlaneFit& fit) const {
  const double cosine = std::abs(fits_[i].normal.dot(fit.normal));
  const Eigen::Vector3d offset = world_[i].mean - joint.mean;
  const double across = offset.dot(fit.normal);
  const double along = (offset - across * fit.normal).norm();
  return std::max({std::acos(std::min(cosine, 1.0)) / options_.max_angle_rad,
                   std::abs(across) / options_.max_offset_m,
                   along / (2.0 * std::sqrt(fit.eigenvalues[2]))});
}

bool PlaneJudge::Judge(std::vector<PlaneObservation>* observations) {
  KeepPlanar();
  while (size() >= 2) {
    PointCluster joint;
    for (const PointCluster& part : world_) joint += part;
    PlaneFit fit;
    FitPlanes(std::span(&joint, 1), /*normals=*/true, std::span(&fit, 1));
    // Only the worst goes: it may have pulled the joint plane away from the others.
    std::size_t worst = 0;
    double most = -1.0;
    for (std::size_t i = 0; i < size(); ++i) {
      const double disagreement = Disagreement(i, joint, fit);
      if (disagreement <= most) continue;
      worst = i;
      most = disagreement;
    }
    if (!(most < 1.0)) {
      Erase(worst);
      continue;
    }
    observations->reserve(size());
    for (std::size_t i = 0; i < size(); ++i) {
      observations->push_back({static_cast<int>(stations_[i]), locals_[i]});
    }
    return true;
  }
  return false;
}

}  // namespace backsight

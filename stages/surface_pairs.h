#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/rigid_transform.h"
#include "stages/cloud_agreement.h"
#include "stages/surface.h"
#include "stages/surface_kernels.h"

namespace backsight {

/// Voxels of a source and the nearest ones of a target under motions that differ
/// little from one to the next: a voxel that has moved by less than its nearest is closer than all
/// others keeps it. Memory 136 bytes per chosen voxel.
class SurfacePairs {
 public:
  /// `chosen`: voxels of the source with a defined normal. What the surfaces refer to, and the
  /// index, must outlive it.
  SurfacePairs(const Surface& source, const Surface& target, const CloudIndex& target_index,
               std::span<const std::uint32_t> chosen, double reach_m);

  /// Normal equations of the pairs within the rule, whose reach is that of the constructor.
  SurfacePairSums Sum(const RigidTransform& target_from_source, const SurfacePairRule& rule);

 private:
  using Column = std::unique_ptr<double[]>;
  using Columns = std::array<Column, 3>;
  void AskAgain(const RigidTransform& target_from_source, std::size_t count);
  SurfacePairColumns View() const;

  Surface target_;
  const CloudIndex& index_;
  double reach_m_;
  std::size_t count_ = 0;
  Columns point_, normal_, asked_, fixed_, fixed_normal_;
  Column others_;
  std::vector<std::uint32_t> uncertain_;  // all at first
  std::vector<std::uint32_t> answers_;    // nearest voxels of those asked for last
  bool is_asked_ = false;
};

}  // namespace backsight

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/rigid_transform.h"
#include "stages/station_model.h"

namespace backsight {

/// A piece of wall, trunk or post seen from above; instrument frame.
struct PlanWall {
  Eigen::Vector2d position_m;
  double facing_rad = 0.0;  ///< azimuth of its normal, towards the scanner
};

/// Walls of a view that take part in comparisons.
inline constexpr std::size_t kPlanWalls = 100;

/// Directions that walls face, an eighth of a turn each.
inline constexpr int kPlanFacings = 8;
int FacingSector(double facing_rad);

/// Square image about a station's place, one value per cell and direction that a wall may face.
/// What a wall of another station is worth there: kWall on a wall that faces alike, within an
/// eighth of a turn, kNear beside one, kFree where the scanner saw through, else 0.
class PlanField {
 public:
  static constexpr int kCells = 100;  ///< per axis
  static constexpr std::int16_t kWall = 3;
  static constexpr std::int16_t kNear = 1;
  static constexpr std::int16_t kFree = -3;

  /// Row-major: x runs fastest.
  const std::int16_t* Sector(int sector) const {
    return values_.data() + static_cast<std::size_t>(sector) * kCells * kCells;
  }
  /// 0 outside.
  int At(int sector, int x, int y) const {
    return Contains(x, y) ? Sector(sector)[y * kCells + x] : 0;
  }
  static bool Contains(int x, int y) { return x >= 0 && y >= 0 && x < kCells && y < kCells; }

  /// All directions alike: kFree where `free` is not 0; kCells * kCells values.
  void Fill(const std::vector<char>& free);
  void AddWall(int sector, int x, int y);

 private:
  std::vector<std::int16_t> values_ =
      std::vector<std::int16_t>(std::size_t{kPlanFacings} * kCells * kCells, 0);
};

/// The edge of cells that suits a station: four voxels, doubled until the view holds nine tenths of
/// its upright surfaces. Views are comparable at equal edges: a pair takes the larger of both.
double PlanCellFor(const StationModel& model, const StationFeatures& features);

/// What a levelled station saw, from above: walls, space that is free, the lowest surface.
/// Instrument frame; z must be up.
class PlanView {
 public:
  /// Cells are squares of `cell_m`. `samples`: walls that take part in comparisons. Time O(voxels),
  /// some milliseconds; memory 200 kB.
  PlanView(const StationModel& model, const StationFeatures& features, double cell_m,
           std::size_t samples);

  double cell_m() const { return cell_m_; }
  const std::vector<PlanWall>& walls() const { return walls_; }
  const std::vector<PlanWall>& sample() const { return sample_; }  ///< evenly chosen
  const PlanField& field() const { return field_; }
  /// Whether the scanner saw through the cell; false outside.
  bool IsFree(int x, int y) const {
    return PlanField::Contains(x, y) &&
           free_[static_cast<std::size_t>(y * PlanField::kCells + x)] != 0;
  }
  /// The cell of a coordinate relative to the station.
  int CellOf(double coordinate_m) const {
    return static_cast<int>(std::floor(coordinate_m / cell_m_ + 0.5)) + PlanField::kCells / 2;
  }

  /// How far `source` must rise under `target_from_source` so that its lowest surfaces come to lie
  /// on this view's, median; 0 where they share fewer than five cells. Metres.
  double GroundOffset(const PlanView& source, const RigidTransform& target_from_source) const;

 private:
  void FindWalls(const StationModel& model, const StationFeatures& features);
  void FindGround(const StationModel& model);
  void FindFreeSpace(const RangeImage& image);

  double cell_m_;
  std::vector<PlanWall> walls_;
  std::vector<PlanWall> sample_;
  std::vector<char> free_;
  std::vector<float> ground_m_;  // lowest z per cell; NaN where nothing was measured
  PlanField field_;
};

}  // namespace backsight

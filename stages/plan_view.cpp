#include "stages/plan_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

#include "core/even_choice.h"

namespace backsight {
namespace {

constexpr int kCells = PlanField::kCells;
constexpr int kHalf = kCells / 2;
constexpr float kSteepest = 0.4F;  // |z| of the normal of what counts as upright
constexpr int kFewestVoxels = 3;   // that make a piece of wall

std::size_t Slot(int x, int y) { return static_cast<std::size_t>(y * kCells + x); }

bool IsUpright(const Eigen::Vector3f& normal) {
  return normal.allFinite() && std::abs(normal.z()) <= kSteepest;
}

/// Upright voxels of one cell that face alike.
struct Pile {
  int voxels = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();
};

/// Whether most of what was measured in a cell's direction, at heights between ground and eaves,
/// lies behind the cell.
bool IsSeenThrough(const RangeImage& image, const Eigen::Vector2d& place, double slack_m) {
  constexpr std::array<double, 5> kHeights = {-0.5, 0.3, 1.0, 2.0, 3.5};  // m above the instrument
  int measured = 0;
  int behind = 0;
  for (const double height : kHeights) {
    const Eigen::Vector3d point(place.x(), place.y(), height);
    const RangeImage::Pixel& pixel = image.At(point);
    if (pixel.max_m == 0.0F) continue;
    ++measured;
    behind += static_cast<double>(pixel.min_m) > point.norm() + slack_m ? 1 : 0;
  }
  return behind >= 2 && 2 * behind > measured;
}

}  // namespace

int FacingSector(double facing_rad) {
  const double eighths = facing_rad / (2.0 * std::numbers::pi) * kPlanFacings;
  const int sector = static_cast<int>(std::floor(eighths + 0.5)) % kPlanFacings;
  return sector < 0 ? sector + kPlanFacings : sector;
}

void PlanField::Fill(const std::vector<char>& free) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    values_[i] = free[i % free.size()] != 0 ? kFree : std::int16_t{0};
  }
}

void PlanField::AddWall(int sector, int x, int y) {
  for (const int turn : {kPlanFacings - 1, 0, 1}) {
    std::int16_t* values =
        values_.data() + static_cast<std::size_t>((sector + turn) % kPlanFacings) * kCells * kCells;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!Contains(x + dx, y + dy)) continue;
        std::int16_t& value = values[Slot(x + dx, y + dy)];
        value = std::max(value, dx == 0 && dy == 0 ? kWall : kNear);
      }
    }
  }
}

double PlanCellFor(const StationModel& model, const StationFeatures& features) {
  constexpr double kFinest = 4.0;  // l
  constexpr double kHeld = 0.9;
  std::vector<double> reach_m;
  for (std::size_t i = 0; i < model.leaves.size(); ++i) {
    if (!IsUpright(features.normals[i])) continue;
    reach_m.push_back(model.leaves.Mean(i).head<2>().lpNorm<Eigen::Infinity>());
  }
  double cell_m = kFinest * model.resolution_m();
  if (reach_m.empty()) return cell_m;
  const auto held = reach_m.begin() +
                    static_cast<std::ptrdiff_t>(kHeld * static_cast<double>(reach_m.size() - 1));
  std::nth_element(reach_m.begin(), held, reach_m.end());
  while (0.5 * kCells * cell_m < *held) cell_m *= 2.0;
  return cell_m;
}

PlanView::PlanView(const StationModel& model, const StationFeatures& features, double cell_m,
                   std::size_t samples)
    : cell_m_(cell_m), free_(std::size_t{kCells} * kCells, 0) {
  FindWalls(model, features);
  FindGround(model);
  if (features.scanner_credible) FindFreeSpace(model.range_image);
  const EvenChoice chosen(walls_.size(), samples);
  for (std::size_t k = 0; k < chosen.count(); ++k) sample_.push_back(walls_[chosen[k]]);
  field_.Fill(free_);
  for (const PlanWall& wall : walls_) {
    field_.AddWall(FacingSector(wall.facing_rad), CellOf(wall.position_m.x()),
                   CellOf(wall.position_m.y()));
  }
}

void PlanView::FindWalls(const StationModel& model, const StationFeatures& features) {
  std::map<std::tuple<int, int, int>, Pile> piles;
  for (std::size_t i = 0; i < model.leaves.size(); ++i) {
    const Eigen::Vector3f& normal = features.normals[i];
    if (!IsUpright(normal)) continue;
    const Eigen::Vector2d position = model.leaves.Mean(i).head<2>();
    const Eigen::Vector2d facing = normal.head<2>().cast<double>();
    const int sector = FacingSector(std::atan2(facing.y(), facing.x()));
    Pile& pile = piles[{CellOf(position.y()), CellOf(position.x()), sector}];
    ++pile.voxels;
    pile.position += position;
    pile.normal += facing;
  }
  for (const auto& [place, pile] : piles) {
    if (pile.voxels < kFewestVoxels) continue;
    walls_.push_back({pile.position / pile.voxels, std::atan2(pile.normal.y(), pile.normal.x())});
  }
}

void PlanView::FindGround(const StationModel& model) {
  ground_m_.assign(std::size_t{kCells} * kCells, std::numeric_limits<float>::quiet_NaN());
  for (const Eigen::Vector3d& mean : model.leaves.means()) {
    const int x = CellOf(mean.x());
    const int y = CellOf(mean.y());
    if (!PlanField::Contains(x, y)) continue;
    float& lowest = ground_m_[Slot(x, y)];
    lowest = std::fmin(lowest, static_cast<float>(mean.z()));
  }
}

void PlanView::FindFreeSpace(const RangeImage& image) {
  const double slack_m = 1.5 * cell_m_;
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const Eigen::Vector2d place = cell_m_ * Eigen::Vector2d(x - kHalf, y - kHalf);
      const bool beside_scanner = place.norm() < cell_m_;
      free_[Slot(x, y)] = !beside_scanner && IsSeenThrough(image, place, slack_m) ? 1 : 0;
    }
  }
}

double PlanView::GroundOffset(const PlanView& source,
                              const RigidTransform& target_from_source) const {
  constexpr std::size_t kFewestCells = 5;
  std::vector<double> offsets;
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const float lowest = source.ground_m_[Slot(x, y)];
      if (std::isnan(lowest)) continue;
      const Eigen::Vector3d point =
          target_from_source * Eigen::Vector3d(source.cell_m_ * (x - kHalf),
                                               source.cell_m_ * (y - kHalf),
                                               static_cast<double>(lowest));
      const int u = CellOf(point.x());
      const int v = CellOf(point.y());
      if (!PlanField::Contains(u, v) || std::isnan(ground_m_[Slot(u, v)])) continue;
      offsets.push_back(static_cast<double>(ground_m_[Slot(u, v)]) - point.z());
    }
  }
  if (offsets.size() < kFewestCells) return 0.0;
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

}  // namespace backsight

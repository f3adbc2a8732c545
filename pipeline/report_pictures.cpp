#include "pipeline/report_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/png_image.h"

namespace backsight {
namespace {

using Colour = std::array<std::uint8_t, 3>;

/// Okabe and Ito's palette: told apart by colour-blind readers too.
constexpr std::array<Colour, 7> kStationColours = {{{0, 114, 178},
                                                    {213, 94, 0},
                                                    {0, 158, 115},
                                                    {204, 121, 167},
                                                    {86, 180, 233},
                                                    {230, 159, 0},
                                                    {110, 110, 110}}};

/// A voxel of the main component in the survey frame.
struct PlacedVoxel {
  Eigen::Vector3d position;
  std::size_t station = 0;
};

std::vector<PlacedVoxel> PlaceVoxels(const std::vector<Station>& stations, const Network& network) {
  std::vector<PlacedVoxel> voxels;
  for (std::size_t s = 0; s < stations.size(); ++s) {
    if (!stations[s].usable() || network.component[s] != 0) continue;
    const RigidTransform survey_from_instrument =
        network.survey_from_station[s] * stations[s].model.StationFromInstrument();
    for (const VoxelLeaf& leaf : stations[s].model.leaves) {
      voxels.push_back({survey_from_instrument * leaf.cluster.mean, s});
    }
  }
  return voxels;
}

/// The interval that holds the middle 98 % of the values.
std::pair<double, double> Extent(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values[values.size() / 100], values[values.size() - 1 - values.size() / 100]};
}

/// Draws voxels in the plane of two survey axes.
class Canvas {
 public:
  Canvas(const std::vector<PlacedVoxel>& voxels, Eigen::Index across, Eigen::Index up, int width)
      : across_(across), up_(up) {
    std::vector<double> u, v;
    for (const PlacedVoxel& voxel : voxels) {
      u.push_back(voxel.position[across]);
      v.push_back(voxel.position[up]);
    }
    const auto [low_u, high_u] = Extent(std::move(u));
    const auto [low_v, high_v] = Extent(std::move(v));
    constexpr double kMargin = 1.0;  // m
    constexpr double kMaxAspect = 1.2;
    origin_ = {low_u - kMargin, high_v + kMargin};
    metres_per_pixel_ = std::max((high_u - low_u + 2.0 * kMargin) / width,
                                 (high_v - low_v + 2.0 * kMargin) / (kMaxAspect * width));
    const int height = static_cast<int>((high_v - low_v + 2.0 * kMargin) / metres_per_pixel_) + 1;
    image_ = RgbImage(width, height, {255, 255, 255});
  }

  double metres_per_pixel() const { return metres_per_pixel_; }

  void Draw(const PlacedVoxel& voxel) {
    const int x = static_cast<int>((voxel.position[across_] - origin_.x()) / metres_per_pixel_);
    const int y = static_cast<int>((origin_.y() - voxel.position[up_]) / metres_per_pixel_);
    if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return;
    image_.Set(x, y, kStationColours[voxel.station % kStationColours.size()]);
  }

  std::vector<std::uint8_t> Png() const { return EncodePng(image_); }

 private:
  Eigen::Index across_, up_;
  Eigen::Vector2d origin_;
  double metres_per_pixel_ = 1.0;
  RgbImage image_;
};

ReportPicture DrawPlan(const std::vector<PlacedVoxel>& voxels) {
  Canvas canvas(voxels, 0, 1, 1000);
  for (const PlacedVoxel& voxel : voxels) canvas.Draw(voxel);
  return {"Plan view",
          fmt::format("All voxels from above, coloured by station; one pixel is {:.0f} mm.",
                      1000.0 * canvas.metres_per_pixel()),
          canvas.Png()};
}

/// A slice of one voxel's thickness across the axis `normal` at the middle of the network.
ReportPicture DrawSection(const std::vector<PlacedVoxel>& voxels, Eigen::Index normal,
                          double thickness_m) {
  std::vector<double> along;
  along.reserve(voxels.size());
  for (const PlacedVoxel& voxel : voxels) along.push_back(voxel.position[normal]);
  const auto middle = along.begin() + static_cast<std::ptrdiff_t>(along.size() / 2);
  std::nth_element(along.begin(), middle, along.end());
  const double at = *middle;
  Canvas canvas(voxels, 1 - normal, 2, 1000);
  for (const PlacedVoxel& voxel : voxels) {
    if (std::abs(voxel.position[normal] - at) < 0.5 * thickness_m) canvas.Draw(voxel);
  }
  const char* axis = normal == 0 ? "x" : "y";
  return {
      fmt::format("Vertical section across {}", axis),
      fmt::format("Voxels within {:.0f} mm of {} = {:.2f} m, coloured by station; walls seen by "
                  "several stations must not appear twice.",
                  500.0 * thickness_m, axis, at),
      canvas.Png()};
}

}  // namespace

std::vector<ReportPicture> DrawReportPictures(const std::vector<Station>& stations,
                                              const Network& network) {
  const std::vector<PlacedVoxel> voxels = PlaceVoxels(stations, network);
  if (voxels.empty()) return {};
  double thickness_m = 0.0;
  for (const Station& station : stations) {
    if (station.usable()) thickness_m = std::max(thickness_m, 2.0 * station.model.resolution_m());
  }
  return {DrawPlan(voxels), DrawSection(voxels, 0, thickness_m),
          DrawSection(voxels, 1, thickness_m)};
}

}  // namespace backsight

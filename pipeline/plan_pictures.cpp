#include "pipeline/plan_pictures.h"

#include <fmt/format.h>

#include <limits>

#include "pipeline/picture_canvas.h"

namespace backsight {
namespace {

constexpr Colour kPaper = {255, 255, 255};
constexpr Colour kContext = {225, 228, 232};  // something was measured here

PictureWindow PlanWindow(const CloudExtent& extent) {
  constexpr int kWidth = 900;
  constexpr int kMaxHeight = 1000;
  return PictureWindow::Around(extent.min.head<2>(), extent.max.head<2>(), kWidth, kMaxHeight);
}

/// Calls `body(its count, its mean in the frame of the clouds, half its edge)` for every voxel.
template <typename Body>
void ForEachVoxel(const PlacedClouds& clouds, const ExecutionContext& context, const Body& body) {
  for (const PlacedStation& placed : clouds.stations) {
    context.CheckStop();
    const double reach_m = 0.5 * placed.station->model.resolution_m();
    const VoxelLeaves& leaves = placed.station->model.leaves;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      body(leaves.Count(i), placed.frame_from_instrument * leaves.Mean(i), reach_m);
    }
  }
}

/// Calls `body(pixel, voxel's mean)` for every pixel that a voxel covers.
template <typename Body>
void ForEachCovered(const PlacedClouds& clouds, const PictureWindow& window,
                    const ExecutionContext& context, const Body& body) {
  ForEachVoxel(clouds, context, [&](double, const Eigen::Vector3d& p, double reach_m) {
    window.ForEachPixel(p.head<2>(), reach_m, [&](int x, int y) { body(window.At(x, y), p); });
  });
}

/// One value per pixel; NaN: nothing was measured there.
using Values = std::vector<double>;

RgbImage Paint(const PictureWindow& window, const Values& values, const ColourScale& scale) {
  RgbImage image(window.width_px, window.height_px, kPaper);
  for (int y = 0; y < window.height_px; ++y) {
    for (int x = 0; x < window.width_px; ++x) {
      const double value = values[window.At(x, y)];
      if (!std::isnan(value)) image.Set(x, y, scale.Of(value));
    }
  }
  return image;
}

std::pair<double, double> Middle(const Values& values) {
  Values present;
  std::copy_if(values.begin(), values.end(), std::back_inserter(present),
               [](double value) { return !std::isnan(value); });
  return present.empty() ? std::pair(0.0, 1.0) : MiddleOf(std::move(present));
}

PictureRecord Finish(const PlacedClouds& clouds, PictureRecord picture) {
  picture.across = clouds.across;
  picture.up = clouds.up;
  return picture;
}

}  // namespace

PictureRecord DrawDensity(const PlacedClouds& clouds, const CloudExtent& extent,
                          const std::vector<PictureLine>& traces, const ExecutionContext& context) {
  const PictureWindow window = PlanWindow(extent);
  const double pixel_m2 = window.metres_per_pixel * window.metres_per_pixel;
  Values density(window.size(), 0.0);
  std::vector<std::size_t> pixels;
  ForEachVoxel(clouds, context, [&](double count, const Eigen::Vector3d& p, double reach_m) {
    pixels.clear();
    window.ForEachPixel(p.head<2>(), reach_m,
                        [&](int x, int y) { pixels.push_back(window.At(x, y)); });
    for (const std::size_t pixel : pixels) {
      density[pixel] += count / static_cast<double>(pixels.size()) / pixel_m2;
    }
  });
  for (double& value : density) {
    if (value == 0.0) value = std::numeric_limits<double>::quiet_NaN();
  }
  const auto [low, high] = Middle(density);
  const ColourScale scale(ColourScale::Kind::kFactors, low, std::max(high, 2.0 * low));
  PictureRecord picture =
      MakePicture(PictureRecord::Kind::kPlan, window, Paint(window, density, scale));
  picture.title = "Density of points from above";
  picture.caption = fmt::format(
      "Points of all scans per square metre of plan, {}; equal factors, equal steps of colour. "
      "Walls and what stands above one another add up.{}",
      clouds.origin, traces.empty() ? "" : " Lines: the vertical sections below.");
  picture.scale = scale.Record("points/m\xc2\xb2");
  picture.lines = traces;
  return Finish(clouds, std::move(picture));
}

PictureRecord DrawHeights(const PlacedClouds& clouds, const CloudExtent& extent,
                          const ExecutionContext& context) {
  const PictureWindow window = PlanWindow(extent);
  Values heights(window.size(), std::numeric_limits<double>::quiet_NaN());
  ForEachCovered(clouds, window, context, [&](std::size_t pixel, const Eigen::Vector3d& p) {
    if (!(heights[pixel] >= p.z())) heights[pixel] = p.z();
  });
  const auto [low, high] = Middle(heights);
  const ColourScale scale(ColourScale::Kind::kValues, low, high);
  PictureRecord picture =
      MakePicture(PictureRecord::Kind::kPlan, window, Paint(window, heights, scale));
  picture.title = "Heights from above";
  picture.caption = fmt::format("The highest surface of every pixel, {}.", clouds.origin);
  picture.scale = scale.Record(clouds.height + " [m]");
  return Finish(clouds, std::move(picture));
}

PictureRecord DrawDistances(const PlacedClouds& clouds, const CloudExtent& extent,
                            const std::vector<DistanceSample>& samples,
                            const DistanceLimits& limits, const ExecutionContext& context) {
  const PictureWindow window = PlanWindow(extent);
  std::vector<bool> measured(window.size());
  ForEachCovered(clouds, window, context,
                 [&](std::size_t pixel, const Eigen::Vector3d&) { measured[pixel] = true; });
  Values sums(window.size(), 0.0);
  std::vector<int> counts(window.size());
  for (const DistanceSample& sample : samples) {
    window.ForEachPixel(sample.position.head<2>(), 0.5 * clouds.resolution_m(), [&](int x, int y) {
      sums[window.At(x, y)] += sample.distance_m;
      ++counts[window.At(x, y)];
    });
  }
  const ColourScale scale(ColourScale::Kind::kValues, 0.0, 1000.0 * limits.scale_m);
  RgbImage image(window.width_px, window.height_px, kPaper);
  for (int y = 0; y < window.height_px; ++y) {
    for (int x = 0; x < window.width_px; ++x) {
      const std::size_t pixel = window.At(x, y);
      if (counts[pixel] > 0) {
        image.Set(x, y, scale.Of(1000.0 * sums[pixel] / counts[pixel]));
      } else if (measured[pixel]) {
        image.Set(x, y, kContext);
      }
    }
  }
  PictureRecord picture = MakePicture(PictureRecord::Kind::kDistances, window, image);
  picture.title = "Distances between surfaces that several stations measured";
  picture.caption = fmt::format(
      "From above, {}: mean distance without sign of the samples in a pixel. Grey: not compared, "
      "because only one station measured it, it lies on no plane, no surface of another station "
      "lies within {:.0f} mm, or it is not among the samples.",
      clouds.origin, 1000.0 * limits.search_m);
  picture.scale = scale.Record("distance [mm]");
  picture.scale->open_below = false;
  return Finish(clouds, std::move(picture));
}

}  // namespace backsight

#include "pipeline/section_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "stages/surface_patch.h"

namespace backsight {
namespace {

/// The plane of a voxel's points: its own where they are many, otherwise with its neighbours'.
std::optional<SurfacePatch> PlaneOf(const Station& station, std::size_t leaf) {
  constexpr double kEnough = 20.0;  // points
  const StationModel& model = station.model;
  const PointCluster cluster = model.leaves.Cluster(leaf);
  if (cluster.count >= kEnough) return PatchOf(cluster, model.resolution_m());
  const auto patch = FindPatch(model, *station.index, leaf);
  return patch ? patch : PatchOf(cluster, model.resolution_m());
}

/// `paper_from_instrument`: rows across, up, normal; z is the distance from the section's middle.
std::optional<VoxelCut> CutVoxel(const Station& station, std::size_t leaf,
                                 const RigidTransform& paper_from_instrument,
                                 double half_thickness_m) {
  const double edge_m = station.model.resolution_m();
  const Eigen::Vector3d mean = station.model.leaves.Mean(leaf);
  const double height = (paper_from_instrument * mean).z();
  if (std::abs(height) > half_thickness_m + edge_m) return std::nullopt;
  VoxelCut cut;
  const std::optional<SurfacePatch> patch = PlaneOf(station, leaf);
  if (!patch) {
    cut.middle = (paper_from_instrument * mean).head<2>();
    return std::abs(height) <= half_thickness_m ? std::optional(cut) : std::nullopt;
  }
  const Eigen::Vector3d normal = paper_from_instrument.rotation * patch->normal;
  Eigen::Vector3d place =
      paper_from_instrument * (mean - patch->normal.dot(mean - patch->mean) * patch->normal);
  // Along the plane, out of the section: its slope is the sine between plane and section.
  const Eigen::Vector3d out = Eigen::Vector3d::UnitZ() - normal.z() * normal;
  const double sine = out.norm();
  const double outside = place.z() - std::clamp(place.z(), -half_thickness_m, half_thickness_m);
  constexpr double kReach = 0.6;      // edges, of a voxel along its surface
  constexpr double kParallel = 0.15;  // sine
  if (std::abs(outside) > kReach * edge_m * sine) return std::nullopt;
  if (outside != 0.0) place -= (outside / (sine * sine)) * out;
  cut.middle = place.head<2>();
  cut.layer = true;
  cut.half_length_m = kReach * edge_m;
  if (sine < kParallel) {
    cut.half_width_m = 0.5 * edge_m;
  } else {
    cut.along = Eigen::Vector2d(-normal.y(), normal.x()).normalized();
    cut.half_width_m = patch->sigma_m / sine;
  }
  return cut;
}

/// Which stations drew which pixels.
class SectionCanvas {
 public:
  explicit SectionCanvas(const PictureWindow& window) : window_(window) {}

  void Draw(const VoxelCut& cut, std::size_t station) {
    constexpr double kThinnestPx = 0.8;
    const double half_width = std::max(cut.half_width_m, kThinnestPx * window_.metres_per_pixel);
    const double reach = cut.layer ? cut.half_length_m + half_width : 0.0;
    window_.ForEachPixel(cut.middle, reach, [&](int x, int y) {
      const Eigen::Vector2d offset =
          window_.left_top + window_.metres_per_pixel * Eigen::Vector2d(x + 0.5, -(y + 0.5)) -
          cut.middle;
      const double along = std::abs(cut.along.dot(offset));
      const double across = std::abs(cut.along.x() * offset.y() - cut.along.y() * offset.x());
      const bool covered = along <= std::max(cut.half_length_m, half_width) && across <= half_width;
      if (covered || !cut.layer) drawn_.push_back(window_.At(x, y) << kStationBits | station);
    });
    if (drawn_.size() > full_) Compact();
  }

  /// How many pixels each station drew.
  std::map<std::size_t, std::size_t> CountPixels() {
    Compact();
    std::map<std::size_t, std::size_t> pixels;
    for (const std::size_t entry : drawn_) ++pixels[StationOf(entry)];
    return pixels;
  }

  RgbImage Paint(const std::map<std::size_t, Colour>& colours) const {
    RgbImage image(window_.width_px, window_.height_px, {255, 255, 255});
    for (std::size_t begin = 0; begin < drawn_.size();) {
      std::size_t end = begin + 1;
      const std::size_t pixel = drawn_[begin] >> kStationBits;
      while (end < drawn_.size() && drawn_[end] >> kStationBits == pixel) ++end;
      const auto width = static_cast<std::size_t>(window_.width_px);
      const std::size_t x = pixel % width, y = pixel / width;
      const std::size_t chosen = begin + (x + y) / kStripePx % (end - begin);
      image.Set(static_cast<int>(x), static_cast<int>(y), colours.at(StationOf(drawn_[chosen])));
      begin = end;
    }
    return image;
  }

 private:
  static constexpr unsigned kStationBits = 24;
  static constexpr std::size_t kStripePx = 8;
  static constexpr std::size_t kMostPending = std::size_t{1} << 22U;

  static std::size_t StationOf(std::size_t entry) {
    return entry & ((std::size_t{1} << kStationBits) - 1);
  }
  void Compact() {
    std::sort(drawn_.begin(), drawn_.end());
    drawn_.erase(std::unique(drawn_.begin(), drawn_.end()), drawn_.end());
    full_ = std::max(kMostPending, 2 * drawn_.size());
  }

  PictureWindow window_;
  std::vector<std::size_t> drawn_;  // pixel and station
  std::size_t full_ = kMostPending;
};

/// One colour for each station; kOtherColour where all are taken by those with more pixels.
std::map<std::size_t, Colour> ColoursOf(const std::map<std::size_t, std::size_t>& pixels) {
  std::map<std::size_t, Colour> colours;
  if (pixels.empty() || pixels.rbegin()->first < kStationColours) {  // the same in all pictures
    for (const auto& [station, count] : pixels) colours[station] = StationColour(station);
    return colours;
  }
  std::vector<std::pair<std::size_t, std::size_t>> ranked(pixels.begin(), pixels.end());
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    colours[ranked[i].first] = i < kStationColours ? StationColour(i) : kOtherColour;
  }
  return colours;
}

}  // namespace

void ForEachCut(const PlacedClouds& clouds, const Section& section, const ExecutionContext& context,
                const std::function<void(const VoxelCut&, std::size_t)>& body) {
  RigidTransform paper_from_frame;
  paper_from_frame.rotation.row(0) = section.across;
  paper_from_frame.rotation.row(1) = section.up;
  paper_from_frame.rotation.row(2) = section.normal();
  paper_from_frame.translation = -(paper_from_frame.rotation * section.origin);
  for (const PlacedStation& placed : clouds.stations) {
    context.CheckStop();
    const StationModel& model = placed.station->model;
    const RigidTransform paper_from_instrument = paper_from_frame * placed.frame_from_instrument;
    for (std::size_t i = 0; i < model.leaves.size(); ++i) {
      const auto cut =
          CutVoxel(*placed.station, i, paper_from_instrument, 0.5 * section.thickness_m);
      if (cut) body(*cut, placed.index);
    }
  }
}

PictureRecord DrawSection(const PlacedClouds& clouds, const Section& section,
                          const PictureWindow& window, PictureRecord::Kind kind,
                          const ExecutionContext& context) {
  SectionCanvas canvas(window);
  ForEachCut(clouds, section, context,
             [&](const VoxelCut& cut, std::size_t station) { canvas.Draw(cut, station); });
  const std::map<std::size_t, Colour> colours = ColoursOf(canvas.CountPixels());
  PictureRecord picture = MakePicture(kind, window, canvas.Paint(colours));
  std::size_t others = 0;
  for (const PlacedStation& placed : clouds.stations) {
    const auto colour = colours.find(placed.index);
    if (colour == colours.end()) continue;
    if (colour->second == kOtherColour) {
      ++others;
    } else {
      picture.keys.push_back({placed.station->spec.id, colour->second});
    }
  }
  if (others > 0) picture.keys.push_back({fmt::format("{} others", others), kOtherColour});
  return picture;
}

}  // namespace backsight

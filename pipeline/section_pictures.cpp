#include "pipeline/section_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "stages/dominant_frame.h"

namespace backsight {
namespace {

constexpr double kThicknessM = 0.05;
constexpr double kNearM = 0.15;  // of a section: its surface is cut
constexpr double kSteep = 0.5;   // |cosine| between a surface's normal and the section's, at most

/// How much surface a section across `axis` cuts, by its place along the axis.
std::map<int, int> CutsAlong(const Eigen::Vector3d& axis,
                             const std::vector<DistanceSample>& samples) {
  std::map<int, int> cuts;
  for (const DistanceSample& sample : samples) {
    if (std::abs(axis.dot(sample.normal)) > kSteep) continue;
    ++cuts[static_cast<int>(std::floor(axis.dot(sample.position) / kThicknessM))];
  }
  return cuts;
}

/// Places along an axis.
struct Range {
  double low, high;
  double At(double share) const { return low + share * (high - low); }
};

/// Middle of the slab in the inner part of the range that cuts most and lies `apart_m` from `other`
/// or further; `otherwise` where nothing is cut.
double BestPlace(const std::map<int, int>& cuts, const Range& range, double otherwise, double other,
                 double apart_m) {
  constexpr double kEdge = 0.08;
  int most = 0;
  double best = otherwise;
  for (const auto& [slab, count] : cuts) {
    const double place = (slab + 0.5) * kThicknessM;
    if (place < range.At(kEdge) || place > range.At(1.0 - kEdge)) continue;
    if (std::abs(place - other) < apart_m || count <= most) continue;
    most = count;
    best = place;
  }
  return best;
}

NamedSection Level(double height) {
  NamedSection level{{}, "", false, height};
  level.section.origin = {0.0, 0.0, height};
  level.section.thickness_m = kThicknessM;
  return level;
}

/// The box's corner that lies furthest along the direction.
double Furthest(const CloudExtent& extent, const Eigen::Vector3d& direction) {
  return direction.cwiseMax(0.0).dot(extent.max) + direction.cwiseMin(0.0).dot(extent.min);
}

/// Across `normal`, seen against it; its left end is where the plan's extent begins.
NamedSection Upright(const std::string& name, const Eigen::Vector3d& normal, double place,
                     const CloudExtent& extent) {
  NamedSection upright{{}, name, true, 0.0};
  Section& section = upright.section;
  section.up = Eigen::Vector3d::UnitZ();
  section.across = section.up.cross(normal);
  section.origin = place * normal - Furthest(extent, -section.across) * section.across;
  section.thickness_m = kThicknessM;
  return upright;
}

struct Span {
  Eigen::Vector2d min, max;
};

/// What the section holds, without the last percents on all sides.
std::optional<Span> SpanOf(const PlacedClouds& clouds, const Section& section) {
  std::vector<double> u, v;
  ForEachCut(clouds, section, [&](const VoxelCut& cut, std::size_t) {
    u.push_back(cut.middle.x());
    v.push_back(cut.middle.y());
  });
  if (u.empty()) return std::nullopt;
  const auto [left, right] = MiddleOf(std::move(u));
  const auto [low, high] = MiddleOf(std::move(v));
  return Span{{left, low}, {right, high}};
}

/// The horizontal direction that most walls face, up to quarter turns.
Eigen::Vector3d WallDirection(const std::vector<DistanceSample>& samples) {
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(samples.size());
  for (const DistanceSample& sample : samples) normals.push_back(sample.normal.cast<float>());
  const Eigen::Matrix3d walls =
      FindDominantFrame(normals, Eigen::Vector3d::UnitZ().eval()).frame_from_cloud;
  Eigen::Index level = 0;
  walls.col(2).cwiseAbs().minCoeff(&level);
  return Eigen::Vector3d(walls(level, 0), walls(level, 1), 0.0).normalized();
}

constexpr double kDetailM = 2.0;  // wide
constexpr double kDetailHighM = 1.3;

/// Where the part of the section is that cuts most surface of several stations: the middle of what
/// lies in the best window of the detail's size.
std::optional<Eigen::Vector2d> DetailMiddle(const Section& section,
                                            const std::vector<DistanceSample>& samples) {
  constexpr double kCell = 0.25;
  constexpr int kWide = static_cast<int>(kDetailM / kCell);
  constexpr int kHigh = static_cast<int>(kDetailHighM / kCell);
  const Eigen::Vector3d normal = section.normal();
  std::vector<Eigen::Vector2d> cut;
  std::map<std::pair<int, int>, int> windows;
  for (const DistanceSample& sample : samples) {
    if (std::abs(normal.dot(sample.normal)) > kSteep) continue;
    if (std::abs(normal.dot(sample.position - section.origin)) > kNearM) continue;
    cut.push_back(section.OnPaper(sample.position));
    const Eigen::Vector2i cell = (cut.back() / kCell).array().floor().cast<int>();
    for (int i = 0; i < kWide; ++i) {
      for (int j = 0; j < kHigh; ++j) ++windows[{cell.x() - i, cell.y() - j}];
    }
  }
  const auto best =
      std::max_element(windows.begin(), windows.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (best == windows.end()) return std::nullopt;
  const Eigen::Vector2d low = kCell * Eigen::Vector2d(best->first.first, best->first.second);
  const Eigen::Vector2d high = low + Eigen::Vector2d(kWide * kCell, kHigh * kCell);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const Eigen::Vector2d& p : cut) {
    if ((p.array() < low.array()).any() || (p.array() >= high.array()).any()) continue;
    sum += p;
    ++count;
  }
  return sum / count;
}

std::string Title(const NamedSection& named, const PlacedClouds& clouds) {
  return named.upright
             ? fmt::format("Vertical section {0}\xe2\x80\x93{0}\xe2\x80\xb2", named.name)
             : fmt::format("Horizontal section at {} = {:.2f} m", clouds.height, named.at_m);
}

void NameAxes(const NamedSection& named, const PlacedClouds& clouds, PictureRecord* picture) {
  picture->across = named.upright ? fmt::format("along {0}\xe2\x80\x93{0}\xe2\x80\xb2", named.name)
                                  : clouds.across;
  picture->up = named.upright ? clouds.height : clouds.up;
}

PictureRecord DrawWhole(const PlacedClouds& clouds, const NamedSection& named, const Span& span) {
  constexpr int kWidth = 1000;
  constexpr int kMaxHeight = 900;
  PictureRecord picture = DrawSection(clouds, named.section,
                                      PictureWindow::Around(span.min, span.max, kWidth, kMaxHeight),
                                      PictureRecord::Kind::kSection);
  picture.title = Title(named, clouds);
  picture.caption = fmt::format(
      "{:.0f} mm thick, {}; one pixel is {:.0f} mm. Each voxel is cut where it stands: a line is "
      "as "
      "long as its points reach and as thick as two standard deviations of them, but at least a "
      "pixel. Where stations coincide, their colours alternate.",
      1000.0 * kThicknessM, clouds.origin, 1000.0 * picture.metres_per_pixel);
  return picture;
}

PictureRecord DrawDetail(const PlacedClouds& clouds, const NamedSection& named,
                         const Eigen::Vector2d& middle) {
  constexpr int kWidth = 1000;
  PictureWindow window;
  window.metres_per_pixel = kDetailM / kWidth;
  window.left_top = middle + 0.5 * Eigen::Vector2d(-kDetailM, kDetailHighM);
  window.width_px = kWidth;
  window.height_px = static_cast<int>(std::lround(kWidth * kDetailHighM / kDetailM));
  PictureRecord picture = DrawSection(clouds, named.section, window, PictureRecord::Kind::kDetail);
  picture.title = "Detail: " + Title(named, clouds);
  picture.caption = fmt::format(
      "{:g} m wide, where most surface was measured by several stations; one pixel is {:.0f} mm. "
      "A wall that appears twice in different colours is a misalignment.",
      kDetailM, 1000.0 * window.metres_per_pixel);
  return picture;
}

}  // namespace

std::vector<NamedSection> ChooseSections(const CloudExtent& extent,
                                         const std::vector<DistanceSample>& samples) {
  constexpr double kApart = 0.2;  // of the height, and at least 1 m
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const Range heights{extent.min.z(), extent.max.z()};
  const std::map<int, int> cuts = CutsAlong(up, samples);
  const double first = BestPlace(cuts, heights, heights.At(0.4), 0.0, 0.0);
  const double apart = std::max(1.0, kApart * (heights.high - heights.low));
  const double second = BestPlace(cuts, heights, first + apart, first, apart);
  std::vector<NamedSection> sections = {Level(std::min(first, second)),
                                        Level(std::max(first, second))};
  const Eigen::Vector3d wall = WallDirection(samples);
  for (Eigen::Vector3d normal : {wall, Eigen::Vector3d(up.cross(wall))}) {
    // Seen towards north or, along it, towards west: left ends lie in the west or the south.
    if (normal.y() > 0.7 || (std::abs(normal.y()) <= 0.7 && normal.x() < 0.0)) normal = -normal;
    const Range range{-Furthest(extent, -normal), Furthest(extent, normal)};
    const double place = BestPlace(CutsAlong(normal, samples), range, range.At(0.5), 0.0, 0.0);
    sections.push_back(Upright(sections.size() == 2 ? "A" : "B", normal, place, extent));
  }
  return sections;
}

std::vector<PictureLine> TracesOf(const std::vector<NamedSection>& sections,
                                  const CloudExtent& extent) {
  std::vector<PictureLine> lines;
  for (const NamedSection& named : sections) {
    if (!named.upright) continue;
    const Section& s = named.section;
    // The part of the line within the extent.
    double from = 0.0, to = Furthest(extent, s.across) - s.across.dot(s.origin);
    for (int axis = 0; axis < 2; ++axis) {
      if (std::abs(s.across[axis]) < 1e-9) continue;
      const double at_min = (extent.min[axis] - s.origin[axis]) / s.across[axis];
      const double at_max = (extent.max[axis] - s.origin[axis]) / s.across[axis];
      from = std::max(from, std::min(at_min, at_max));
      to = std::min(to, std::max(at_min, at_max));
    }
    if (from >= to) continue;
    lines.push_back(
        {named.name, (s.origin + from * s.across).head<2>(), (s.origin + to * s.across).head<2>()});
  }
  return lines;
}

std::vector<PictureRecord> DrawSections(const PlacedClouds& clouds,
                                        const std::vector<NamedSection>& sections,
                                        const std::vector<DistanceSample>& samples) {
  std::vector<PictureRecord> pictures;
  for (const NamedSection& named : sections) {
    const std::optional<Span> span = SpanOf(clouds, named.section);
    if (!span) continue;
    pictures.push_back(DrawWhole(clouds, named, *span));
    NameAxes(named, clouds, &pictures.back());
    const auto middle = DetailMiddle(named.section, samples);
    if (!middle) continue;
    pictures.push_back(DrawDetail(clouds, named, *middle));
    NameAxes(named, clouds, &pictures.back());
  }
  return pictures;
}

}  // namespace backsight

#include "pipeline/section_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "stages/dominant_frame.h"

namespace backsight {
namespace {

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
  NamedSection level;
  level.at_m = height;
  level.section.origin = {0.0, 0.0, height};
  level.section.thickness_m = kThicknessM;
  return level;
}

/// The box's corner that lies furthest along the direction.
double Furthest(const CloudExtent& extent, const Eigen::Vector3d& direction) {
  return direction.cwiseMax(0.0).dot(extent.max) + direction.cwiseMin(0.0).dot(extent.min);
}

/// The section's axis `across` from where it enters the plan's extent to where it leaves it.
Range Crossing(const CloudExtent& extent, const Section& section) {
  Range range{-1e9, 1e9};
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(section.across[axis]) < 1e-9) continue;
    const double at_min = (extent.min[axis] - section.origin[axis]) / section.across[axis];
    const double at_max = (extent.max[axis] - section.origin[axis]) / section.across[axis];
    range.low = std::max(range.low, std::min(at_min, at_max));
    range.high = std::min(range.high, std::max(at_min, at_max));
  }
  return range;
}

/// Across `normal`, seen against it; zero is where its line enters the plan's extent.
NamedSection Upright(const std::string& name, const Eigen::Vector3d& normal, double place,
                     const CloudExtent& extent) {
  NamedSection upright;
  upright.name = name;
  upright.upright = true;
  Section& section = upright.section;
  section.up = Eigen::Vector3d::UnitZ();
  section.across = section.up.cross(normal);
  section.origin = place * normal;
  section.thickness_m = kThicknessM;
  const Range inside = Crossing(extent, section);
  section.origin += inside.low * section.across;
  upright.length_m = std::max(0.0, inside.high - inside.low);
  return upright;
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

/// Seen towards north or, along it, towards west: left ends lie in the west or the south.
Eigen::Vector3d SeenFrom(const Eigen::Vector3d& normal) {
  const bool turned = normal.y() > 0.7 || (std::abs(normal.y()) <= 0.7 && normal.x() < 0.0);
  return turned ? Eigen::Vector3d(-normal) : normal;
}

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

/// Neighbouring samples, and how far apart their surfaces lie.
struct Spot {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double median_m = 0.0;
  bool level = false;  ///< most of its surface is
};

Spot SpotOf(const std::vector<const DistanceSample*>& samples) {
  Spot spot;
  std::size_t level = 0;
  std::vector<double> distances;
  for (const DistanceSample* sample : samples) {
    spot.middle += sample->position / static_cast<double>(samples.size());
    distances.push_back(sample->distance_m);
    level += std::abs(sample->normal.z()) > kSteep ? 1 : 0;
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  spot.median_m = *middle;
  spot.level = 2 * level > samples.size();
  return spot;
}

/// The cell of 0.5 m with enough samples whose surfaces lie furthest apart.
std::optional<Spot> WorstSpot(const std::vector<DistanceSample>& samples) {
  constexpr double kCell = 0.5;
  constexpr std::size_t kEnough = 10;
  std::map<std::array<int, 3>, std::vector<const DistanceSample*>> cells;
  for (const DistanceSample& sample : samples) {
    const Eigen::Vector3i cell = (sample.position / kCell).array().floor().cast<int>();
    cells[{cell.x(), cell.y(), cell.z()}].push_back(&sample);
  }
  std::optional<Spot> worst;
  for (const auto& [cell, members] : cells) {
    if (members.size() < kEnough) continue;
    const Spot spot = SpotOf(members);
    if (!worst || spot.median_m > worst->median_m) worst = spot;
  }
  return worst;
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
  for (const Eigen::Vector3d& across : {wall, Eigen::Vector3d(up.cross(wall))}) {
    const Eigen::Vector3d normal = SeenFrom(across);
    const Range range{-Furthest(extent, -normal), Furthest(extent, normal)};
    const double place = BestPlace(CutsAlong(normal, samples), range, range.At(0.5), 0.0, 0.0);
    sections.push_back(Upright(sections.size() == 2 ? "A" : "B", normal, place, extent));
  }
  for (NamedSection& named : sections) named.detail = DetailMiddle(named.section, samples);
  return sections;
}

std::optional<NamedSection> ChooseWorst(const CloudExtent& extent,
                                        const std::vector<DistanceSample>& samples) {
  const std::optional<Spot> spot = WorstSpot(samples);
  if (!spot) return std::nullopt;
  NamedSection worst = Level(spot->middle.z());
  if (spot->level) {  // level surfaces show in an upright section
    const Eigen::Vector3d normal = SeenFrom(WallDirection(samples));
    worst = Upright("C", normal, normal.dot(spot->middle), extent);
  }
  worst.detail = worst.section.OnPaper(spot->middle);
  worst.apart_m = spot->median_m;
  return worst;
}

std::vector<PictureLine> TracesOf(const std::vector<NamedSection>& sections) {
  std::vector<PictureLine> lines;
  for (const NamedSection& named : sections) {
    if (!named.upright || named.length_m <= 0.0) continue;
    const Section& s = named.section;
    const bool whole = !named.apart_m;
    const double from = whole ? 0.0 : named.detail->x() - 0.5 * kDetailM;
    const double to = whole ? named.length_m : named.detail->x() + 0.5 * kDetailM;
    lines.push_back(
        {named.name, (s.origin + from * s.across).head<2>(), (s.origin + to * s.across).head<2>()});
  }
  return lines;
}

}  // namespace backsight

#include "stages/moving_objects.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <tuple>

namespace backsight {
namespace {

/// How many of the other stations say what of one voxel.
struct Testimony {
  int past = 0;   ///< saw clearly beyond it
  int there = 0;  ///< saw something at its range, there or close by
  int met = 0;    ///< saw something at its range in its very pixel
  /// Distance of neighbouring beams at the voxel, of the closest station that saw beyond; metres.
  double beam_m = HUGE_VAL;
};

enum class Label : char { kUnknown, kMoving, kStill };

/// Within this distance voxels belong together; where beams are far apart, voxels are, too.
double ReachAt(const StationModel& model, std::size_t leaf, double voxels) {
  const double spacing = model.leaves.Mean(leaf).norm() * model.range_image.PixelAngle();
  return voxels * std::max(model.resolution_m(), spacing);
}

/// Beyond what it measured a scanner has nothing to say.
double FarthestRange(const StationModel& model) {
  double farthest = 0.0;
  for (const Eigen::Vector3d& mean : model.leaves.means()) {
    farthest = std::max(farthest, mean.squaredNorm());
  }
  return std::sqrt(farthest);
}

// Beams may pass beside what is not wider than so many of their distances: a pole, a wire.
constexpr double kBeamsAcross = 1.5;

/// Whether beams `beam_m` apart could all pass on this side of a surface about `neighborhood_m`
/// wide, because the witness sees it edge on: the ground from afar, or a car's roof.
bool IsEdgeOn(const Eigen::Vector3d& point, const Eigen::Vector3f& normal, double neighborhood_m,
              double beam_m) {
  if (!normal.allFinite()) return false;
  const double sine = std::abs(normal.cast<double>().dot(point)) / point.norm();
  return neighborhood_m * sine < kBeamsAcross * beam_m;
}

/// Whether the next beam on the other side of the surface came back. From the ground it does not
/// where that is seen at too low an angle, and what the beams above it meet says nothing of it.
bool IsSeenBehind(const StationModel& viewer, const Eigen::Vector3d& point,
                  const Eigen::Vector3f& normal, double beam_m) {
  const Eigen::Vector3d n = normal.cast<double>();
  const Eigen::Vector3d behind = point + (n.dot(point) > 0.0 ? beam_m : -beam_m) * n;
  return viewer.range_image.Around(behind).middle.max_m > 0.0F;
}

void Hear(const PlacedSurface& own, const PlacedSurface& witness, double reach_m,
          const MovingObjectOptions& options, std::vector<Testimony>* said) {
  // Things that move are small: they are not slanted over a whole window of pixels.
  const SightTolerance tolerance{.voxels = options.clearance, .pixels = 0.5};
  const RigidTransform witness_from_own =
      witness.frame_from_instrument.Inverse() * own.frame_from_instrument;
  const Eigen::Matrix3f rotation = witness_from_own.rotation.cast<float>();
  const StationModel& viewer = witness.surface.model;
  const double clearance_m = options.clearance * viewer.resolution_m();
  for (std::size_t i = 0; i < said->size(); ++i) {
    const Eigen::Vector3d point = witness_from_own * own.surface.model.leaves.Mean(i);
    const double range = point.norm();
    if (range > reach_m) continue;
    const RangeImage::Window window = viewer.range_image.Around(point);
    const Eigen::Vector3f normal = rotation * own.surface.normals[i];
    const Sight sight = LookAt(viewer, window, point, normal, tolerance);
    Testimony& testimony = (*said)[i];
    if (sight == Sight::kSeenThrough) {
      const double beam_m = range * viewer.range_image.PixelAngle();
      const double neighborhood_m = 2.0 * ReachAt(own.surface.model, i, options.reach);
      if (!IsEdgeOn(point, normal, neighborhood_m, beam_m) ||
          IsSeenBehind(viewer, point, normal, beam_m)) {
        ++testimony.past;
        testimony.beam_m = std::min(testimony.beam_m, beam_m);
      }
    }
    testimony.there += sight == Sight::kAgrees ? 1 : 0;
    const RangeImage::Pixel& pixel = window.middle;
    const bool met = pixel.max_m > 0.0F && range > pixel.min_m - clearance_m &&
                     range < pixel.max_m + clearance_m;
    testimony.met += met ? 1 : 0;
  }
}

std::vector<Testimony> HearAll(const std::vector<PlacedSurface>& surfaces, std::size_t own,
                               const std::vector<double>& reach_m,
                               const MovingObjectOptions& options,
                               const ExecutionContext& context) {
  std::vector<Testimony> said(surfaces[own].surface.model.leaves.size());
  for (std::size_t w = 0; w < surfaces.size(); ++w) {
    if (w == own || !surfaces[w].surface.scanner_credible) continue;
    context.CheckStop();
    Hear(surfaces[own], surfaces[w], reach_m[w], options, &said);
  }
  return said;
}

/// Width of the second largest extent of what the voxels hold, as if it were spread evenly.
double WidthOf(const StationModel& model, const std::vector<std::uint32_t>& voxels) {
  PointCluster all;
  for (const std::uint32_t voxel : voxels) all += model.leaves.Cluster(voxel);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(all.Covariance(),
                                                            Eigen::EigenvaluesOnly);
  return std::sqrt(12.0 * std::max(axes.eigenvalues()[1], 0.0));
}

/// What can be said of voxels from the testimony on them and on those around them.
std::vector<Label> LabelByTestimony(const PlacedSurface& own, const std::vector<Testimony>& said,
                                    const MovingObjectOptions& options) {
  const StationModel& model = own.surface.model;
  const auto is_suspect = [&](std::size_t i) { return said[i].past > said[i].there; };
  std::vector<Label> labels(said.size(), Label::kUnknown);
  std::vector<std::uint32_t> around;
  for (std::size_t i = 0; i < said.size(); ++i) {
    if (said[i].met > said[i].past) labels[i] = Label::kStill;
    if (!is_suspect(i)) continue;
    around.clear();
    own.index.voxels.VisitWithin(model.leaves.means(), model.leaves.Mean(i),
                                 ReachAt(model, i, options.reach),
                                 [&](std::uint32_t near, double) { around.push_back(near); });
    const auto suspects = std::count_if(around.begin(), around.end(), is_suspect);
    const bool most =
        static_cast<double>(suspects) >= options.majority * static_cast<double>(around.size());
    if (most && WidthOf(model, around) > kBeamsAcross * said[i].beam_m) labels[i] = Label::kMoving;
  }
  return labels;
}

/// Gives voxels of which nothing is known the label from which they are reached at the least cost
/// (seeded region growing, Adams and Bischof 1994, doi 10.1109/34.295913): distance, which counts
/// more where the surface turns, and little where a moving object meets what others saw past. So an
/// object takes its parts, and the ground keeps its own.
class RegionGrowing {
 public:
  RegionGrowing(const PlacedSurface& own, const std::vector<Testimony>& said,
                std::vector<Label>* labels)
      : own_(own), said_(said), labels_(*labels), cost_(labels->size(), HUGE_VAL) {}

  /// Only what hangs together with moving voxels is looked at.
  void Run() {
    for (const std::uint32_t seed : SeedsInReach()) Spread(seed, 0.0);
    while (!queue_.empty()) {
      const auto [cost, leaf, label] = queue_.top();
      queue_.pop();
      if (labels_[leaf] != Label::kUnknown) continue;
      labels_[leaf] = label;
      Spread(leaf, cost);
    }
  }

 private:
  using Entry = std::tuple<double, std::uint32_t, Label>;  // cost, leaf, label

  /// Calls `visit(near, squared_m2)` for the leaves about one.
  template <class Visit>
  void VisitAround(std::uint32_t leaf, Visit visit) const {
    constexpr double kStep = 2.0;  // voxels
    const StationModel& model = own_.surface.model;
    own_.index.voxels.VisitWithin(model.leaves.means(), model.leaves.Mean(leaf),
                                  ReachAt(model, leaf, kStep), visit);
  }

  /// Moving voxels, and still ones that touch the unknown region about them.
  std::vector<std::uint32_t> SeedsInReach() const {
    std::vector<char> visited(labels_.size(), 0);
    std::vector<std::uint32_t> front;
    std::vector<std::uint32_t> seeds;
    const auto visit = [&](std::uint32_t leaf) {
      if (visited[leaf] != 0) return;
      visited[leaf] = 1;
      if (labels_[leaf] != Label::kStill) front.push_back(leaf);
      if (labels_[leaf] != Label::kUnknown) seeds.push_back(leaf);
    };
    for (std::uint32_t leaf = 0; leaf < labels_.size(); ++leaf) {
      if (labels_[leaf] == Label::kMoving) visit(leaf);
    }
    while (!front.empty()) {
      const std::uint32_t leaf = front.back();
      front.pop_back();
      VisitAround(leaf, [&](std::uint32_t near, double) { visit(near); });
    }
    return seeds;
  }

  void Spread(std::uint32_t from, double cost) {
    VisitAround(from, [&](std::uint32_t near, double squared_m2) {
      if (labels_[near] != Label::kUnknown) return;
      const double reached = cost + StepCost(from, near, std::sqrt(squared_m2));
      if (reached >= cost_[near] || reached > LimitOf(labels_[from])) return;
      cost_[near] = reached;
      queue_.emplace(reached, near, labels_[from]);
    });
  }

  /// What nobody else looked at is not taken far from what was seen through.
  static double LimitOf(Label label) {
    constexpr double kFarthest = 1.0;  // m on a smooth surface, 0.05 m around a right angle
    return label == Label::kMoving ? kFarthest : HUGE_VAL;
  }

  double StepCost(std::uint32_t from, std::uint32_t to, double distance_m) const {
    constexpr double kTurnWeight = 20.0;  // of 1 - cos of the angle between the normals
    constexpr double kUndefinedTurn = 0.5;
    constexpr double kSuspicion = 0.05;
    const Eigen::Vector3f& a = own_.surface.normals[from];
    const Eigen::Vector3f& b = own_.surface.normals[to];
    const bool defined = a.allFinite() && b.allFinite();
    const double turn = defined ? 1.0 - std::abs(a.dot(b)) : kUndefinedTurn;
    const Testimony& testimony = said_[to];
    const bool fits = labels_[from] == Label::kMoving && testimony.past > testimony.met;
    return (fits ? kSuspicion : 1.0) * distance_m * (1.0 + kTurnWeight * turn);
  }

  const PlacedSurface& own_;
  const std::vector<Testimony>& said_;
  std::vector<Label>& labels_;
  std::vector<double> cost_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

MovingLeaves Gather(const StationModel& model, const std::vector<Label>& labels) {
  MovingLeaves moving;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != Label::kMoving) continue;
    moving.leaves.push_back(static_cast<std::uint32_t>(i));
    moving.points += static_cast<std::uint64_t>(model.leaves.Count(i));
  }
  return moving;
}

}  // namespace

void VisitOptions(OptionVisitor& visitor, MovingObjectOptions& options) {
  visitor.Real("clearance", options.clearance, "voxels", 1.0, 20.0,
               "how far beyond a point other stations must have seen for it to have moved");
  visitor.Real("reach", options.reach, "voxels", 1.0, 20.0,
               "radius of the neighbourhood that is judged together");
  visitor.Real("majority", options.majority, "1", 0.0, 1.0,
               "share of the neighbourhood that others must have seen through");
}

std::vector<MovingLeaves> FindMovingLeaves(const std::vector<PlacedSurface>& surfaces,
                                           const MovingObjectOptions& options,
                                           const ExecutionContext& context) {
  std::vector<MovingLeaves> result(surfaces.size());
  std::vector<double> reach_m;
  reach_m.reserve(surfaces.size());
  for (const PlacedSurface& placed : surfaces) {
    reach_m.push_back(FarthestRange(placed.surface.model));
  }
  context.ParallelFor(surfaces.size(), [&](std::size_t s) {
    const std::vector<Testimony> said = HearAll(surfaces, s, reach_m, options, context);
    std::vector<Label> labels = LabelByTestimony(surfaces[s], said, options);
    RegionGrowing(surfaces[s], said, &labels).Run();
    result[s] = Gather(surfaces[s].surface.model, labels);
  });
  return result;
}

}  // namespace backsight

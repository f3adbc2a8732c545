#include "stages/structure_images.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "stages/dominant_frame.h"

namespace backsight {
namespace {

constexpr std::size_t kMostImages = 24;
constexpr std::size_t kShiftsPerAxis = 2;
constexpr double kFarthestShift = 50.0;   // m either way
constexpr double kLikeDirection = 0.985;  // cosine of 10 deg

/// A cloud's surfaces: positions and normals of an even sample.
struct Facets {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d> normals;
};

Facets FacetsOf(const Surface& surface, const CloudIndex& index) {
  Facets facets;
  for (const std::uint32_t leaf : index.sample.leaves) {
    if (!surface.normals[leaf].allFinite()) continue;
    facets.positions.push_back(surface.model.leaves.Mean(leaf));
    facets.normals.push_back(surface.normals[leaf].cast<double>());
  }
  return facets;
}

/// The direction that most normals share, of those at right angles to `across` (if it is not zero).
/// None where fewer than one in twenty do.
std::optional<Eigen::Vector3d> DominantDirection(const std::vector<Eigen::Vector3d>& normals,
                                                 const Eigen::Vector3d& across) {
  constexpr std::size_t kSeeds = 150;
  constexpr std::size_t kVoters = 3000;
  constexpr double kRightAngle = 0.17;  // sine of 10 deg
  const std::size_t seed_stride = std::max<std::size_t>(1, normals.size() / kSeeds);
  const std::size_t stride = std::max<std::size_t>(1, normals.size() / kVoters);
  std::size_t most = normals.size() / stride / 20;
  std::optional<Eigen::Vector3d> best;
  for (std::size_t i = 0; i < normals.size(); i += seed_stride) {
    if (std::abs(normals[i].dot(across)) > kRightAngle) continue;
    std::size_t votes = 0;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (std::size_t j = 0; j < normals.size(); j += stride) {
      if (std::abs(normals[j].dot(normals[i])) < kLikeDirection) continue;
      ++votes;
      scatter += normals[j] * normals[j].transpose();
    }
    if (votes <= most) continue;
    most = votes;
    best = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(2);
  }
  return best;
}

/// Columns: the principal directions, right-handed. None where there are not two.
std::optional<Eigen::Matrix3d> PrincipalAxes(const std::vector<Eigen::Vector3d>& normals) {
  const auto first = DominantDirection(normals, Eigen::Vector3d::Zero());
  if (!first) return std::nullopt;
  const auto second = DominantDirection(normals, *first);
  if (!second) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = *first;
  axes.col(1) = (*second - first->dot(*second) * *first).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

/// Where along the six signed axes surfaces lie that face that way: roots of counts, so that a
/// floor does not outweigh all walls.
class OffsetHistograms {
 public:
  OffsetHistograms(const Facets& facets, const Eigen::Matrix3d& rotation,
                   const Eigen::Matrix3d& axes, double bin_m, bool blurred)
      : bin_m_(bin_m), bins_(2 * static_cast<int>(kReach / bin_m) + 1) {
    for (auto& histogram : histograms_) histogram.assign(static_cast<std::size_t>(bins_), 0.0F);
    const Eigen::Matrix3d turn = axes.transpose() * rotation;
    for (std::size_t i = 0; i < facets.positions.size(); ++i) {
      const Eigen::Vector3d normal = turn * facets.normals[i];
      for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(normal[axis]) < kLikeDirection) continue;
        const int bin = Bin((turn.row(axis) * facets.positions[i]).value());
        if (bin < 0 || bin >= bins_) continue;
        histograms_[Slot(axis, normal[axis] > 0.0)][static_cast<std::size_t>(bin)] += 1.0F;
      }
    }
    for (auto& histogram : histograms_) {
      for (float& count : histogram) count = std::sqrt(count);
      if (blurred) Blur(&histogram);
    }
  }

  /// Along `axis`, facing to its positive or negative side.
  float At(int axis, bool positive, int bin) const {
    return histograms_[Slot(axis, positive)][static_cast<std::size_t>(bin)];
  }
  /// All bins, counted in the axis's direction or against it, between `margin` empty ones.
  std::vector<float> Along(int axis, bool positive, bool reversed, int margin) const {
    std::vector<float> bins = histograms_[Slot(axis, positive != reversed)];
    if (reversed) std::reverse(bins.begin(), bins.end());
    bins.insert(bins.begin(), static_cast<std::size_t>(margin), 0.0F);
    bins.resize(bins.size() + static_cast<std::size_t>(margin), 0.0F);
    return bins;
  }
  int bins() const { return bins_; }
  double bin_m() const { return bin_m_; }

 private:
  static constexpr double kReach = 100.0;  // m from the scanner

  /// Half of each neighbour, so that a shift need not be a whole number of bins.
  static void Blur(std::vector<float>* histogram) {
    const std::vector<float> sharp = *histogram;
    for (std::size_t i = 1; i + 1 < sharp.size(); ++i) {
      (*histogram)[i] += 0.5F * (sharp[i - 1] + sharp[i + 1]);
    }
  }
  static std::size_t Slot(int axis, bool positive) {
    return static_cast<std::size_t>(2 * axis + (positive ? 1 : 0));
  }
  int Bin(double offset) const {
    return static_cast<int>(std::lround(offset / bin_m_)) + (bins_ - 1) / 2;
  }

  double bin_m_;
  int bins_;
  std::array<std::vector<float>, 6> histograms_;
};

struct Shift {
  double offset_m = 0.0;
  double correlation = 0.0;
};

/// The shifts of the source along a target axis at which most surfaces coincide, best first, at
/// least a metre apart. The source's axis `from`, maybe reversed, comes to lie on the target's
/// `to`.
std::vector<Shift> BestShifts(const OffsetHistograms& target, int to,
                              const OffsetHistograms& source, int from, bool reversed) {
  const int reach = static_cast<int>(kFarthestShift / target.bin_m());
  std::vector<double> sums(static_cast<std::size_t>(2 * reach + 1), 0.0);
  for (const bool positive : {false, true}) {
    const std::vector<float> moving = source.Along(from, positive, reversed, reach);
    for (int bin = 0; bin < target.bins(); ++bin) {
      const float there = target.At(to, positive, bin);
      if (there == 0.0F) continue;
      // By falling shift the source's bins ascend: bin - shift.
      const float* bins = moving.data() + bin;
      double* sum = sums.data() + 2 * reach;
      for (int k = 0; k <= 2 * reach; ++k) sum[-k] += static_cast<double>(there * bins[k]);
    }
  }
  std::vector<Shift> all;
  all.reserve(sums.size());
  for (int shift = -reach; shift <= reach; ++shift) {
    all.push_back({shift * target.bin_m(), sums[static_cast<std::size_t>(shift + reach)]});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Shift& a, const Shift& b) { return a.correlation > b.correlation; });
  std::vector<Shift> best;
  for (const Shift& shift : all) {
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const Shift& other) {
      return std::abs(other.offset_m - shift.offset_m) < 1.0;
    });
    if (is_new) best.push_back(shift);
    if (best.size() == kShiftsPerAxis) break;
  }
  return best;
}

}  // namespace

std::vector<RigidTransform> FindStructureImages(const Surface& source,
                                                const CloudIndex& source_index,
                                                const Surface& target,
                                                const CloudIndex& target_index,
                                                const RigidTransform& target_from_source) {
  const Facets of_target = FacetsOf(target, target_index);
  const auto axes = PrincipalAxes(of_target.normals);
  if (!axes) return {};
  const double bin_m = 2.0 * target.model.resolution_m();
  const OffsetHistograms in_target(of_target, Eigen::Matrix3d::Identity(), *axes, bin_m,
                                   /*blurred=*/false);
  const OffsetHistograms in_source(FacetsOf(source, source_index), target_from_source.rotation,
                                   *axes, bin_m, /*blurred=*/true);
  std::array<std::vector<Shift>, 18> shifts;  // by target axis, source axis, direction
  for (int i = 0; i < 18; ++i) {
    shifts[static_cast<std::size_t>(i)] =
        BestShifts(in_target, i / 6, in_source, i / 2 % 3, i % 2 == 1);
  }
  struct Image {
    RigidTransform motion;
    double correlation = 0.0;
  };
  std::vector<Image> images;
  for (const Eigen::Matrix3d& turn : CubeTurns()) {
    std::array<const std::vector<Shift>*, 3> along{};
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Index from = 0;
      turn.row(axis).cwiseAbs().maxCoeff(&from);
      const bool reversed = turn(axis, from) < 0.0;
      along[static_cast<std::size_t>(axis)] =
          &shifts[static_cast<std::size_t>(6 * axis + 2 * static_cast<int>(from)) +
                  (reversed ? 1U : 0U)];
    }
    for (const Shift& x : *along[0]) {
      for (const Shift& y : *along[1]) {
        for (const Shift& z : *along[2]) {
          images.push_back({{*axes * turn * axes->transpose() * target_from_source.rotation,
                             *axes * Eigen::Vector3d(x.offset_m, y.offset_m, z.offset_m)},
                            x.correlation + y.correlation + z.correlation});
        }
      }
    }
  }
  std::stable_sort(images.begin(), images.end(),
                   [](const Image& a, const Image& b) { return a.correlation > b.correlation; });
  std::vector<RigidTransform> motions;
  for (const Image& image : images) {
    if (motions.size() < kMostImages) motions.push_back(image.motion);
  }
  return motions;
}

}  // namespace backsight

#include "stages/surface_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace backsight {
namespace {

constexpr std::uint32_t kNone = ~0U;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using Column = std::unique_ptr<double[]>;
using Columns = std::array<Column, 3>;

/// Not set but for what is read beyond the last.
Column MakeColumn(std::size_t count) {
  Column column = std::make_unique_for_overwrite<double[]>(count + kSurfacePadding);
  std::fill_n(column.get() + count, kSurfacePadding, kNaN);
  return column;
}

void Put(const Eigen::Vector3d& value, std::size_t i, Columns* columns) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    (*columns)[axis][i] = value[static_cast<Eigen::Index>(axis)];
  }
}

Eigen::Vector3d Get(const Columns& columns, std::size_t i) {
  return {columns[0][i], columns[1][i], columns[2][i]};
}

std::array<const double*, 3> Begins(const Columns& columns) {
  return {columns[0].get(), columns[1].get(), columns[2].get()};
}

}  // namespace

SurfacePairs::SurfacePairs(const Surface& source, const Surface& target,
                           const CloudIndex& target_index, std::span<const std::uint32_t> chosen,
                           double reach_m)
    : target_(target), index_(target_index), reach_m_(reach_m), count_(chosen.size()) {
  for (Columns* columns : {&point_, &normal_, &asked_, &fixed_, &fixed_normal_}) {
    for (Column& column : *columns) column = MakeColumn(count_);
  }
  others_ = MakeColumn(count_);
  uncertain_.resize(count_);
  answers_.resize(count_);
  std::iota(uncertain_.begin(), uncertain_.end(), 0U);
  for (std::size_t i = 0; i < count_; ++i) {
    Put(source.model.leaves.Mean(chosen[i]), i, &point_);
    Put(source.normals[chosen[i]].cast<double>(), i, &normal_);
  }
}

SurfacePairColumns SurfacePairs::View() const {
  return {Begins(point_),        Begins(normal_), Begins(asked_), Begins(fixed_),
          Begins(fixed_normal_), others_.get(),   count_};
}

/// Of the first `count` of those uncertain.
void SurfacePairs::AskAgain(const RigidTransform& target_from_source, std::size_t count) {
  const double wide_m = 1.1 * reach_m_;
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t i = uncertain_[n];
    const Eigen::Vector3d moved = target_from_source * Get(point_, i);
    const auto nearest = index_.voxels.Nearest(target_.model.leaves.means(), moved, wide_m);
    Put(moved, i, &asked_);
    others_[i] = nearest ? std::sqrt(nearest->others_squared_m2) : wide_m;
    answers_[n] = nearest ? nearest->voxel : kNone;
  }
  // Apart from the search, so that the processor fetches several of them at a time.
  for (std::size_t n = 0; n < count; ++n) {
    const bool is_some = answers_[n] != kNone;
    const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
    Put(is_some ? target_.model.leaves.Mean(answers_[n]) : none, uncertain_[n], &fixed_);
    Put(is_some ? Eigen::Vector3d(target_.normals[answers_[n]].cast<double>()) : none,
        uncertain_[n], &fixed_normal_);
  }
}

SurfacePairSums SurfacePairs::Sum(const RigidTransform& target_from_source,
                                  const SurfacePairRule& rule) {
  const KernelMotion motion(target_from_source);
  const std::size_t count =
      is_asked_ ? FindUncertain(View(), motion, reach_m_, uncertain_.data()) : count_;
  AskAgain(target_from_source, count);
  is_asked_ = true;
  return SumSurfacePairs(View(), motion, rule);
}

}  // namespace backsight

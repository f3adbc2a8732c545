#include "stages/cloud_thinning.h"

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

constexpr double kLeastCos = 0.2;
constexpr double kUnknownCos = 0.5;
constexpr unsigned kIndexBits = 48;
constexpr unsigned kRecentBits = 13;                  // 200 kB, what a core's own cache holds
constexpr std::uint64_t kNoCell = ~std::uint64_t{0};  // keys have 63 bits

/// Ascends as places do.
std::uint64_t Packed(const PointPlace& place) {
  BACKSIGHT_CHECK(place.station < 65536 && place.index >> kIndexBits == 0,
                  "a place that 64 bits can hold");
  return std::uint64_t{place.station} << kIndexBits | place.index;
}

/// Multiplicative hashing (Knuth): the upper bits depend on all of the key's.
std::size_t SlotOf(std::uint64_t cell) {
  return (cell * 0x9E3779B97F4A7C15U) >> (64U - kRecentBits);
}

}  // namespace

double PointUncertainty(double range_m, const std::optional<double>& cos_incidence) {
  return range_m / std::max(cos_incidence.value_or(kUnknownCos), kLeastCos);
}

CloudThinning::CloudThinning(const VoxelLattice& lattice, const ThinningSpace& space)
    : lattice_(lattice),
      recent_(std::size_t{1} << kRecentBits, Candidate{kNoCell, 0, 0.0F}),
      candidates_(std::in_place, space.path, space.memory_bytes),
      chosen_(space.path, space.memory_bytes / 2) {}

void CloudThinning::Offer(const PointPlace& place, const Eigen::Vector3d& point,
                          double uncertainty) {
  const Candidate candidate{lattice_.Key(point), Packed(place), static_cast<float>(uncertainty)};
  Candidate& recent = recent_[SlotOf(candidate.cell)];
  if (recent.cell != candidate.cell) {
    if (recent.cell != kNoCell) candidates_->Add(recent);
    recent = candidate;
  } else if (candidate < recent) {
    recent = candidate;
  }
}

void CloudThinning::Choose(const ExecutionContext& context) {
  for (const Candidate& recent : recent_) {
    if (recent.cell != kNoCell) candidates_->Add(recent);
  }
  const auto between = [&context] { context.CheckStop(); };
  candidates_->Finish(between);
  std::uint64_t cells = 0;
  for (Candidate best; candidates_->Next(&best);) {
    if (++cells % 65536 == 0) context.CheckStop();
    chosen_.Add(best.place);
  }
  candidates_.reset();
  chosen_.Finish(between);
  next_.emplace();
  if (!chosen_.Next(&*next_)) next_.reset();
}

bool CloudThinning::Takes(const PointPlace& place) {
  if (next_ != Packed(place)) return false;
  if (!chosen_.Next(&*next_)) next_.reset();
  return true;
}

}  // namespace backsight

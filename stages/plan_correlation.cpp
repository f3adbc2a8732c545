#include "stages/plan_correlation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.h"

namespace backsight {
namespace {

constexpr int kCells = PlanField::kCells;
constexpr int kHalf = kCells / 2;

/// A place among the translations by whole cells.
struct Peak {
  int turn = 0;
  int x = 0, y = 0;  // cells
  int votes = 0;
};

bool Before(const Peak& a, const Peak& b) {
  if (a.votes != b.votes) return a.votes > b.votes;
  return std::array{a.turn, a.y, a.x} < std::array{b.turn, b.y, b.x};
}

/// How many walls of a view face each way.
std::vector<double> FacingHistogram(const PlanView& view, int turns) {
  std::vector<double> histogram(static_cast<std::size_t>(turns), 0.0);
  for (const PlanWall& wall : view.walls()) {
    const double share = wall.facing_rad / (2.0 * std::numbers::pi);
    const double at = (share - std::floor(share)) * turns;
    const int bin = static_cast<int>(at);
    const double part = at - bin;
    histogram[static_cast<std::size_t>(bin % turns)] += 1.0 - part;
    histogram[static_cast<std::size_t>((bin + 1) % turns)] += part;
  }
  return histogram;
}

/// The headings under which most walls face alike, ascending.
std::vector<int> ChooseTurns(const PlanView& source, const PlanView& target,
                             const PlanCorrelationOptions& options) {
  std::vector<int> turns(static_cast<std::size_t>(options.turns));
  std::iota(turns.begin(), turns.end(), 0);
  if (options.tried_turns >= options.turns) return turns;
  const std::vector<double> of_source = FacingHistogram(source, options.turns);
  const std::vector<double> of_target = FacingHistogram(target, options.turns);
  std::vector<double> alike(turns.size(), 0.0);
  for (std::size_t turn = 0; turn < turns.size(); ++turn) {
    for (std::size_t bin = 0; bin < turns.size(); ++bin) {
      alike[turn] += of_source[bin] * of_target[(bin + turn) % turns.size()];
    }
  }
  std::stable_sort(turns.begin(), turns.end(), [&](int a, int b) {
    return alike[static_cast<std::size_t>(a)] > alike[static_cast<std::size_t>(b)];
  });
  turns.resize(static_cast<std::size_t>(options.tried_turns));
  std::sort(turns.begin(), turns.end());
  return turns;
}

/// Votes for all translations under one heading after the other.
class Correlator {
 public:
  Correlator(const PlanView& source, const PlanView& target)
      : source_(source),
        target_(target),
        free_(std::size_t{kCells} * kCells, 0),
        votes_(std::size_t{kCells} * kCells, 0) {}

  void Vote(double heading_rad) {
    cosine_ = std::cos(heading_rad);
    sine_ = std::sin(heading_rad);
    std::fill(votes_.begin(), votes_.end(), std::int16_t{0});
    for (const PlanWall& wall : source_.sample()) {
      const Eigen::Vector2d place = Turn(wall.position_m);
      AddShifted(target_.field().Sector(FacingSector(wall.facing_rad + heading_rad)),
                 target_.CellOf(place.x()) - kHalf, target_.CellOf(place.y()) - kHalf);
    }
    DrawSource(heading_rad);
    for (const PlanWall& wall : target_.sample()) {
      AddShifted(field_.Sector(FacingSector(wall.facing_rad)),
                 kHalf - target_.CellOf(wall.position_m.x()),
                 kHalf - target_.CellOf(wall.position_m.y()));
    }
  }

  /// The `count` highest local maxima of the last vote.
  void CollectPeaks(int turn, std::size_t count, std::vector<Peak>* peaks) const {
    std::vector<Peak> own;
    for (int y = 1; y + 1 < kCells; ++y) {
      for (int x = 1; x + 1 < kCells; ++x) {
        const std::int16_t* votes = votes_.data() + y * kCells + x;
        if (*votes <= 0 || *votes < votes[-1] || *votes < votes[1] || *votes < votes[-kCells] ||
            *votes < votes[kCells]) {
          continue;
        }
        own.push_back({turn, x - kHalf, y - kHalf, *votes});
      }
    }
    const std::size_t kept = std::min(count, own.size());
    std::partial_sort(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(kept), own.end(),
                      Before);
    peaks->insert(peaks->end(), own.begin(), own.begin() + static_cast<std::ptrdiff_t>(kept));
  }

 private:
  Eigen::Vector2d Turn(const Eigen::Vector2d& place) const {
    return {cosine_ * place.x() - sine_ * place.y(), sine_ * place.x() + cosine_ * place.y()};
  }

  /// votes(x, y) += field(x + dx, y + dy).
  void AddShifted(const std::int16_t* field, int dx, int dy) {
    const int begin = std::max(0, -dx);
    const int end = std::min(kCells, kCells - dx);
    for (int y = std::max(0, -dy); y < std::min(kCells, kCells - dy); ++y) {
      std::int16_t* votes = votes_.data() + y * kCells;
      const std::int16_t* row = field + (y + dy) * kCells + dx;
      for (int x = begin; x < end; ++x) {
        votes[x] = static_cast<std::int16_t>(votes[x] + row[x]);
      }
    }
  }

  /// The source's field turned, and point-mirrored, so that translations run along its cells.
  void DrawSource(double heading_rad) {
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) {
        const double u = kHalf - x;
        const double v = kHalf - y;
        const int column = static_cast<int>(std::floor(cosine_ * u + sine_ * v + 0.5)) + kHalf;
        const int row = static_cast<int>(std::floor(cosine_ * v - sine_ * u + 0.5)) + kHalf;
        free_[static_cast<std::size_t>(y * kCells + x)] = source_.IsFree(column, row) ? 1 : 0;
      }
    }
    field_.Fill(free_);
    for (const PlanWall& wall : source_.walls()) {
      const Eigen::Vector2d place = Turn(wall.position_m);
      field_.AddWall(FacingSector(wall.facing_rad + heading_rad),
                     kCells - source_.CellOf(place.x()), kCells - source_.CellOf(place.y()));
    }
  }

  const PlanView& source_;
  const PlanView& target_;
  double cosine_ = 1.0;
  double sine_ = 0.0;
  PlanField field_;  // of the source
  std::vector<char> free_;
  std::vector<std::int16_t> votes_;
};

/// The highest peaks, none near a higher one.
std::vector<Peak> Thin(std::vector<Peak> peaks, int turns, std::size_t count) {
  constexpr double kNearTurn = 10.0;  // deg
  constexpr int kNearCells = 2;
  std::stable_sort(peaks.begin(), peaks.end(), Before);
  std::vector<Peak> kept;
  for (const Peak& peak : peaks) {
    if (kept.size() == count) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Peak& other) {
      const double turn_deg =
          std::abs(std::remainder(peak.turn - other.turn, turns)) * 360.0 / turns;
      return turn_deg <= kNearTurn && std::abs(peak.x - other.x) <= kNearCells &&
             std::abs(peak.y - other.y) <= kNearCells;
    });
    if (!known) kept.push_back(peak);
  }
  return kept;
}

}  // namespace

std::vector<PlanMatch> CorrelatePlans(const PlanView& source, const PlanView& target,
                                      const PlanCorrelationOptions& options) {
  BACKSIGHT_CHECK(source.cell_m() == target.cell_m(), "plans are compared at equal cells");
  const auto heading = [&](int turn) { return turn * 2.0 * std::numbers::pi / options.turns; };
  Correlator correlator(source, target);
  std::vector<Peak> peaks;
  for (const int turn : ChooseTurns(source, target, options)) {
    correlator.Vote(heading(turn));
    correlator.CollectPeaks(turn, options.matches, &peaks);
  }
  const double whole =
      static_cast<double>(source.sample().size() + target.sample().size()) * PlanField::kWall;
  std::vector<PlanMatch> matches;
  for (const Peak& peak : Thin(std::move(peaks), options.turns, options.matches)) {
    PlanMatch match;
    match.target_from_source.rotation =
        Eigen::AngleAxisd(heading(peak.turn), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    match.target_from_source.translation = source.cell_m() * Eigen::Vector3d(peak.x, peak.y, 0.0);
    match.target_from_source.translation.z() =
        target.GroundOffset(source, match.target_from_source);
    match.score = peak.votes / whole;
    matches.push_back(match);
  }
  return matches;
}

}  // namespace backsight

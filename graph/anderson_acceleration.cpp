#include "graph/anderson_acceleration.h"

#include <Eigen/QR>

namespace backsight {
namespace {

constexpr double kSmallestDifference = 1e-14;
constexpr double kRankThreshold = 1e-8;  // of the column-scaled least-squares problem

}  // namespace

Eigen::VectorXd AndersonAccelerator::Propose(const Eigen::VectorXd& x, const Eigen::VectorXd& g) {
  const Eigen::VectorXd f = g - x;
  if (last_f_.size() == f.size()) {
    Difference difference{f - last_f_, g - last_g_};
    if (difference.f.norm() > kSmallestDifference) differences_.push_front(std::move(difference));
    if (static_cast<int>(differences_.size()) > window_) differences_.pop_back();
  }
  last_f_ = f;
  last_g_ = g;
  if (differences_.empty()) return g;

  const auto columns = static_cast<Eigen::Index>(differences_.size());
  Eigen::MatrixXd scaled(f.size(), columns);
  for (Eigen::Index j = 0; j < columns; ++j) {
    scaled.col(j) = differences_[static_cast<std::size_t>(j)].f.normalized();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  qr.setThreshold(kRankThreshold);
  qr.compute(scaled);
  const Eigen::VectorXd gamma = qr.solve(f);  // dependent columns get zero
  Eigen::VectorXd proposal = g;
  for (Eigen::Index j = 0; j < columns; ++j) {
    const Difference& difference = differences_[static_cast<std::size_t>(j)];
    proposal -= (gamma[j] / difference.f.norm()) * difference.g;
  }
  return proposal.allFinite() ? proposal : g;
}

void AndersonAccelerator::Reset() {
  last_f_.resize(0);
  last_g_.resize(0);
  differences_.clear();
}

}  // namespace backsight

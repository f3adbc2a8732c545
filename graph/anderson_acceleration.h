#pragma once

#include <Eigen/Core>
#include <deque>

namespace backsight {

/// Anderson acceleration, type II, of a fixed-point iteration x <- G(x): from the last h steps it
/// extrapolates x+ = G_k - sum gamma_j dG_j with gamma = argmin |f_k - sum gamma_j dF_j|, f = G -
/// x, unconstrained (Walker & Ni 2011, doi 10.1137/10078356X; the paper's Eq. 18 adds a constraint
/// that belongs to another form and forbids progress at h = 1). The caller safeguards: it takes x+
/// only where its own cost is lower than at G_k.
class AndersonAccelerator {
 public:
  /// `window` h >= 1: how many differences are kept.
  explicit AndersonAccelerator(int window) : window_(window) {}

  /// Records the step x -> g and returns the extrapolated point, which is g itself as long as there
  /// is no history or the differences are too small or dependent to be used.
  Eigen::VectorXd Propose(const Eigen::VectorXd& x, const Eigen::VectorXd& g);

  /// Forgets the history; call it when G itself has changed.
  void Reset();

 private:
  struct Difference {
    Eigen::VectorXd f, g;
  };

  int window_;
  Eigen::VectorXd last_f_, last_g_;
  std::deque<Difference> differences_;  // newest first
};

}  // namespace backsight

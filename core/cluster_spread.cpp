#include "core/cluster_spread.h"

namespace backsight {

ClusterSpread::ClusterSpread(const PointCluster& cluster) : count_(WholeCount(cluster)) {
  const ScatterFactor factor = FactorOf(cluster.scatter);
  for (std::size_t i = 0; i < factor.size(); ++i) factor_[i] = static_cast<float>(factor[i]);
}

}  // namespace backsight

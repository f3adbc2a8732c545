#pragma once

#include <vector>

#include "graph/correspondences.h"
#include "graph/reliability_kernels.h"

namespace backsight {

/// Correspondences as one float column per coordinate, each cloud about its own centroid: what the
/// kernels of RGN and RGE read. Metres. Columns end in kPadding NaN, so that a kernel may read
/// whole vectors beyond the last row; a NaN agrees with nothing.
struct PairColumns {
  static constexpr std::size_t kPadding = 16;

  explicit PairColumns(const Correspondences& c);

  std::size_t rows = 0;
  std::vector<float> qx, qy, qz;  ///< source
  std::vector<float> px, py, pz;  ///< target
  float extent_m = 0.0F;          ///< largest absolute coordinate
};

inline ColumnView View(const PairColumns& c) {
  return {c.qx.data(), c.qy.data(), c.qz.data(), c.px.data(), c.py.data(), c.pz.data(), c.rows};
}

}  // namespace backsight

#pragma once

#include "core/cache_line_vector.h"
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
  CacheLineVector<float> qx, qy, qz;            ///< source
  CacheLineVector<float> px, py, pz;            ///< target
  CacheLineVector<float> q_squared, p_squared;  ///< |q|^2 and |p|^2 of these, m^2
  float extent_m = 0.0F;                        ///< largest absolute coordinate
};

inline ColumnView View(const PairColumns& c) {
  return {c.qx.data(),
          c.qy.data(),
          c.qz.data(),
          c.px.data(),
          c.py.data(),
          c.pz.data(),
          c.q_squared.data(),
          c.p_squared.data(),
          3.0F * c.extent_m * c.extent_m,
          c.rows};
}

}  // namespace backsight

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/execution.h"
#include "core/option_visitor.h"
#include "stages/station_model.h"

namespace backsight {

struct SignatureOptions {
  int words = 64;             ///< of the vocabulary
  int training_size = 20000;  ///< descriptors the vocabulary is trained on, from all stations alike
  int training_rounds = 12;
};

/// What a station's key points look like as a whole: a vector of locally aggregated descriptors
/// (VLAD, Jegou 2010, doi 10.1109/CVPR.2010.5540039) of its FPFH, each word's block normalised,
/// the whole of length 1. The dot product of two signatures, -1 to 1, is their similarity.
/// Positions do not enter.
using StationSignature = Eigen::VectorXf;

/// Signatures of all stations over one vocabulary that is trained on these stations (k-means,
/// seeded by the context). A station without descriptors gets a zero vector, similar to nothing.
/// Time O(descriptors * words * 33), memory words * 33 floats per station. Does not depend on the
/// number of threads.
std::vector<StationSignature> ComputeSignatures(std::span<const StationFeatures* const> stations,
                                                const SignatureOptions& options,
                                                const ExecutionContext& context);

}  // namespace backsight

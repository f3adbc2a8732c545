#include "stages/station_signature.h"

#include <algorithm>
#include <cmath>

#include "core/even_choice.h"
#include "core/random.h"

namespace backsight {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr Eigen::Index kBins = 33;

Eigen::Map<const Eigen::Matrix<float, 1, kBins>> Row(const FpfhDescriptor& descriptor) {
  return Eigen::Map<const Eigen::Matrix<float, 1, kBins>>(descriptor.data());
}

bool IsFinite(const FpfhDescriptor& descriptor) { return Row(descriptor).allFinite(); }

/// An even sample over all stations, the same share of each.
Matrix TrainingSet(std::span<const StationFeatures* const> stations, int size) {
  std::vector<const FpfhDescriptor*> all;
  for (const StationFeatures* station : stations) {
    for (const FpfhDescriptor& descriptor : station->descriptors) {
      if (IsFinite(descriptor)) all.push_back(&descriptor);
    }
  }
  const EvenChoice chosen(all.size(), static_cast<std::size_t>(size));
  Matrix rows(static_cast<Eigen::Index>(chosen.count()), kBins);
  for (std::size_t i = 0; i < chosen.count(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = Row(*all[chosen[i]]);
  }
  return rows;
}

/// The nearest word; equal distances go to the lower index.
Eigen::Index NearestWord(const Matrix& words, const Eigen::Matrix<float, 1, kBins>& descriptor) {
  Eigen::Index nearest = 0;
  (words.rowwise() - descriptor).rowwise().squaredNorm().minCoeff(&nearest);
  return nearest;
}

/// Seeds far from each other (k-means++): each is drawn with the square of its distance from those
/// already chosen.
Matrix SeedWords(const Matrix& training, Eigen::Index words, std::uint64_t seed) {
  Random random(seed);
  Matrix chosen(words, kBins);
  Eigen::VectorXf distance = Eigen::VectorXf::Ones(training.rows());
  for (Eigen::Index w = 0; w < words; ++w) {
    double rest = random.Uniform() * distance.cast<double>().sum();
    Eigen::Index pick = 0;
    while (pick + 1 < training.rows() && rest >= static_cast<double>(distance[pick])) {
      rest -= static_cast<double>(distance[pick++]);
    }
    chosen.row(w) = training.row(pick);
    const Eigen::VectorXf from_new = (training.rowwise() - chosen.row(w)).rowwise().squaredNorm();
    distance = w == 0 ? from_new : distance.cwiseMin(from_new).eval();
  }
  return chosen;
}

Matrix TrainWords(const Matrix& training, const SignatureOptions& options,
                  const ExecutionContext& context) {
  const auto words = static_cast<Eigen::Index>(options.words);
  Matrix centers = SeedWords(training, words, DeriveSeed(context.seed(), "vocabulary"));
  std::vector<Eigen::Index> word(static_cast<std::size_t>(training.rows()));
  for (int round = 0; round < options.training_rounds; ++round) {
    context.CheckStop();
    context.ParallelFor(
        word.size(),
        [&](std::size_t i) {
          word[i] = NearestWord(centers, training.row(static_cast<Eigen::Index>(i)));
        },
        /*grain=*/256);
    Matrix sum = Matrix::Zero(words, kBins);
    std::vector<float> count(static_cast<std::size_t>(words), 0.0F);
    for (std::size_t i = 0; i < word.size(); ++i) {
      sum.row(word[i]) += training.row(static_cast<Eigen::Index>(i));
      count[static_cast<std::size_t>(word[i])] += 1.0F;
    }
    for (Eigen::Index w = 0; w < words; ++w) {
      const float n = count[static_cast<std::size_t>(w)];
      if (n > 0.0F) centers.row(w) = sum.row(w) / n;
    }
  }
  return centers;
}

StationSignature Describe(const StationFeatures& station, const Matrix& words) {
  Matrix residual = Matrix::Zero(words.rows(), kBins);
  for (const FpfhDescriptor& descriptor : station.descriptors) {
    if (!IsFinite(descriptor)) continue;
    const Eigen::Index w = NearestWord(words, Row(descriptor));
    residual.row(w) += Row(descriptor) - words.row(w);
  }
  // Square roots and a unit block per word keep the most frequent surfaces, ground and plain walls,
  // from drowning the rare ones that tell places apart.
  residual = residual.array().sign() * residual.array().abs().sqrt();
  for (Eigen::Index w = 0; w < residual.rows(); ++w) {
    const float norm = residual.row(w).norm();
    if (norm > 0.0F) residual.row(w) /= norm;
  }
  StationSignature signature = residual.reshaped<Eigen::RowMajor>();
  const float norm = signature.norm();
  if (norm > 0.0F) signature /= norm;
  return signature;
}

}  // namespace

std::vector<StationSignature> ComputeSignatures(std::span<const StationFeatures* const> stations,
                                                const SignatureOptions& options,
                                                const ExecutionContext& context) {
  const Matrix training = TrainingSet(stations, options.training_size);
  const auto words = static_cast<Eigen::Index>(options.words);
  std::vector<StationSignature> signatures(stations.size(), StationSignature::Zero(words * kBins));
  if (training.rows() < words) return signatures;
  const Matrix centers = TrainWords(training, options, context);
  context.ParallelFor(stations.size(),
                      [&](std::size_t s) { signatures[s] = Describe(*stations[s], centers); });
  // Without what all stations have in common the differences count.
  StationSignature mean = StationSignature::Zero(words * kBins);
  for (const StationSignature& signature : signatures) mean += signature;
  mean /= static_cast<float>(stations.size());
  for (StationSignature& signature : signatures) {
    if (signature.isZero(0.0F)) continue;
    signature -= mean;
    const float norm = signature.norm();
    if (norm > 0.0F) signature /= norm;
  }
  return signatures;
}

}  // namespace backsight

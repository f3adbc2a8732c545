#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/artifact_store.h"
#include "io/survey_project.h"
#include "pipeline/georeference_network.h"
#include "pipeline/pair_pipeline.h"
#include "pipeline/survey_options.h"

namespace backsight {

/// What the keys of a run's artifacts have in common.
struct KeyBase {
  const SurveyOptions& options;
  std::uint64_t seed = 0;
};

/// Stage, program, seed, and the named sections of the options (SurveyOptions).
ArtifactKey StageKey(const KeyBase& base, std::string_view stage,
                     const std::vector<std::string>& sections);

/// Of one station, from its scan's fingerprint on.
ArtifactKey StationKey(const KeyBase& base, const StationSpec& spec,
                       const std::string& scan_fingerprint);

/// Of one attempt at a pair. The lines `motion` and `before` say what it starts from: motions that
/// the network proposes, and the digest of the attempt that it builds on (empty: none).
ArtifactKey PairKey(const KeyBase& base, std::string_view method, const Station& source,
                    const Station& target, const std::vector<RigidTransform>& motions,
                    const std::string& before);

/// Of the ranking of pairs; `may_be_tried`: of all of them in their order.
ArtifactKey RankingKey(const KeyBase& base, const std::vector<Station>& stations,
                       const std::vector<char>& may_be_tried);

/// Of the ranking of further pairs: `asked`, in this order.
ArtifactKey FurtherRankingKey(const KeyBase& base, const std::vector<Station>& stations,
                              const std::vector<std::size_t>& asked);

/// Of what the pairs of a project say of their scanners.
ArtifactKey ScannersKey(const KeyBase& base, const std::vector<Station>& stations,
                        const PairSpec& spec);

/// Of the network that the pairs make.
ArtifactKey NetworkKey(const KeyBase& base, const std::vector<Station>& stations,
                       const std::vector<Pair>& pairs);

/// Of what moved in a network.
ArtifactKey MovingKey(const KeyBase& base, const std::string& network_digest);

/// What all clouds and maps of a project depend on, but for where georeferencing puts the stations
/// (AddGround).
ArtifactKey OutputsKey(const KeyBase& base, const SurveyProject& project,
                       const std::string& network_digest);

/// Adds the places of the stations in the outputs, which depend on what the machine knows of
/// reference systems too, as the line `ground`.
void AddGround(const std::vector<Station>& stations, const Network& network,
               const GeoreferencedNetwork& ground, ArtifactKey* key);

/// Exact digest of a box.
std::string DigestOf(const CropBox& box);

/// "pairs/S2__S1/full": where an attempt is stored; "pairs/S2__S1/full_without_scanner" where the
/// scanner of one was forgotten, so that what came before stays there too.
std::string PairArtifactName(const Station& source, const Station& target, std::string_view method);
std::string StationArtifactName(const std::string& station);
/// "scans/S1.ptx-1f2e3d4c": of a file, by its name for people and its path for the program.
std::string FileArtifactName(std::string_view folder, const std::string& path);
inline constexpr const char* kRankingName = "network/ranking";
inline constexpr const char* kScannersName = "network/scanners";
inline constexpr const char* kNetworkName = "network/network";
inline constexpr const char* kMovingName = "network/moving";

/// Digest of motions, exact.
std::string DigestOf(const std::vector<RigidTransform>& motions);

}  // namespace backsight

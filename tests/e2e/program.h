#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/point_chunk.h"
#include "core/rigid_transform.h"

namespace backsight {

/// How the program ended.
struct ProgramRun {
  int exit_code = -1;
  std::string out;  ///< stdout
  std::string err;  ///< stderr
};

/// Runs `backsight ARGUMENTS` through the shell.
ProgramRun RunProgram(const std::string& arguments);

/// A folder that lives as long as the object.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

std::string ReadBytes(const std::string& path);
void WriteBytes(const std::string& path, const std::string& bytes);

/// The folder of the real data; none where it is absent.
std::optional<std::string> DataFolder();

/// Project file text with one scan per station id.
std::string ProjectText(const std::vector<std::pair<std::string, std::string>>& stations,
                        const std::string& more);

/// All points of a scan.
PointChunk ReadAllPoints(const std::string& path);
/// Writes the points, moved by `moved_from_scan`, as PLY.
void WriteMovedPly(const PointChunk& points, const RigidTransform& moved_from_scan,
                   const std::string& path);

/// Errors of relative poses against truth over all pairs of stations.
struct PairErrors {
  int pairs = 0;  ///< placed pairs
  double mean_re_deg = 0.0, mean_te_m = 0.0, max_re_deg = 0.0, max_te_m = 0.0;
};
PairErrors CompareNetworks(const std::map<std::string, RigidTransform>& estimate,
                           const std::map<std::string, RigidTransform>& truth);

/// Coarse and fine transforms of the accepted links in links.csv against truth.
struct LinkErrors {
  PairErrors coarse, fine;
};
LinkErrors CompareLinks(const std::string& links_csv,
                        const std::map<std::string, RigidTransform>& truth);

/// "name: 21 pairs, RE 0.031 deg, TE 0.76 cm, max TE 1.8 cm", for docs/benchmarks.md.
void PrintErrors(const std::string& name, const PairErrors& errors);

double RotationErrorDeg(const RigidTransform& estimate, const RigidTransform& truth);

}  // namespace backsight

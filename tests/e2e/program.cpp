#include "tests/e2e/program.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>

#include "io/cloud_writer.h"
#include "io/scan_reader.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

class ErrorSum {
 public:
  void Add(const RigidTransform& estimate, const RigidTransform& truth) {
    const double re = RotationErrorDeg(estimate, truth);
    const double te = (estimate.translation - truth.translation).norm();
    ++sum_.pairs;
    sum_.mean_re_deg += re;
    sum_.mean_te_m += te;
    sum_.max_re_deg = std::max(sum_.max_re_deg, re);
    sum_.max_te_m = std::max(sum_.max_te_m, te);
  }
  PairErrors Finish() const {
    PairErrors errors = sum_;
    if (errors.pairs > 0) errors.mean_re_deg /= errors.pairs, errors.mean_te_m /= errors.pairs;
    return errors;
  }

 private:
  PairErrors sum_;
};

}  // namespace

ProgramRun RunProgram(const std::string& arguments) {
  const ScratchFolder folder;
  const std::string command = fmt::format("'{}' {} >'{}' 2>'{}' </dev/null", BACKSIGHT_PROGRAM,
                                          arguments, folder / "out", folder / "err");
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadBytes(folder / "out"),
          ReadBytes(folder / "err")};
}

ScratchFolder::ScratchFolder() {
  std::string name =
      (fs::temp_directory_path() / ("backsight-e2e-" + std::string(6, 'X'))).string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

void WriteBytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::optional<std::string> DataFolder() {
  const char* variable = std::getenv("BACKSIGHT_DATA");
  const fs::path folder = variable != nullptr ? variable : "../shared/data";
  if (!fs::is_directory(folder)) return std::nullopt;
  return fs::absolute(folder).string();
}

std::string ProjectText(const std::vector<std::pair<std::string, std::string>>& stations,
                        const std::string& more) {
  std::string text = "schema_version: 1\nname: test\nstations:\n";
  for (const auto& [id, scan] : stations)
    text += fmt::format("  - {{id: {}, scan: {}}}\n", id, scan);
  return text + more;
}

PointChunk ReadAllPoints(const std::string& path) {
  const auto reader = OpenScan(path);
  PointChunk all, chunk;
  while (reader->Next(chunk)) {
    all.x.insert(all.x.end(), chunk.x.begin(), chunk.x.end());
    all.y.insert(all.y.end(), chunk.y.begin(), chunk.y.end());
    all.z.insert(all.z.end(), chunk.z.begin(), chunk.z.end());
  }
  return all;
}

void WriteMovedPly(const PointChunk& points, const RigidTransform& moved_from_scan,
                   const std::string& path) {
  PointChunk moved = points;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Eigen::Vector3d p =
        moved_from_scan * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]);
    moved.x[i] = p.x(), moved.y[i] = p.y(), moved.z[i] = p.z();
  }
  CloudWriterSpec spec;
  spec.path = path;
  const auto writer = CreatePlyWriter(spec);
  writer->Write(moved, 1);
  writer->Finish();
}

double RotationErrorDeg(const RigidTransform& estimate, const RigidTransform& truth) {
  return RotationAngle(estimate.rotation, truth.rotation) * 180.0 / std::numbers::pi;
}

PairErrors CompareNetworks(const std::map<std::string, RigidTransform>& estimate,
                           const std::map<std::string, RigidTransform>& truth) {
  ErrorSum sum;
  for (auto a = estimate.begin(); a != estimate.end(); ++a) {
    for (auto b = std::next(a); b != estimate.end(); ++b) {
      sum.Add(b->second.Inverse() * a->second, truth.at(b->first).Inverse() * truth.at(a->first));
    }
  }
  return sum.Finish();
}

LinkErrors CompareLinks(const std::string& links_csv,
                        const std::map<std::string, RigidTransform>& truth) {
  ErrorSum coarse, fine;
  std::istringstream lines(ReadBytes(links_csv));
  std::string line;
  std::getline(lines, line);  // source,target,status,reason, 7 of fine, 7 of coarse, ...
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (cells[2] != "accepted") continue;
    const auto pose = [&](std::size_t at) {
      const auto number = [&](std::size_t i) { return std::stod(cells[at + i]); };
      return RigidTransform::FromQuaternion(
          Eigen::Quaterniond(number(3), number(4), number(5), number(6)),
          {number(0), number(1), number(2)});
    };
    const RigidTransform expected = truth.at(cells[1]).Inverse() * truth.at(cells[0]);
    fine.Add(pose(4), expected);
    coarse.Add(pose(11), expected);
  }
  return {coarse.Finish(), fine.Finish()};
}

void PrintErrors(const std::string& name, const PairErrors& errors) {
  fmt::print("{}: {} pairs, mean RE {:.5f} deg, mean TE {:.4f} cm, max TE {:.4f} cm\n", name,
             errors.pairs, errors.mean_re_deg, 100.0 * errors.mean_te_m, 100.0 * errors.max_te_m);
}

}  // namespace backsight

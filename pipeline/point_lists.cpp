#include "pipeline/point_lists.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <vector>

#include "core/error.h"

namespace backsight {
namespace {

bool IsSeparator(char c) { return c == ' ' || c == '\t' || c == ',' || c == '\r'; }

/// The numbers of one line; throws InputError unless there are exactly `columns` finite ones.
std::vector<double> ParseRow(const std::string& line, std::size_t columns,
                             const std::string& where) {
  std::vector<double> row;
  const char* at = line.data();
  const char* end = line.data() + line.size();
  while (true) {
    while (at != end && IsSeparator(*at)) ++at;
    if (at == end) break;
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value) || (next != end && !IsSeparator(*next))) {
      throw InputError({where, fmt::format("\"{}\" is not a finite number", std::string(at, end)),
                        fmt::format("{} numbers", columns), ""});
    }
    row.push_back(value);
    at = next;
  }
  if (row.size() != columns) {
    throw InputError(
        {where, fmt::format("{} numbers", row.size()), fmt::format("{} numbers", columns), ""});
  }
  return row;
}

std::vector<std::vector<double>> ReadRows(const std::string& path, std::size_t columns) {
  std::ifstream file(path);
  if (!file) throw InputError({path, "cannot be opened", "a readable text file", ""});
  std::vector<std::vector<double>> rows;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    rows.push_back(ParseRow(line, columns, fmt::format("{}:{}", path, number)));
  }
  if (rows.size() < 3) {
    throw InputError({path, fmt::format("{} rows", rows.size()), "at least 3 rows of points", ""});
  }
  return rows;
}

/// Numbers distinct points in the order of their first appearance.
class KeypointIds {
 public:
  std::uint32_t Of(const Eigen::Vector3d& p) {
    return ids_.try_emplace({p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(ids_.size()))
        .first->second;
  }

 private:
  std::map<std::array<double, 3>, std::uint32_t> ids_;
};

Eigen::Vector3d PointAt(const std::vector<double>& row, std::size_t column) {
  return {row[column], row[column + 1], row[column + 2]};
}

}  // namespace

Correspondences ReadCorrespondences(const std::string& path) {
  Correspondences c;
  KeypointIds source_ids, target_ids;
  for (const std::vector<double>& row : ReadRows(path, 6)) {
    const Eigen::Vector3d source = PointAt(row, 0);
    const Eigen::Vector3d target = PointAt(row, 3);
    c.Add(source, target, source_ids.Of(source), target_ids.Of(target));
  }
  return c;
}

Correspondences ReadMatchedPoints(const std::string& source_path, const std::string& target_path) {
  const auto source = ReadRows(source_path, 3);
  const auto target = ReadRows(target_path, 3);
  if (source.size() != target.size()) {
    throw InputError(
        {target_path,
         fmt::format("{} rows, but {} has {}", target.size(), source_path, source.size()),
         "equally many rows, row i matching row i", ""});
  }
  Correspondences c;
  KeypointIds source_ids, target_ids;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d q = PointAt(source[i], 0);
    const Eigen::Vector3d p = PointAt(target[i], 0);
    c.Add(q, p, source_ids.Of(q), target_ids.Of(p));
  }
  return c;
}

}  // namespace backsight

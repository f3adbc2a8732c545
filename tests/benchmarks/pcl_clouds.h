#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/point_chunk.h"

namespace backsight {

/// Writes coordinates and intensity as float with PCL's binary writers.
void WritePclPcd(const std::string& path, const std::vector<PointChunk>& chunks);
void WritePclPly(const std::string& path, const std::vector<PointChunk>& chunks);

/// Reads such a file with PCL into a cloud of its PointXYZI; returns the number of points.
std::size_t ReadPclPcd(const std::string& path);
std::size_t ReadPclPly(const std::string& path);

}  // namespace backsight

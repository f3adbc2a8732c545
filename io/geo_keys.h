#pragma once

#include <string>
#include <string_view>

namespace backsight {

/// The GeoTIFF keys (OGC 19-008r4, section 7) of a scan in words: "GeoTIFF: projected EPSG:25832,
/// vertical EPSG:7837". Units are named where they are not metres, and "geographic" where x and y
/// are angles. `directory` holds the bytes of the key directory, little endian, `text` the ASCII
/// parameters; entries that lie outside are left out. Empty if nothing is stated.
std::string DescribeGeoKeys(std::string_view directory, std::string_view text);

}  // namespace backsight

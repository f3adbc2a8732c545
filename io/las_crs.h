#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/byte_source.h"

namespace backsight {

struct LasHeader;

/// Owner and number of the record that holds a reference system as OGC WKT (LAS 1.4 R15, section
/// 3); GeoTIFF keys are in records 34735 to 34737 of the same owner.
inline constexpr std::string_view kLasProjectionUser = "LASF_Projection";
inline constexpr std::uint16_t kLasWktRecord = 2112;

/// Bytes before the contents of a variable length record (section 2.5), of an extended one (2.7).
inline constexpr std::size_t kLasRecordHeaderBytes = 54;
inline constexpr std::size_t kLasExtendedHeaderBytes = 60;

/// The reference system that the records of a LAS file state: the WKT or, where the global encoding
/// does not ask for WKT, the GeoTIFF keys in words. Steps over all other records; where one runs
/// out of its place, it and those behind it are left out with a note. `header` as far as
/// ReadLasHeader has come before; empty: none is stated.
std::string ReadLasCrs(ByteSource& source, const LasHeader& header,
                       std::vector<std::string>& notes);

/// What the user must know where the lengths of `crs` (as ReadLasCrs gives it) are not metres.
std::vector<std::string> CrsUnitNotes(std::string_view crs);

/// `text` up to its first NUL, with '?' for bytes that are no UTF-8 text.
std::string CleanCrsText(std::string_view text);

/// The variable length record (header and contents) that holds `wkt`, at most 65534 bytes.
std::string EncodeWktRecord(std::string_view wkt);

}  // namespace backsight

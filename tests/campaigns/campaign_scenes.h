#pragma once

#include <cstdint>
#include <string>

#include "io/scene_description.h"

namespace backsight {

/// Scenes that decide whether a network can be trusted. Sizes, places and headings are drawn from
/// the seed; equal seeds give equal scenes. All scanners are levelled with any heading.

/// A street between two rows of equal houses whose facades repeat, 12 stations. Parked cars, trees,
/// lamps and what stands on the pavement tell one place from the next.
Scene RepeatedStreet(std::uint64_t seed);

/// A hall that looks the same turned by 180 degrees, 6 stations. Machines, tables and shelves tell
/// its ends apart; without furniture nothing does.
Scene SymmetricHall(std::uint64_t seed, bool furnished);

/// A stand of trees on uneven ground, 8 stations; no plane larger than the ground's facets.
Scene Forest(std::uint64_t seed);

/// Two halls of the same make, 4 stations each, out of sight of each other.
Scene TwoBuildings(std::uint64_t seed);

/// A corridor around a core with a station in each corner and one every 12 m between, 10 in all.
/// Partitions hide most of what the next station sees.
Scene RingCorridor(std::uint64_t seed);

/// The same with stations at equal distances, so that those on both sides of a corner share about a
/// tenth of what they see.
Scene HiddenCorners(std::uint64_t seed);

/// A level field with a few poles, cars and shrubs, 6 stations so far apart that pairs share little
/// besides the ground, which fits anywhere.
Scene OpenField(std::uint64_t seed);

/// A scene file with another seed, its stations moved by up to half a metre.
Scene Reseeded(const std::string& scene_file, std::uint64_t seed);

}  // namespace backsight

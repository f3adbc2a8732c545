#pragma once

#include <cstddef>
#include <string>

#include "io/survey_project.h"

namespace backsight {

/// Where a merged cloud of a component (from 0) goes: `path` itself for the first, otherwise
/// NAME_component2.las and so on.
std::string ComponentPath(const std::string& path, int component);

/// Where part `number` (from 1) of a cloud goes that is split: NAME-1.las.
std::string PartPath(const std::string& path, std::size_t number);

/// From the root, without "." and "..", whether or not there is such a file.
std::string AbsolutePath(const std::string& path);

/// A name for a file that is the same however its folder is written ("a/../b", links).
std::string FileKey(const std::string& path);

/// How many components of two or more stations a network can have.
int MostComponents(std::size_t stations);

/// True if `output`, a merged cloud of a network of at most `components` components, may be written
/// to `file`: its path, the ComponentPath of these, and the PartPath of all where max_points > 0.
bool MayWrite(const CloudOutput& output, int components, const std::string& file);

/// True if two merged clouds may be written to the same file.
bool MayCollide(const CloudOutput& a, const CloudOutput& b, int components);

}  // namespace backsight

#include "pipeline/report_paths.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <vector>

#include "io/output_names.h"

namespace backsight {
namespace {

namespace fs = std::filesystem;

/// The folder of a project, and the ways to spell it that paths in messages begin with.
class ProjectFolder {
 public:
  explicit ProjectFolder(const std::string& project_path)
      : folder_(fs::path(AbsolutePath(project_path)).parent_path()) {
    const fs::path given = fs::path(project_path).parent_path();
    for (const fs::path& spelling : {folder_, given, given.lexically_normal()}) {
      if (!spelling.empty() && spelling != ".") spellings_.push_back((spelling / "").string());
    }
    // "a/b/" before "b/": the longest that fits.
    std::sort(spellings_.begin(), spellings_.end(),
              [](const auto& a, const auto& b) { return a.size() > b.size(); });
  }

  std::string Path(const std::string& path) const {
    const fs::path absolute = AbsolutePath(path);
    const fs::path relative = absolute.lexically_relative(folder_);
    const bool under = !relative.empty() && *relative.begin() != "..";
    return (under ? relative : absolute).string();
  }

  /// Takes the folder off every path in a text that begins with it.
  std::string Text(const std::string& text) const {
    std::string result;
    for (std::size_t i = 0; i < text.size();) {
      const std::size_t skipped = StartsWord(text, i) ? SpellingAt(text, i) : 0;
      i += skipped;
      if (skipped == 0) result += text[i++];
    }
    return result;
  }

 private:
  static bool StartsWord(const std::string& text, std::size_t i) {
    return i == 0 || std::string_view(" '\"(\n\t").find(text[i - 1]) != std::string_view::npos;
  }
  std::size_t SpellingAt(const std::string& text, std::size_t i) const {
    for (const std::string& spelling : spellings_) {
      if (text.compare(i, spelling.size(), spelling) == 0) return spelling.size();
    }
    return 0;
  }

  fs::path folder_;
  std::vector<std::string> spellings_;
};

}  // namespace

RunRecord WithProjectPaths(RunRecord run, const std::string& project_path) {
  const ProjectFolder folder(project_path);
  for (ScanRecord& scan : run.scans) {
    scan.path = folder.Path(scan.path);
    for (std::string& note : scan.notes) note = folder.Text(note);
  }
  for (OutputRecord& output : run.outputs) output.path = folder.Path(output.path);
  for (PoseRecord& pose : run.poses) pose.reason = folder.Text(pose.reason);
  for (LinkRecord& link : run.links) link.reason = folder.Text(link.reason);
  for (std::string& warning : run.warnings) warning = folder.Text(warning);
  return run;
}

}  // namespace backsight

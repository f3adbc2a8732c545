#include "pipeline/unlinked_stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "io/html_table.h"
#include "io/link_reasons.h"
#include "pipeline/name_list.h"

namespace backsight {
namespace {

using Members = std::set<std::string>;

/// Whether the link would join one of them with another station.
bool LeadsOut(const LinkRecord& link, const Members& members) {
  return members.contains(link.source) != members.contains(link.target);
}

/// "3 ambiguous (several placements fit alike, ...), 1 low overlap (...)": the most frequent ones.
std::string CountReasons(const std::vector<std::string>& reasons) {
  constexpr std::size_t kNamed = 3;
  std::map<std::string, int> count;
  for (const std::string& reason : reasons) ++count[reason];
  std::vector<std::pair<std::string, int>> frequent(count.begin(), count.end());
  std::stable_sort(frequent.begin(), frequent.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (std::size_t r = 0; r < std::min(kNamed, frequent.size()); ++r) {
    const auto& [reason, pairs] = frequent[r];
    const std::string_view meaning = MeaningOfReason(reason);
    text += fmt::format("{}{} {}{}", r == 0 ? "" : ", ", pairs, CodeWords(reason),
                        meaning.empty() ? "" : fmt::format(" ({})", meaning));
  }
  return text + (frequent.size() > kNamed ? " and other reasons" : "");
}

/// What became of all pairs that lead out: of those that were tried, or else why none was.
std::string DescribePairs(const std::vector<LinkRecord>& links, const Members& members) {
  std::vector<std::string> tried, skipped;
  for (const LinkRecord& link : links) {
    if (!LeadsOut(link, members)) continue;
    if (link.status == LinkStatus::kSkipped) {
      skipped.push_back(link.reason);
    } else {
      tried.push_back(link.status == LinkStatus::kFailed ? "failed" : link.reason);
    }
  }
  const char* const whose = members.size() == 1 ? "its pairs" : "the pairs that lead out";
  if (!tried.empty()) {
    return fmt::format("; of {} pair(s) that were tried: {}", tried.size(), CountReasons(tried));
  }
  return fmt::format("; none of {} was tried{}", whose,
                     skipped.empty() ? "" : ": " + CountReasons(skipped));
}

/// Neither used nor refuted: by itself, or because the network could have it in several places.
bool IsUndecided(const LinkRecord& link) {
  return link.status == LinkStatus::kDoubtful || link.reason == "ambiguous";
}

/// "; 11 pair(s) doubtful or ambiguous, the least seen through first: S9 - S8 (far from start,
/// 0.4 %), ..." with what could decide. Empty where there is none.
std::string DescribeUndecided(const std::vector<LinkRecord>& links, const Members& members) {
  std::vector<const LinkRecord*> undecided;
  bool untried = false;
  for (const LinkRecord& link : links) {
    if (!LeadsOut(link, members)) continue;
    untried |= link.status == LinkStatus::kSkipped && link.reason != "unusable_station";
    if (IsUndecided(link)) undecided.push_back(&link);
  }
  if (undecided.empty()) return "";
  std::stable_sort(undecided.begin(), undecided.end(),
                   [](const auto* a, const auto* b) { return a->conflict < b->conflict; });
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> names;
  names.reserve(undecided.size());
  for (const LinkRecord* link : undecided) {
    names.push_back(fmt::format("{} - {} ({}, {:.1f} %)", link->source, link->target,
                                link->reason.empty() ? "unconfirmed" : CodeWords(link->reason),
                                100.0 * link->conflict));
  }
  return fmt::format(
      "; {} pair(s) doubtful or ambiguous, the least seen through first: {}; no loop of other "
      "links decides; a further station that overlaps with both sides could{}",
      names.size(), FirstNames(names, kNamed),
      untried ? ", or pairs that were not tried (pairs: include)" : "");
}

}  // namespace

std::string DescribeGap(const std::vector<LinkRecord>& links, const Members& members) {
  return DescribeUndecided(links, members) + DescribePairs(links, members);
}

std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station) {
  return "no accepted link to any other station" + DescribeGap(links, {station});
}

}  // namespace backsight

#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "io/scratch_file.h"

namespace backsight {

/// Records of a scratch file that lie one after another, sorted.
struct SortedRun {
  std::uint64_t offset = 0;  ///< bytes
  std::uint64_t records = 0;
};

/// Merges sorted runs of one file, of equal groups the first record only.
template <typename Record, typename GroupOf>
class RunMerger {
 public:
  /// Holds `block_records` of each run. `file` must outlive the merger.
  RunMerger(const ScratchFile& file, std::span<const SortedRun> runs, std::size_t block_records)
      : file_(&file), block_records_(block_records) {
    for (const SortedRun& run : runs) inputs_.push_back({run, {}, 0});
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      Record record;
      if (Take(&inputs_[i], &record)) heads_.push_back({record, i});
    }
    std::make_heap(heads_.begin(), heads_.end(), Later);
  }

  /// The next group's first record; false at the end.
  bool Next(Record* record) {
    while (!heads_.empty()) {
      const Record first = PopFirst();
      const bool is_new = !any_ || GroupOf()(first) != GroupOf()(last_);
      any_ = true;
      last_ = first;
      if (!is_new) continue;
      *record = first;
      return true;
    }
    return false;
  }

 private:
  struct Input {
    SortedRun rest;
    std::vector<Record> block;
    std::size_t at = 0;
  };
  struct Head {
    Record record;
    std::size_t input;
  };
  static bool Later(const Head& a, const Head& b) { return b.record < a.record; }

  Record PopFirst() {
    std::pop_heap(heads_.begin(), heads_.end(), Later);
    Head& head = heads_.back();
    const Record first = head.record;
    if (Take(&inputs_[head.input], &head.record)) {
      std::push_heap(heads_.begin(), heads_.end(), Later);
    } else {
      heads_.pop_back();
    }
    return first;
  }

  bool Take(Input* input, Record* record) {
    if (input->at == input->block.size() && !Refill(input)) return false;
    *record = input->block[input->at++];
    return true;
  }

  bool Refill(Input* input) {
    const std::uint64_t records = std::min<std::uint64_t>(block_records_, input->rest.records);
    if (records == 0) return false;
    input->block.resize(records);
    const std::uint64_t bytes = records * sizeof(Record);
    file_->Read(input->rest.offset, {reinterpret_cast<char*>(input->block.data()), bytes});
    input->rest.offset += bytes;
    input->rest.records -= records;
    input->at = 0;
    return true;
  }

  const ScratchFile* file_;
  std::size_t block_records_;
  std::vector<Input> inputs_;
  std::vector<Head> heads_;  // heap, the least record first
  Record last_{};
  bool any_ = false;
};

/// Sorts any number of records within bounded memory and gives of each group the least one. What
/// does not fit goes as sorted runs to scratch files and is merged from there, in several rounds if
/// there are very many. Records compare by <; those of equal GroupOf()(record) must be neighbours
/// in that order. The result does not depend on the order of Add or on the memory. O(n log n) time;
/// on disk up to twice the bytes of the records. Throws InputError where ScratchFile does.
template <typename Record, typename GroupOf>
class ExternalSorter {
  static_assert(std::is_trivially_copyable_v<Record>);

 public:
  /// Keeps `memory_bytes` up to Finish, and half of it from then on. Scratch files lie in the
  /// folder of `path`; none is made for what fits the memory.
  ExternalSorter(std::string path, std::size_t memory_bytes)
      : path_(std::move(path)),
        capacity_(std::max<std::size_t>(memory_bytes / sizeof(Record), 2)),
        block_records_(
            std::clamp<std::size_t>(kBlockBytes / sizeof(Record), 1, (capacity_ + 3) / 4)),
        most_runs_(std::clamp<std::size_t>(capacity_ / block_records_ / 2, 2, kMostRuns)) {}

  void Add(const Record& record) {
    if (buffer_.size() == capacity_) MakeRoom();
    if (buffer_.empty()) buffer_.reserve(capacity_);
    buffer_.push_back(record);
  }

  /// Ends the input. `between`, called while much is merged, may throw to give up.
  void Finish(const std::function<void()>& between = {}) {
    SortBuffer();
    if (runs_.empty()) return;
    Spill();
    std::vector<Record>().swap(buffer_);
    while (runs_.size() > most_runs_) MergeOnce(between);
    merger_ = std::make_unique<Merger>(*file_, runs_, block_records_);
  }

  /// After Finish: the next group's least record, in ascending order; false at the end.
  bool Next(Record* record) {
    if (merger_) return merger_->Next(record);
    if (next_ == buffer_.size()) return false;
    *record = buffer_[next_++];
    return true;
  }

  /// Runs put on the disk so far.
  std::size_t runs() const { return runs_.size(); }

 private:
  using Merger = RunMerger<Record, GroupOf>;
  static constexpr std::size_t kBlockBytes = std::size_t{64} << 10U;
  static constexpr std::size_t kMostRuns = 256;

  void SortBuffer() {
    std::sort(buffer_.begin(), buffer_.end());
    const auto same = [](const Record& a, const Record& b) { return GroupOf()(a) == GroupOf()(b); };
    buffer_.erase(std::unique(buffer_.begin(), buffer_.end(), same), buffer_.end());
  }

  /// Where few groups hold most of the records, the buffer has room again without the disk.
  void MakeRoom() {
    SortBuffer();
    if (buffer_.size() > capacity_ / 2) Spill();
  }

  void Spill() {
    if (!file_) file_ = std::make_unique<ScratchFile>(path_);
    runs_.push_back({file_->size(), buffer_.size()});
    AppendTo(file_.get(), buffer_);
    buffer_.clear();
  }

  static void AppendTo(ScratchFile* file, const std::vector<Record>& records) {
    file->Append({reinterpret_cast<const char*>(records.data()), records.size() * sizeof(Record)});
  }

  /// Makes one run out of every `most_runs_`.
  void MergeOnce(const std::function<void()>& between) {
    auto merged = std::make_unique<ScratchFile>(path_);
    std::vector<SortedRun> merged_runs;
    for (std::size_t first = 0; first < runs_.size(); first += most_runs_) {
      const std::size_t count = std::min(most_runs_, runs_.size() - first);
      Merger merger(*file_, std::span(runs_).subspan(first, count), block_records_);
      merged_runs.push_back({merged->size(), 0});
      std::vector<Record> block;
      block.reserve(block_records_);
      for (Record record; merger.Next(&record);) {
        block.push_back(record);
        ++merged_runs.back().records;
        if (block.size() < block_records_) continue;
        if (between) between();
        AppendTo(merged.get(), block);
        block.clear();
      }
      AppendTo(merged.get(), block);
    }
    file_ = std::move(merged);
    runs_ = std::move(merged_runs);
  }

  std::string path_;
  std::size_t capacity_;
  std::size_t block_records_;
  std::size_t most_runs_;
  std::vector<Record> buffer_;
  std::size_t next_ = 0;
  std::unique_ptr<ScratchFile> file_;
  std::vector<SortedRun> runs_;
  std::unique_ptr<Merger> merger_;
};

}  // namespace backsight

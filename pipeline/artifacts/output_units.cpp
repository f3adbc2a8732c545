#include "pipeline/artifacts/output_units.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "io/output_names.h"
#include "pipeline/artifacts/artifact_keys.h"
#include "pipeline/artifacts/load_artifact.h"
#include "pipeline/output_files.h"

namespace backsight {

template <class Archive>
void Transfer(Archive& archive, OutputRecord& file) {
  archive(file.path, file.format, file.selection, file.points);
}

template <class Archive>
void Transfer(Archive& archive, WrittenCloud& file) {
  archive(file.bytes, file.modified);
}

template <class Archive>
void Transfer(Archive& archive, OutputFiles& output) {
  archive(output.files, output.warnings);
}

namespace {

namespace fs = std::filesystem;

/// An output and its files as they lay there when it was written.
struct Receipt {
  OutputFiles output;
  std::vector<WrittenCloud> files;  ///< without their paths
};

template <class Archive>
void Transfer(Archive& archive, Receipt& receipt) {
  archive(receipt.output, receipt.files);
}

/// The files as they lie there now; fewer than `files` where one cannot be looked at.
std::vector<WrittenCloud> Describe(const std::vector<OutputRecord>& files) {
  std::vector<WrittenCloud> described;
  for (const OutputRecord& file : files) {
    if (const auto now = DescribeFile(file.path)) described.push_back(*now);
  }
  return described;
}

bool LiesThere(const Receipt& receipt) {
  const std::vector<WrittenCloud> now = Describe(receipt.output.files);
  return std::equal(now.begin(), now.end(), receipt.files.begin(), receipt.files.end(),
                    [](const WrittenCloud& a, const WrittenCloud& b) {
                      return a.bytes == b.bytes && a.modified == b.modified;
                    });
}

/// All files of an output lie in one folder, which the working directory may name differently.
void MoveTo(const std::string& path, std::vector<OutputRecord>* files) {
  for (OutputRecord& file : *files) {
    file.path = (fs::path(path).parent_path() / fs::path(file.path).filename()).string();
  }
}

std::optional<Receipt> LoadReceipt(const ArtifactStore& store, const std::string& name,
                                   const ArtifactKey& key, const std::string& path) {
  return LoadArtifact(store, name, key, [&](std::string_view bytes) {
    auto receipt = FromBytes<Receipt>(bytes);
    MoveTo(path, &receipt.output.files);
    return receipt;
  });
}

}  // namespace

std::string OutputArtifactName(const std::string& path) {
  return FileArtifactName("outputs", AbsolutePath(path));
}

bool LiesAsWritten(const ArtifactStore& store, const std::string& path) {
  const std::string name = OutputArtifactName(path);
  const ArtifactKey stored = ArtifactKey::OfText(store.Look(name, {}).key_text);
  const std::optional<Receipt> receipt = LoadReceipt(store, name, stored, path);
  return receipt && LiesThere(*receipt);
}

OutputFiles WriteOnce(const ArtifactStore& store, const std::string& path, ArtifactKey key,
                      const ExecutionContext& context, const std::function<OutputFiles()>& write) {
  if (!store.keeps()) return write();
  key.Add("path", AbsolutePath(path));
  const std::string name = OutputArtifactName(path);
  if (std::optional<Receipt> earlier = LoadReceipt(store, name, key, path)) {
    if (LiesThere(*earlier)) return std::move(earlier->output);
    context.Info(path + " is not as it was written; it is written anew");
  }
  store.Remove(name);  // whatever lies there from now on was not written from the old key
  Receipt receipt;
  receipt.output = write();
  receipt.files = Describe(receipt.output.files);
  store.Store(name, key, ToBytes(receipt));
  return std::move(receipt.output);
}

}  // namespace backsight

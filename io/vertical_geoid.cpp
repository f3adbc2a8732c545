#include "io/vertical_geoid.h"

#include <GeographicLib/Geoid.hpp>
#include <filesystem>
#include <utility>

#include "core/error.h"

namespace backsight {
namespace {

constexpr const char* kExtension = ".pgm";

[[noreturn]] void RefuseFile(const std::string& path, const std::string& why) {
  throw InputError({path, why, "a geoid file of GeographicLib",
                    "install it again, for one with geographiclib-get-geoids"});
}

}  // namespace

struct VerticalGeoid::Model {
  Model(const std::string& name, const std::string& folder) : geoid(name, folder) {}
  GeographicLib::Geoid geoid;
};

VerticalGeoid::VerticalGeoid(const std::string& folder, std::string file_name)
    : file_name_(std::move(file_name)),
      path_((std::filesystem::path(folder) / file_name_).string()) {
  const std::string stem = std::filesystem::path(file_name_).stem().string();
  try {
    model_ = std::make_unique<Model>(stem, folder);
  } catch (const std::exception& error) {
    RefuseFile(path_, error.what());
  }
}

VerticalGeoid::~VerticalGeoid() = default;

std::vector<std::string> VerticalGeoid::FilesFor(const std::string& vertical) {
  std::vector<std::string> names;
  if (vertical == "EPSG:3855") names = {"egm2008-1", "egm2008-2_5", "egm2008-5"};
  if (vertical == "EPSG:5773") names = {"egm96-5", "egm96-15"};
  if (vertical == "EPSG:5798") names = {"egm84-15", "egm84-30"};
  for (std::string& name : names) name += kExtension;
  return names;
}

std::string VerticalGeoid::Folder() { return GeographicLib::Geoid::DefaultGeoidPath(); }

std::unique_ptr<VerticalGeoid> VerticalGeoid::Open(const std::string& vertical) {
  for (const std::string& name : FilesFor(vertical)) {
    std::error_code error;
    if (!std::filesystem::exists(std::filesystem::path(Folder()) / name, error)) continue;
    return std::unique_ptr<VerticalGeoid>(new VerticalGeoid(Folder(), name));
  }
  return nullptr;
}

double VerticalGeoid::HeightAt(double latitude, double longitude) const {
  try {
    return model_->geoid(latitude, longitude);
  } catch (const std::exception& error) {
    RefuseFile(path_, error.what());
  }
}

}  // namespace backsight

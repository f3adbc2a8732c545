#include "io/geodetic_frame.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Eigen::Vector3d kMunich(690000.0, 5336000.0, 520.0);

GeodeticFrame Utm32() {
  GeodeticFrame frame("EPSG:25832", "", "survey.yaml:3");
  frame.SetOrigin(kMunich);
  return frame;
}

std::string Refusal(const std::string& horizontal, const std::string& vertical) {
  try {
    const GeodeticFrame frame(horizontal, vertical, "survey.yaml:3");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(GeodeticFrame, KnowsWhereItsSystemIsUsed) {
  const auto fault = [](const std::string& name, double easting, double northing) {
    const auto found = GeodeticFrame(name, "", "survey.yaml:3").FaultOf({easting, northing, 520.0});
    return found ? found->found + "; " + found->expected + "; " + found->remedy : std::string();
  };
  EXPECT_EQ(fault("EPSG:25832", 690000.0, 5336000.0), "");
  // Two degrees beyond the zone, where surveys still use it.
  EXPECT_EQ(fault("EPSG:25832", 870000.0, 5336000.0), "");
  EXPECT_EQ(fault("EPSG:31468", 4468000.0, 5336000.0), "");
  const std::string swapped = fault("EPSG:25832", 5336000.0, 690000.0);
  EXPECT_THAT(swapped, HasSubstr("easting 5336000.000, northing 690000.000"));
  EXPECT_THAT(swapped, HasSubstr("longitude 6.0 to 12.0"));
  EXPECT_THAT(swapped, HasSubstr("easting and northing swapped?"));
  const std::string unprefixed = fault("EPSG:31468", 690000.0, 5336000.0);
  EXPECT_THAT(unprefixed, HasSubstr("which is latitude"));
  EXPECT_THAT(unprefixed, HasSubstr("prefix of its zone"));
  EXPECT_THAT(unprefixed, Not(HasSubstr("swapped")));
  // Across the antimeridian: NZGD2000 / Chatham Islands TM 2000.
  EXPECT_EQ(fault("EPSG:3793", 3500000.0, 5100000.0), "");
  EXPECT_NE(fault("EPSG:3793", 100000.0, 100000.0), "");
}

TEST(GeodeticFrame, RoundTripsMoveNothing) {
  const GeodeticFrame frame = Utm32();
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const double east = random.Uniform(-3000.0, 3000.0);
    const double north = random.Uniform(-3000.0, 3000.0);
    const Eigen::Vector3d crs =
        kMunich + Eigen::Vector3d(east, north, random.Uniform(-300.0, 300.0));
    EXPECT_LT((frame.CrsFromEnu(frame.EnuFromCrs(crs)) - crs).norm(), 1e-5);
  }
}

/// Distances in enu are those between geocentric positions that GeographicLib's own UTM gives.
TEST(GeodeticFrame, IsCartesian) {
  const GeodeticFrame frame = Utm32();
  const auto geocentric = [](const Eigen::Vector3d& crs) {
    double latitude = 0.0;
    double longitude = 0.0;
    GeographicLib::UTMUPS::Reverse(32, true, crs.x(), crs.y(), latitude, longitude);
    Eigen::Vector3d p;
    GeographicLib::Geocentric::WGS84().Forward(latitude, longitude, crs.z(), p.x(), p.y(), p.z());
    return p;
  };
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const auto draw = [&] {
      const double east = random.Uniform(-2000.0, 2000.0);
      const double north = random.Uniform(-2000.0, 2000.0);
      return Eigen::Vector3d(kMunich + Eigen::Vector3d(east, north, random.Uniform(-100.0, 100.0)));
    };
    const Eigen::Vector3d a = draw();
    const Eigen::Vector3d b = draw();
    EXPECT_NEAR((frame.EnuFromCrs(a) - frame.EnuFromCrs(b)).norm(),
                (geocentric(a) - geocentric(b)).norm(), 1e-4);  // GRS80 and WGS84 differ by 0.1 mm
  }
}

TEST(GeodeticFrame, KnowsConvergenceScaleAndAxes) {
  const GeodeticFrame frame = Utm32();
  double latitude = 0.0;
  double longitude = 0.0;
  double convergence = 0.0;
  double scale = 0.0;
  GeographicLib::UTMUPS::Reverse(32, true, kMunich.x(), kMunich.y(), latitude, longitude,
                                 convergence, scale);
  // GeographicLib gives the bearing of grid north, clockwise from true north.
  EXPECT_NEAR(frame.convergence_deg(), convergence, 1e-5);
  EXPECT_NEAR(frame.point_scale(), scale, 2e-7 + 1e-3 * 520.0 / 6.4e6);
  EXPECT_NEAR(frame.origin().x(), latitude, 1e-8);
  EXPECT_NEAR(frame.origin().y(), longitude, 1e-8);
  const Eigen::Matrix3d axes = frame.AxesAt(kMunich);
  EXPECT_NEAR(std::atan2(axes(0, 1), axes(1, 1)) * 180.0 / M_PI, convergence, 1e-5);
  EXPECT_LT((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);
}

TEST(GeodeticFrame, TakesHeightsThroughTheGeoid) {
  GeodeticFrame frame("EPSG:32632", "EPSG:5773", "survey.yaml:3");
  frame.SetOrigin(kMunich);
  // EGM96 lies 45 to 48 m above the ellipsoid in southern Bavaria.
  EXPECT_NEAR(frame.origin().z(), kMunich.z() + 46.5, 1.5);
  EXPECT_THAT(frame.heights(), HasSubstr("egm96"));
  EXPECT_THAT(frame.wkt(), HasSubstr("COMPD_CS"));
  const Eigen::Vector3d there = kMunich + Eigen::Vector3d(300.0, -200.0, 20.0);
  EXPECT_LT((frame.CrsFromEnu(frame.EnuFromCrs(there)) - there).norm(), 1e-5);
}

/// A folder where GeographicLib looks for geoids, for the length of a test.
class GeoidFolder {
 public:
  GeoidFolder() { setenv("GEOGRAPHICLIB_GEOID_PATH", dir_.path().c_str(), 1); }
  ~GeoidFolder() { unsetenv("GEOGRAPHICLIB_GEOID_PATH"); }
  GeoidFolder(const GeoidFolder&) = delete;
  GeoidFolder& operator=(const GeoidFolder&) = delete;

  /// A geoid that is `base` + latitude / 10 metres high, in steps of 22.5 degrees: cubic
  /// interpolation gives it back exactly.
  void Write(const std::string& name, double base, std::size_t bytes = SIZE_MAX) const {
    constexpr double kOffset = -100.0;
    constexpr double kScale = 0.01;
    std::string text = fmt::format(
        "P5\n# Geoid file in PGM format for the GeographicLib::Geoid class\n"
        "# Description made up\n# Offset {}\n# Scale {}\n16 9\n65535\n",
        kOffset, kScale);
    for (int row = 0; row < 9; ++row) {
      const double height = base + (90.0 - 22.5 * row) / 10.0;
      const auto level = static_cast<unsigned>(std::lround((height - kOffset) / kScale));
      for (int column = 0; column < 16; ++column) {
        text += static_cast<char>(level >> 8U);
        text += static_cast<char>(level & 0xFFU);
      }
    }
    dir_.File(name, text.substr(0, bytes));
  }
  std::string path() const { return dir_.path(); }

 private:
  TempDir dir_;
};

TEST(GeodeticFrame, TakesHeightsThroughAGeoidFileWhereNoGridIsInstalled) {
  const GeoidFolder folder;
  folder.Write("egm2008-5.pgm", 40.0);
  GeodeticFrame frame("EPSG:32632", "EPSG:3855", "survey.yaml:3");
  frame.SetOrigin(kMunich);
  EXPECT_NEAR(frame.origin().z(), kMunich.z() + 40.0 + frame.origin().x() / 10.0, 1e-6);
  EXPECT_EQ(frame.heights(), "by egm2008-5.pgm");
  EXPECT_THAT(frame.name(), HasSubstr("EGM2008"));
  EXPECT_THAT(frame.wkt(), HasSubstr("COMPD_CS"));
  const Eigen::Vector3d there = kMunich + Eigen::Vector3d(300.0, -200.0, 20.0);
  EXPECT_LT((frame.CrsFromEnu(frame.EnuFromCrs(there)) - there).norm(), 1e-5);

  // The finest file is taken; a grid of PROJ goes before all of them.
  folder.Write("egm2008-1.pgm", 30.0);
  EXPECT_EQ(GeodeticFrame("EPSG:32632", "EPSG:3855", "").heights(), "by egm2008-1.pgm");
  folder.Write("egm96-5.pgm", 30.0);
  EXPECT_THAT(GeodeticFrame("EPSG:32632", "EPSG:5773", "").heights(), HasSubstr("egm96_15"));
  // A geoid file makes no other datum right.
  EXPECT_THAT(Refusal("EPSG:25832", "EPSG:3855"), HasSubstr("different datums"));
}

TEST(GeodeticFrame, NamesTheFilesThatAreMissingAndWhereTheyGo) {
  const GeoidFolder folder;
  const std::string egm = Refusal("EPSG:32632", "EPSG:3855");
  for (const std::string& part : std::vector<std::string>{
           "survey.yaml:3", "us_nga_egm08", "egm2008-1.pgm or egm2008-2_5.pgm or egm2008-5.pgm",
           "GEOGRAPHICLIB_GEOID_PATH", folder.path(), "/usr/share/proj"}) {
    EXPECT_THAT(egm, HasSubstr(part));
  }
  const std::string german = Refusal("EPSG:25832", "EPSG:7837");
  EXPECT_THAT(german, HasSubstr("GCG2016"));
  EXPECT_THAT(german, HasSubstr("under this very name"));
  EXPECT_THAT(german, HasSubstr("/usr/share/proj"));
  EXPECT_THAT(german, Not(HasSubstr(".pgm")));
}

TEST(GeodeticFrame, RefusesADamagedGeoidFile) {
  const GeoidFolder folder;
  folder.Write("egm2008-5.pgm", 40.0, 200);
  EXPECT_THAT(Refusal("EPSG:32632", "EPSG:3855"), HasSubstr(folder.path() + "/egm2008-5.pgm"));
}

TEST(GeodeticFrame, EastingComesFirstWhateverTheAxesOrder) {
  GeodeticFrame frame("EPSG:31468", "", "survey.yaml:3");  // Gauss-Krueger: northing first
  frame.SetOrigin({4468000.0, 5336000.0, 520.0});
  EXPECT_NEAR(frame.origin().x(), 48.2, 0.1);
  EXPECT_NEAR(frame.EnuFromCrs({4468100.0, 5336000.0, 520.0}).x(), 100.0, 0.1);
}

TEST(GeodeticFrame, RefusesWhatItWouldHaveToGuess) {
  EXPECT_THAT(Refusal("EPSG:99999", ""), HasSubstr("PROJ knows"));
  EXPECT_THAT(Refusal("EPSG:4258", ""), HasSubstr("not projected"));
  EXPECT_THAT(Refusal("EPSG:2263", ""), HasSubstr("US survey foot"));
  EXPECT_THAT(Refusal("EPSG:25832", "EPSG:4258"), HasSubstr("not vertical"));
  EXPECT_THAT(Refusal("EPSG:25832", "EPSG:5773"), HasSubstr("different datums"));
  EXPECT_THAT(Refusal("EPSG:25832", "EPSG:7837"), HasSubstr("GCG2016"));
  EXPECT_THAT(Refusal("EPSG:25832", "EPSG:7837"), HasSubstr("survey.yaml:3"));
  EXPECT_EQ(Refusal("EPSG:25832", ""), "");
  // The Swiss heights lead through ETRS89 and back; only the grid is missing.
  EXPECT_THAT(Refusal("EPSG:2056", "EPSG:5728"), HasSubstr("grid that is not installed"));
}

TEST(GeodeticFrame, RefusesPlacesOutsideTheProjection) {
  GeodeticFrame frame = Utm32();
  EXPECT_THROW(frame.SetOrigin({5336000.0, 690000.0e3, 0.0}), InputError);
  EXPECT_THROW(frame.SetOrigin({HUGE_VAL, 0.0, 0.0}), InputError);
}

}  // namespace
}  // namespace backsight

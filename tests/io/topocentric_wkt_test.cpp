#include "io/topocentric_wkt.h"

#include <gtest/gtest.h>

namespace backsight {
namespace {

TEST(TopocentricWkt, NamesTheSystemAndTheOrigin) {
  EXPECT_EQ(TopocentricWkt("ETRS89 / \"UTM\"", {48.1234567890123, -11.5, 567.89}),
            "ENGCRS[\"Local topocentric frame of ETRS89 / \"\"UTM\"\"\",EDATUM[\"origin at "
            "latitude 48.1234567890 deg, longitude -11.5000000000 deg, ellipsoidal height "
            "567.8900 m\"],CS[Cartesian,3],AXIS[\"east (E)\",east,ORDER[1]],AXIS[\"north "
            "(N)\",north,ORDER[2]],AXIS[\"up (U)\",up,ORDER[3]],LENGTHUNIT[\"metre\",1],"
            "REMARK[\"Cartesian coordinates in the local topocentric frame (east, north, up) at "
            "this origin, on the datum of ETRS89 / \"\"UTM\"\"; not coordinates of ETRS89 / "
            "\"\"UTM\"\"\"]]");
}

}  // namespace
}  // namespace backsight

#include "io/scan_description.h"

#include <gtest/gtest.h>

namespace backsight {
namespace {

TEST(DescribeScan, ListsWhatIsKnown) {
  ScanInfo info;
  info.path = "scans/S1.ptx";
  info.format = "PTX";
  info.scan_index = 1;
  info.scan_count = 3;
  info.point_count = 12;
  info.guid = "{G}";
  info.name = "Hall\x1b";
  info.has_intensity = true;
  info.has_rgb = true;
  info.has_classification = true;
  info.has_gps_time = true;
  info.crs = "PROJCS[\"here\",\n  UNIT[\"metre\",1]]";
  info.rows = 3;
  info.columns = 4;
  info.world_from_scan = RigidTransform{ExpSo3({0.0, 0.0, 0.5235987755982988}), {1.0, 2.0, 3.5}};
  info.notes = {"a note"};
  EXPECT_EQ(DescribeScan(info),
            "file        scans/S1.ptx\n"
            "format      PTX\n"
            "scan_index  1 (of 3)\n"
            "name        'Hall\\x1b'\n"
            "guid        '{G}'\n"
            "points      12 (declared)\n"
            "attributes  x y z, intensity, colour, classification, GPS time\n"
            "grid        3 rows, 4 columns\n"
            "position_m  1.0000 2.0000 3.5000 (stated by the file, not applied)\n"
            "turned_deg  30.0000\n"
            "crs         PROJCS[\"here\", UNIT[\"metre\",1]]\n"
            "note        a note\n");
}

TEST(DescribeScan, SaysWhatIsMissing) {
  ScanInfo info;
  info.path = "a.xyz";
  info.format = "XYZ";
  EXPECT_EQ(DescribeScan(info),
            "file        a.xyz\n"
            "format      XYZ\n"
            "scan_index  0 (of 1)\n"
            "points      not declared by this format\n"
            "attributes  x y z\n"
            "grid        none (unstructured)\n"
            "pose        none\n");
}

}  // namespace
}  // namespace backsight

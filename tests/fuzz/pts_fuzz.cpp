#include "io/pts_reader.h"
#include "tests/fuzz/fuzz_target.h"

namespace backsight {
namespace {

std::vector<std::string> Seeds() {
  const std::string grey = "3\n1 2 3 -2048\n-1.5 2e1 +3 17\n4 5 6 2047\n";
  const std::string color = "2\r\n1 2 3 100 255 0 17\r\n4 5 6 nan 1 2 3\r\n";
  return {grey,
          color,
          grey + color,
          color + "# comment\n\n" + color + "0\n" + grey,
          "x y z r g b i\n" + grey,
          "1\n1;2;3",
          "X,Y,Z\n2\n1,2,3\n4,5,6,\n"};
}

void Read(const std::string& path) {
  ReadScans(path, [](const std::string& file, int scan) { return OpenPts(file, scan); });
}

}  // namespace

FuzzTarget TargetUnderTest() { return {&Read, &Seeds, &AsItIs}; }

}  // namespace backsight

#!/usr/bin/env python3
"""Plants a violation of every source rule to show that it is found, and its neighbour that is fine."""

import unittest

import source_rules

CMAKE = {"io/CMakeLists.txt": b"backsight_library(io\n  SOURCES\n    a.cpp\n    las/b.cpp)\n"}
# Put together here, so that this file keeps the rules itself.
HOME = "/" + "home/me/scan.las"
TO_DO = "TO" + "DO"


class SourceRules(unittest.TestCase):
    def expect(self, path, text, count):
        data = text.encode() if isinstance(text, str) else text
        found = list(source_rules.file_findings(path, data))
        self.assertEqual(len(found), count, found)

    def test_to_dos_name_an_issue(self):
        self.expect("io/a.cpp", f"// {TO_DO}: later\n", 1)
        self.expect("docs/a.md", f"{TO_DO}(me)\n", 1)
        self.expect("io/a.cpp", f"// {TO_DO}(#12): later\n", 0)

    def test_machine_paths(self):
        self.expect("docs/a.md", f"see {HOME}\n", 1)
        self.expect("docs/a.md", "see out/work/S1 and /usr/bin/env\n", 0)

    def test_exit_only_in_main(self):
        for call in ("exit(1);", "std::exit (0);", "::quick_exit(3);"):
            self.expect("stages/a.cpp", f"  {call}\n", 1)
            self.expect("pipeline/main.cpp", f"  {call}\n", 0)
            self.expect("tests/io/a_test.cpp", f"  {call}\n", 0)
        self.expect("stages/a.cpp", 'Say("exit(0)");  // never exit(0)\nOnexit(1); a.exit(2);\n', 0)

    def test_headers_hide_third_parties(self):
        for header in ("pcl/point_types.h", "ceres/ceres.h", "octomap/OcTree.h", "nanoflann.hpp",
                       "yaml-cpp/yaml.h", "nlohmann/json.hpp", "tbb/task_arena.h", "png.h",
                       "embree3/rtcore.h", "spdlog/spdlog.h", "CLI/CLI.hpp", "gtest/gtest.h"):
            self.expect("io/a.h", f"#pragma once\n#include <{header}>\n", 1)
            self.expect("io/a.cpp", f"#include <{header}>\n", 0)
        self.expect("io/a.h", "#pragma once\n#include <vector>\n#include <Eigen/Core>\n", 0)
        self.expect("tests/io/a.h", "#pragma once\n#include <gtest/gtest.h>\n", 0)

    def test_headers_are_read_once(self):
        self.expect("io/a.h", "#include <vector>\n", 1)

    def test_length_and_size(self):
        self.expect("io/a.cpp", "\n" * 451, 1)
        self.expect("io/a.cpp", "\n" * 450, 0)
        self.expect("docs/a.png", b"\0" * 1_000_001, 1)
        self.expect("docs/a.png", b"\0" * 1_000_000, 0)

    def test_every_source_is_built(self):
        built = {**CMAKE, "io/a.cpp": b"", "io/las/b.cpp": b""}
        self.assertEqual(list(source_rules.findings(built)), [])
        unbuilt = list(source_rules.findings({**built, "io/las/a.cpp": b"", "io/c.cpp": b""}))
        self.assertEqual([path for path, _, _ in unbuilt], ["io/c.cpp", "io/las/a.cpp"])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Sources that are read as one: which may be, and that a fault in any of them is found."""

import json
import pathlib
import tempfile
import unittest

import clang_tidy

CLEAN = "namespace backsight {\nnamespace {\nint %s() { return 1; }\n}  // namespace\n" \
        "int Call%s() { return %s(); }\n}  // namespace backsight\n"
FAULT = "namespace backsight {\ndouble HalfOf(int n) { return n / 2; }\n}  // namespace backsight\n"


class ClangTidy(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="backsight-tidy-test-")
        self.addCleanup(self.scratch.cleanup)
        self.folder = pathlib.Path(self.scratch.name) / "core"
        self.folder.mkdir()

    def entry(self, name, text, options=""):
        path = self.folder / f"{name}.cpp"
        path.write_text(text)
        command = f"c++ -std=c++20{options} -MD -MT {name}.o -MF {name}.d -o {name}.o -c {path}"
        return {"directory": str(self.folder), "command": command, "file": str(path)}

    def clean(self, name, internal, options=""):
        return self.entry(name, CLEAN % (internal, name, internal), options)

    def names(self, groups):
        return sorted(sorted(pathlib.Path(entry["file"]).stem for entry in group)
                      for group in groups)

    def run_tidy(self, *entries):
        (self.folder / "compile_commands.json").write_text(json.dumps(entries))
        return clang_tidy.run(list(entries), self.folder, self.scratch.name)

    def test_internal_names(self):
        text = ("int Public();\nnamespace {\n\nconstexpr int kMost = 3;\n"
                "struct Pair {\n  int inner = 0;\n};\nstd::vector<Pair> Find(int a,\n"
                "                       int b) {\n  return {};\n}\n}  // namespace\nint Other();\n")
        self.assertEqual(clang_tidy.internal_names(text), {"kMost", "Pair", "Find"})

    def test_same_names_and_other_options_keep_sources_apart(self):
        groups = clang_tidy.make_groups([
            self.clean("a", "Rms"), self.clean("b", "Sum"), self.clean("c", "Rms"),
            self.clean("d", "Mean", " -O1"),
            self.entry("kernels", '#define HWY_TARGET_INCLUDE "kernels.cpp"\n')])
        self.assertEqual(self.names(groups), [["a", "b"], ["c"], ["d"], ["kernels"]])

    def test_groups_stay_small(self):
        entries = [self.clean(f"s{i}", f"Name{i}") for i in range(2 * clang_tidy.MOST_TOGETHER + 1)]
        sizes = [len(group) for group in clang_tidy.make_groups(entries)]
        self.assertEqual(sizes, [clang_tidy.MOST_TOGETHER, clang_tidy.MOST_TOGETHER, 1])

    def test_a_fault_in_any_source_is_named_with_its_place(self):
        a, b = self.clean("a", "Rms"), self.entry("b", FAULT)
        self.assertEqual(self.run_tidy(a, self.clean("c", "Sum")), ("", True))
        for entries in ([a, b], [b, a], [b]):
            text, is_clean = self.run_tidy(*entries)
            self.assertFalse(is_clean)
            self.assertIn("core/b.cpp:2:31: error: result of integer division", text)

    def test_what_the_compiler_tells_of_main_files_only(self):
        unused = self.entry("unused", "namespace {\nconstexpr double kOld = 3.0;\n}  // namespace\n",
                            " -Wall -Wextra -Werror")
        text, is_clean = self.run_tidy(unused, self.clean("a", "Rms"))
        self.assertFalse(is_clean)
        self.assertIn("core/unused.cpp:2:18: error: unused variable 'kOld'", text)

    def test_each_source_may_include_the_same(self):
        include = "#include <cmath>\ndouble %s() { return std::sqrt(2.0); }\n"
        a, b = self.entry("a", include % "A"), self.entry("b", include % "B")
        self.assertEqual(self.run_tidy(a, b), ("", True))

    def test_sources_that_do_not_compile_together_are_read_by_themselves(self):
        a, b, c = self.clean("a", "Rms"), self.clean("b", "Rms"), self.entry("c", FAULT)
        self.assertEqual(self.run_tidy(a, b), ("", True))
        text, is_clean = self.run_tidy(a, b, c)
        self.assertFalse(is_clean)
        self.assertEqual(text.count("error:"), 1, text)
        broken = self.entry("d", "int f( { return 1; }\n")
        self.assertFalse(self.run_tidy(broken)[1])


if __name__ == "__main__":
    unittest.main()

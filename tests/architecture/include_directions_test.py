#!/usr/bin/env python3
"""Reads the #include lines and the CMake links of the program's folders and fails on any arrow that
docs/data_flow.md does not allow. The last class plants violations to show that they are found."""

import pathlib
import re
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Folder -> folders it may include and link besides itself.
ALLOWED = {
    "core": set(),
    "graph": {"core"},
    "io": {"core"},
    "stages": {"graph", "io", "core"},
    "pipeline": {"stages", "graph", "io", "core"},
}

# What stages may know of io: types, abstract readers and writers, scratch space; no file formats.
IO_TYPES_FOR_STAGES = {
    "io/cloud_writer.h",
    "io/external_sort.h",
    "io/run_records.h",
    "io/scan_reader.h",
    "io/scan_stream.h",
    "io/scene_description.h",
    "io/survey_project.h",
}

INCLUDE = re.compile(r'^\s*#\s*include\s+(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
LIBRARY = re.compile(r"\bbacksight_(" + "|".join(ALLOWED) + r")\b")


def folder_of(path):
    return path.split("/", 1)[0]


def arrow_fault(folder, header, root):
    """Why `folder` may not include `header`, or None."""
    target = folder_of(header)
    generated = root / (header + ".in")
    if not (root / header).is_file() and not generated.is_file():
        return "does not exist from the root"
    if target == folder:
        return None
    if target not in ALLOWED[folder]:
        return f"{folder} may include only {', '.join(sorted(ALLOWED[folder])) or 'itself'}"
    if folder == "stages" and target == "io" and header not in IO_TYPES_FOR_STAGES:
        return "stages may use io's types, not its file formats"
    return None


def include_faults(root):
    faults = []
    for folder in ALLOWED:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".cpp", ".h"):
                continue
            text = path.read_text(encoding="utf-8")
            for match in INCLUDE.finditer(text):
                quoted, angled = match.groups()
                if angled is not None and folder_of(angled) not in ALLOWED:
                    continue  # the standard library and third parties
                header = quoted or angled
                fault = arrow_fault(folder, header, root)
                if fault:
                    line = text.count("\n", 0, match.start(1 if quoted else 2)) + 1
                    faults.append(f"{path.relative_to(root)}:{line}: {header}: {fault}")
    return faults


def link_faults(root):
    faults = []
    for folder, allowed in ALLOWED.items():
        for path in sorted((root / folder).rglob("CMakeLists.txt")):
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                for target in LIBRARY.findall(line.split("#", 1)[0]):
                    if target != folder and target not in allowed:
                        where = f"{path.relative_to(root)}:{number}"
                        faults.append(f"{where}: {folder} may not link backsight_{target}")
    return faults


class Tree(unittest.TestCase):
    def test_folders_exist(self):
        for folder in ALLOWED:
            self.assertTrue(list((ROOT / folder).glob("*.h")), f"no headers in {folder}/")

    def test_io_types_exist(self):
        for header in IO_TYPES_FOR_STAGES:
            self.assertTrue((ROOT / header).is_file(), header)

    def test_includes(self):
        self.assertEqual(include_faults(ROOT), [])

    def test_links(self):
        self.assertEqual(link_faults(ROOT), [])


class PlantedViolations(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.root = pathlib.Path(directory.name)
        for header in ("core/a.h", "graph/a.h", "io/pcd_reader.h", "stages/a.h", "pipeline/a.h",
                       *IO_TYPES_FOR_STAGES):
            self.plant(header, "")

    def plant(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def test_every_allowed_arrow_passes(self):
        self.plant("pipeline/b.cpp", "".join(f'#include "{h}"\n' for h in (
            "pipeline/a.h", "stages/a.h", "graph/a.h", "io/pcd_reader.h", "core/a.h")))
        self.plant("stages/deep/b.cpp", '#include "io/scan_reader.h"\n#include <vector>\n')
        self.plant("io/b.cpp", '#include "core/a.h"\n#include <sys/stat.h>\n')
        self.assertEqual(include_faults(self.root), [])

    def test_every_forbidden_arrow_is_found(self):
        a_header = {"core": "core/a.h", "graph": "graph/a.h", "io": "io/scan_reader.h",
                    "stages": "stages/a.h", "pipeline": "pipeline/a.h"}
        for source, allowed in ALLOWED.items():
            for target, header in a_header.items():
                if target == source or target in allowed:
                    continue
                for opening, closing in ('""', "<>"):
                    self.plant(f"{source}/b.cpp", f"\n#  include {opening}{header}{closing}\n")
                    faults = include_faults(self.root)
                    self.assertEqual(len(faults), 1, f"{source} -> {target}")
                    self.assertTrue(faults[0].startswith(f"{source}/b.cpp:2: "), faults[0])
                    (self.root / source / "b.cpp").unlink()

    def test_a_stage_may_not_name_a_file_format(self):
        self.plant("stages/b.h", '#include "io/pcd_reader.h"\n')
        self.assertIn("not its file formats", include_faults(self.root)[0])

    def test_tests_are_out_of_reach(self):
        self.plant("tests/support/a.h", "")
        self.plant("stages/b.cpp", '#include "tests/support/a.h"\n')
        self.assertEqual(len(include_faults(self.root)), 1)

    def test_headers_are_named_from_the_root(self):
        self.plant("io/b.cpp", '#include "pcd_reader.h"\n#include "../core/a.h"\n#include "io/c.h"\n')
        faults = include_faults(self.root)
        self.assertEqual(len(faults), 3)

    def test_generated_headers_count_by_their_template(self):
        self.plant("pipeline/version.h.in", "")
        self.plant("pipeline/b.cpp", '#include "pipeline/version.h"\n')
        self.assertEqual(include_faults(self.root), [])

    def test_forbidden_links_are_found(self):
        self.plant("core/CMakeLists.txt", "backsight_library(core\n  LINKS backsight_io)\n")
        self.plant("stages/CMakeLists.txt", "# backsight_pipeline\nbacksight_library(stages\n"
                   "  LINKS backsight_graph backsight_io backsight_core)\n")
        self.assertEqual(link_faults(self.root),
                         ["core/CMakeLists.txt:2: core may not link backsight_io"])


if __name__ == "__main__":
    unittest.main()

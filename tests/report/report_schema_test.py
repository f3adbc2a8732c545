#!/usr/bin/env python3
"""report.json against docs/schema/report.schema.json, judged by python3-jsonschema. Made-up runs and a
simulated campaign must pass; a copy with a wrong type, a missing key or a key too many must not.
`report` must write report.html again, byte for byte, and a project folder that was moved must give
the same files.

    report_schema_test.py BACKSIGHT SAMPLE_REPORT"""

import copy
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMA = json.loads((ROOT / "docs/schema/report.schema.json").read_text())
SCENE = ROOT / "tests/e2e/scenes/hall.yaml"
BACKSIGHT, SAMPLE_REPORT = sys.argv[1:3]


def backsight(*arguments):
    return subprocess.run([BACKSIGHT, *map(str, arguments)], capture_output=True, text=True)


def faults(document):
    validator = jsonschema.Draft202012Validator(SCHEMA)
    return [f"{'/'.join(map(str, error.absolute_path))}: {error.message[:200]}"
            for error in validator.iter_errors(document)]


def objects(schema):
    """All parts of a schema that describe objects with fixed keys."""
    if isinstance(schema, dict):
        if "properties" in schema and schema.get("type") == "object":
            yield schema
        for part in schema.values():
            yield from objects(part)
    elif isinstance(schema, list):
        for part in schema:
            yield from objects(part)


class Reports(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        subprocess.run([SAMPLE_REPORT, cls.path], check=True)
        backsight("simulate", SCENE, cls.path / "campaign")
        cls.project = next((cls.path / "campaign").glob("*.yaml"))
        cls.run_result = backsight("run", cls.project, "--quiet")
        cls.out = cls.path / "campaign/out"

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def load(self, name):
        return json.loads((self.path / name / "report.json").read_text())

    def test_schema_is_sound_and_strict(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        for part in objects(SCHEMA):
            self.assertIs(part["additionalProperties"], False)
            self.assertEqual(sorted(part["required"]), sorted(part["properties"]))

    def test_made_up_runs_pass(self):
        for name in ("sample", "two", "large"):
            self.assertEqual(faults(self.load(name)), [], name)

    def test_a_real_run_passes(self):
        self.assertIn(self.run_result.returncode, (0, 3), self.run_result.stderr)
        document = self.load("campaign/out")
        self.assertEqual(faults(document), [])
        kinds = [picture["kind"] for picture in document["pictures"]]
        self.assertEqual(kinds.count("section"), 4)
        self.assertEqual(kinds.count("detail"), 5)
        self.assertGreater(document["distances"]["total"]["samples"], 1000)

    def test_damage_is_found(self):
        good = self.load("sample")
        link = next(i for i, link in enumerate(good["links"]) if link["held_out"])
        for spoil, place in (
                (lambda d: d.pop("verdict"), ": 'verdict' is a required property"),
                (lambda d: d.update(extra=1), ": Additional properties"),
                (lambda d: d["links"][link].update(overlap="much"), f"links/{link}/overlap"),
                (lambda d: d["links"][link].pop("rms_m"), f"links/{link}: 'rms_m'"),
                (lambda d: d["links"][link].update(status="skipped"), f"links/{link}/status"),
                (lambda d: d["poses"][0]["covariance"].pop(), "poses/0/covariance"),
                (lambda d: d["pictures"][0].update(png_base64="<b>"), "pictures/0/png_base64"),
                (lambda d: d.update(schema_version=1), "schema_version"),
                (lambda d: d["scans"][0].update(points=-1), "scans/0/points")):
            document = copy.deepcopy(good)
            spoil(document)
            found = faults(document)
            self.assertTrue(any(place in fault for fault in found), (place, found))

    def test_report_is_written_again_from_json_alone(self):
        page = self.out / "report.html"
        first = page.read_bytes()
        page.unlink()
        result = backsight("report", self.project)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(page.read_bytes(), first)
        elsewhere = self.path / "elsewhere"
        elsewhere.mkdir()
        (elsewhere / "report.json").write_bytes((self.out / "report.json").read_bytes())
        self.assertEqual(backsight("report", self.project, "--out", elsewhere).returncode, 0)
        self.assertEqual((elsewhere / "report.html").read_bytes(), first)

    def test_what_report_says_without_a_usable_file(self):
        empty = self.path / "empty"
        empty.mkdir()
        result = backsight("report", self.project, "--out", empty)
        self.assertEqual(result.returncode, 2)
        self.assertIn("no such file", result.stderr)
        self.assertIn("`backsight run` writes it", result.stderr)
        document = self.load("campaign/out")
        document["poses"][1]["links"] = "many"
        (empty / "report.json").write_text(json.dumps(document))
        result = backsight("report", self.project, "--out", empty)
        self.assertEqual(result.returncode, 2)
        self.assertIn("report.json: /poses/1/links: \"many\"; expected a whole number",
                      result.stderr)
        self.assertFalse((empty / "report.html").exists())

    def test_a_moved_project_gives_the_same_bytes(self):
        names = ("report.json", "report.html", "links.csv", "poses.csv", "poses.json")
        first = {name: (self.out / name).read_bytes() for name in names}
        self.assertNotIn(str(self.path).encode(), b"".join(first.values()))
        moved = self.path / "moved" / "deeper"
        moved.parent.mkdir()
        (self.path / "campaign").rename(moved)
        try:
            backsight("run", moved / self.project.name, "--quiet", "--threads", "1")
            for name in names:
                self.assertEqual((moved / "out" / name).read_bytes(), first[name], name)
        finally:
            moved.rename(self.path / "campaign")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

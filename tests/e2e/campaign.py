"""What the Python tests of the program share: a small simulated campaign, and runs of it."""

import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.path.abspath(sys.argv.pop(1))  # before unittest looks at the arguments


def simulate(folder, step_deg=0.5):
    """Four stations about a courtyard, scanned coarsely; returns the project file's text, which
    asks for no clouds."""
    scene = (ROOT / "tests/e2e/scenes/courtyard.yaml").read_text()
    scene, found = re.subn(r"step_deg: 0\.25", f"step_deg: {step_deg}", scene)
    assert found == 1, "the scene has another scanner now"
    path = pathlib.Path(folder) / "scene.yaml"
    path.write_text(scene)
    subprocess.run([PROGRAM, "simulate", path, folder], check=True, capture_output=True)
    stations = "".join(f"  - {{id: S{i}, scan: scans/S{i}.ptx}}\n" for i in range(1, 5))
    return (f"schema_version: 1\nname: courtyard\nstations:\n{stations}"
            "outputs: {merged: [], map: none}\n")


def files_of(out):
    """By relative path, but for what tells of the run: the manifest, and who wrote last."""
    return sorted(str(path.relative_to(out)) for path in out.rglob("*")
                  if path.is_file() and path.name not in ("manifest.json", "run.lock"))


def run(*arguments, **options):
    return subprocess.run([PROGRAM, "run", *arguments], capture_output=True, **options)

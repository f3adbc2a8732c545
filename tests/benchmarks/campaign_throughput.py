"""Time and memory of whole runs against `cp` of what they read and write, as points grow.

    python3 tests/benchmarks/campaign_throughput.py build/release/backsight [FORMAT [STEP_DEG ...]]
        [--scene square|hall]

Simulates five stations with beams STEP_DEG apart (by default about 1, 5 and 20 million points a
station) in FORMAT (las), on the demo's square or in a factory hall, runs each campaign from nothing
to a full merged LAS cloud without map, and copies the same scans and cloud with `cp` in the same
minute. Prints a row per campaign, and how memory grows with points. On the square, which is open,
denser beams fill more voxels; in the hall hardly any.
"""

import argparse
import dataclasses
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


@dataclasses.dataclass
class Scene:
    path: str
    project: str
    steps_deg: list  # for about 1, 5 and 20 million points a station


SCENES = {"square": Scene("projects/demo/scene.yaml", "demo.yaml", [0.17, 0.076, 0.038]),
          "hall": Scene("tests/benchmarks/factory_hall.yaml", "hall.yaml",
                        [0.225, 0.1006, 0.0503])}


def simulate(program, folder, file_format, step_deg, scene_name="square"):
    """Returns the project file: control stays, the cloud is not thinned, no map is drawn."""
    scene = (ROOT / SCENES[scene_name].path).read_text()
    scene, formats = re.subn(r"(?m)^format: .*", f"format: {file_format}", scene)
    scene, steps = re.subn(r"step_deg: [\d.]+", f"step_deg: {step_deg}", scene)
    assert (formats, steps) == (1, 1), "the scene has another form now"
    (folder / "scene.yaml").write_text(scene)
    subprocess.run([program, "simulate", folder / "scene.yaml", folder], check=True,
                   capture_output=True)
    project = folder / SCENES[scene_name].project
    text, thinned = re.subn(r", thin_m: [\d.]+\}\]", "}]\n  map: none", project.read_text())
    assert thinned == 1, "the project has other outputs now"
    project.write_text(text)
    return project


@dataclasses.dataclass
class Usage:
    seconds: float  # elapsed
    processor_s: float
    peak_mb: float


def usage_of(command, accepted=(0,)):
    began = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    took = time.monotonic() - began
    if os.waitstatus_to_exitcode(status) not in accepted:
        sys.exit(f"failed: {command}")
    return Usage(took, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def copy_seconds(folder):
    """`cp` of all that was read and written, brought to the disk as a run does."""
    target = folder / "copies"
    target.mkdir()
    clouds = [folder / "out" / "merged.las", *sorted((folder / "scans").iterdir())]
    usage = usage_of(["sh", "-c", 'for f; do cp "$f" "$0/"; done; sync "$0"/*', target, *clouds])
    shutil.rmtree(target)
    return usage.seconds


def measure(program, file_format, step_deg, scene_name="square"):
    with tempfile.TemporaryDirectory(prefix="backsight-throughput-") as scratch:
        folder = pathlib.Path(scratch)
        project = simulate(program, folder, file_format, step_deg, scene_name)
        usage = usage_of([program, "run", project, "--quiet"])
        manifest = json.loads((folder / "out" / "manifest.json").read_text())
        stages = {stage["stage"]: stage for stage in manifest["stages"]}
        report = json.loads((folder / "out" / "report.json").read_text())
        points, voxels = (sum(scan[what] for scan in report["scans"])
                          for what in ("points", "leaves"))
        copy_s = copy_seconds(folder)
    millions = points / 1e6
    parts = [f"{stages[name]['seconds']:.1f} ({stages[name]['idle_share']:.0%})"
             for name in ("stations", "pairs", "network", "report", "merge")]
    print(f"| {millions:.1f} | {voxels / 1e6:.2f} | {' | '.join(parts)} | {usage.seconds:.1f} | "
          f"{millions / usage.seconds:.2f} | {copy_s:.1f} | {usage.seconds / copy_s:.1f} | "
          f"{usage.peak_mb:.0f} |", flush=True)
    return millions, usage


def print_head(file_format, scene_name="square"):
    print(f"five stations, {scene_name}, {file_format}, {os.cpu_count()} threads; "
          "seconds (idle share of the threads)\n"
          "| million points | million voxels | stations | pairs | network | report | merge | run | "
          "million/s | cp | run / cp | peak MB |\n|" + "---|" * 12)


def exponent(rows, value):
    first, last = rows[0], rows[-1]
    return math.log(value(last[1]) / value(first[1])) / math.log(last[0] / first[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("format", nargs="?", default="las")
    parser.add_argument("steps_deg", nargs="*", type=float)
    parser.add_argument("--scene", choices=SCENES, default="square")
    arguments = parser.parse_intermixed_args()
    steps = arguments.steps_deg or SCENES[arguments.scene].steps_deg
    print_head(arguments.format, arguments.scene)
    rows = [measure(os.path.abspath(arguments.program), arguments.format, step, arguments.scene)
            for step in steps]
    if len(rows) > 1:
        growth = rows[-1][1].peak_mb / rows[0][1].peak_mb - 1.0
        time_exponent = exponent(rows, lambda usage: usage.seconds)
        memory_exponent = exponent(rows, lambda usage: usage.peak_mb)
        print(f"\nfrom the first to the last row time grows as points^{time_exponent:.2f}, "
              f"memory as points^{memory_exponent:.2f} ({growth:+.0%})")


if __name__ == "__main__":
    main()

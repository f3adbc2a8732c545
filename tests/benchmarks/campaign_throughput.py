"""Time and memory of whole runs against `cp` of what they read and write, as points grow.

    python3 tests/benchmarks/campaign_throughput.py build/release/backsight [FORMAT [STEP_DEG ...]]

Simulates the demo's five stations with beams STEP_DEG apart (0.2, 0.09 and 0.045: about 1, 5 and 20
million points a station) in FORMAT (las), runs each campaign from nothing to a full merged LAS
cloud without map, and copies the same scans and cloud with `cp` in the same minute. Prints a row
per campaign, and how memory grows with points.
"""

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


def simulate(program, folder, file_format, step_deg):
    """Returns the project file: control stays, the cloud is not thinned, no map is drawn."""
    scene = (ROOT / "projects/demo/scene.yaml").read_text()
    scene, formats = re.subn(r"(?m)^format: .*", f"format: {file_format}", scene)
    scene, steps = re.subn(r"step_deg: [\d.]+", f"step_deg: {step_deg}", scene)
    assert (formats, steps) == (1, 1), "the scene has another form now"
    (folder / "scene.yaml").write_text(scene)
    subprocess.run([program, "simulate", folder / "scene.yaml", folder], check=True,
                   capture_output=True)
    project = folder / "demo.yaml"
    text, thinned = re.subn(r", thin_m: [\d.]+\}\]", "}]\n  map: none", project.read_text())
    assert thinned == 1, "the project has other outputs now"
    project.write_text(text)
    return project


def seconds_of(command):
    began = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    took = time.monotonic() - began
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"failed: {command}")
    return took, usage.ru_maxrss / 1024


def copy_seconds(folder):
    """`cp` of all that was read and written, brought to the disk as a run does."""
    target = folder / "copies"
    target.mkdir()
    clouds = [folder / "out" / "merged.las", *sorted((folder / "scans").iterdir())]
    took, _ = seconds_of(["sh", "-c", 'for f; do cp "$f" "$0/"; done; sync "$0"/*', target, *clouds])
    shutil.rmtree(target)
    return took


def measure(program, file_format, step_deg):
    with tempfile.TemporaryDirectory(prefix="backsight-throughput-") as scratch:
        folder = pathlib.Path(scratch)
        project = simulate(program, folder, file_format, step_deg)
        run_s, peak_mb = seconds_of([program, "run", project, "--quiet"])
        manifest = json.loads((folder / "out" / "manifest.json").read_text())
        stages = {stage["stage"]: stage["seconds"] for stage in manifest["stages"]}
        report = json.loads((folder / "out" / "report.json").read_text())
        points = sum(scan["points"] for scan in report["scans"])
        copy_s = copy_seconds(folder)
    millions = points / 1e6
    parts = [stages[name] for name in ("stations", "pairs", "network", "report", "merge")]
    print(f"| {millions:.1f} | " + " | ".join(f"{part:.1f}" for part in parts) +
          f" | {run_s:.1f} | {millions / run_s:.2f} | {copy_s:.1f} | {run_s / copy_s:.1f} | "
          f"{peak_mb:.0f} |", flush=True)
    return millions, run_s, peak_mb


def exponent(rows, column):
    first, last = rows[0], rows[-1]
    return math.log(last[column] / first[column]) / math.log(last[0] / first[0])


def main():
    program = os.path.abspath(sys.argv[1])
    file_format = sys.argv[2] if len(sys.argv) > 2 else "las"
    steps = [float(text) for text in sys.argv[3:]] or [0.2, 0.09, 0.045]
    print(f"five stations, {file_format}, {os.cpu_count()} threads; seconds\n"
          "| million points | stations | pairs | network | report | merge | run | million/s | cp | "
          "run / cp | peak MB |\n|" + "---|" * 11)
    rows = [measure(program, file_format, step) for step in steps]
    if len(rows) > 1:
        print(f"\nfrom the first to the last row time grows as points^{exponent(rows, 1):.2f}, "
              f"memory as points^{exponent(rows, 2):.2f}")


main()

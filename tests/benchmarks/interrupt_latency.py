"""How long a run takes to end after SIGTERM, at moments spread over all of it.

    python3 tests/benchmarks/interrupt_latency.py build/release/backsight [SCENE.yaml [MOMENTS]]

Simulates the scene (projects/demo/scene.yaml), runs it once undisturbed, and then anew for every
moment. Prints a line per moment and the worst, in seconds.
"""

import json
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def start(program, project):
    return subprocess.Popen([program, "run", project, "--quiet"], stdout=subprocess.DEVNULL)


def forget(folder):
    for name in ("out", "work"):
        shutil.rmtree(folder / name, ignore_errors=True)


def main():
    program = sys.argv[1]
    scene = sys.argv[2] if len(sys.argv) > 2 else ROOT / "projects/demo/scene.yaml"
    moments = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    with tempfile.TemporaryDirectory(prefix="backsight-interrupt-") as scratch:
        folder = pathlib.Path(scratch)
        subprocess.run([program, "simulate", scene, folder], check=True, capture_output=True)
        project = next(path for path in folder.glob("*.yaml"))
        began = time.monotonic()
        if start(program, project).wait() not in (0, 3, 4):
            sys.exit("the run failed")
        whole_s = time.monotonic() - began
        print(f"undisturbed: {whole_s:.1f} s\n| at [s] | stage | exit code | ended after [s] |\n"
              "|---|---|---|---|")
        worst = 0.0
        for k in range(moments):
            forget(folder)
            process = start(program, project)
            at = whole_s * (k + 0.5) / moments
            time.sleep(at)
            process.send_signal(signal.SIGTERM)
            asked = time.monotonic()
            code = process.wait()
            took = time.monotonic() - asked
            progress = folder / "work" / "progress.json"
            stage = json.loads(progress.read_text())["stage"] if progress.exists() else "start"
            print(f"| {at:.1f} | {stage} | {code} | {took:.2f} |", flush=True)
            worst = max(worst, took)
        print(f"\nworst of {moments}: {worst:.2f} s")


if __name__ == "__main__":
    main()

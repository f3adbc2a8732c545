"""How time and memory of whole runs grow with stations and with points.

    python3 tests/benchmarks/scale_curves.py build/release/backsight stations [N ...]
    python3 tests/benchmarks/scale_curves.py build/release/backsight points [FORMAT]
        [--scene square|hall]

`stations` simulates quarters of small houses with a station every 8 m of street, N of them (5, 10, 20,
50, 100, 200), scanned with beams 0.5 degrees apart, and registers each with voxels of 0.2 m, from
nothing to the report; clouds and map are left out. `points` does the campaigns of
campaign_throughput.py, at five stations, on the square or in the hall. Prints a row per campaign
and the exponents fitted to the rows. Seconds of the processor say more than elapsed ones where the
machine is shared.
"""

import argparse
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile

import campaign_throughput

STATIONS = [5, 10, 20, 50, 100, 200]
BLOCK_M = 16.0  # from street to street
BUILT = 0.7  # share of the blocks that have a house
ROOFS = ["flat", "gable", "hip"]
STYLES = ["masonry", "modern", "industrial"]


def places(stations):
    """Crossings and the middles of the streets between them, those nearest to the origin."""
    reach = math.ceil(math.sqrt(stations))
    lattice = [(i, j) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)
               if i % 2 == 0 or j % 2 == 0]
    lattice.sort(key=lambda place: (max(abs(place[0]), abs(place[1])), place))
    return [(0.5 * BLOCK_M * i, 0.5 * BLOCK_M * j) for i, j in lattice[:stations]]


def quarter(stations):
    """The scene: streets on a lattice, houses of their own shapes between them."""
    chance = random.Random(stations)
    sites = places(stations)
    blocks = math.ceil(max(max(map(abs, site)) for site in sites) / BLOCK_M) + 1
    lines = ["schema_version: 1", "name: quarter", f"seed: {stations}", "format: ply",
             f"ground: {{size_m: {2 * blocks * BLOCK_M + 40:.0f}, undulation_m: 0.3}}",
             "buildings:"]
    for i in range(-blocks, blocks):
        for j in range(-blocks, blocks):
            if chance.random() > BUILT:
                continue
            x, y = ((k + 0.5) * BLOCK_M + chance.uniform(-0.8, 0.8) for k in (i, j))
            lines.append(
                f"  - {{center_m: [{x:.2f}, {y:.2f}], size_m: [{chance.uniform(6, 9):.2f}, "
                f"{chance.uniform(5, 7.5):.2f}], heading_deg: {chance.uniform(-25, 25):.1f}, "
                f"wall_height_m: {chance.uniform(3, 9):.2f}, storeys: {chance.randint(1, 3)}, "
                f"style: {chance.choice(STYLES)}, roof: {chance.choice(ROOFS)}, "
                f"bay_m: {chance.uniform(2.4, 4.2):.2f}, "
                f"window_depth_m: {chance.uniform(0.12, 0.35):.2f}}}")
    lines += ["scanner: {step_deg: 0.5, min_elevation_deg: -55, max_elevation_deg: 60, "
              "max_range_m: 45, orientation: random_heading}", "stations:"]
    for k, site in enumerate(sites):
        x, y = (c + chance.uniform(-0.6, 0.6) for c in site)
        lines.append(f"  - {{id: S{k + 1}, position_m: [{x:.2f}, {y:.2f}], height_m: 1.7}}")
    return "\n".join(lines) + "\n"


def simulate(program, folder, stations):
    (folder / "scene.yaml").write_text(quarter(stations))
    subprocess.run([program, "simulate", folder / "scene.yaml", folder], check=True,
                   capture_output=True)
    project = folder / "quarter.yaml"
    text = project.read_text()
    project.write_text(text[:text.index("outputs:")] + "registration: {resolution_m: 0.2}\n")
    return project


def measure(program, stations):
    with tempfile.TemporaryDirectory(prefix="backsight-scale-") as scratch:
        folder = pathlib.Path(scratch)
        project = simulate(program, folder, stations)
        usage = campaign_throughput.usage_of(
            [program, "run", project, "--quiet", "--only", "network"], accepted=(0, 3))
        report = json.loads((folder / "out" / "report.json").read_text())
    placed = max((part["stations"] for part in report["components"]), default=0)
    points = sum(scan["points"] for scan in report["scans"]) / stations
    links = len(report["links"])
    print(f"| {stations} | {points:.0f} | {placed} | {links} | {usage.seconds:.1f} | "
          f"{usage.processor_s:.1f} | {usage.peak_mb:.0f} |", flush=True)
    return stations, usage


def exponent(sizes, values):
    """Slope of the straight line through the logarithms, by least squares."""
    x = [math.log(size) for size in sizes]
    y = [math.log(value) for value in values]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    return (sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) /
            sum((a - mean_x) ** 2 for a in x))


def print_exponents(rows, what):
    sizes = [size for size, _ in rows]
    for name, value in (("elapsed time", lambda u: u.seconds),
                        ("processor time", lambda u: u.processor_s),
                        ("peak memory", lambda u: u.peak_mb)):
        print(f"{name} grows as {what}^{exponent(sizes, [value(u) for _, u in rows]):.2f}")


def sweep_stations(program, counts):
    print(f"{os.cpu_count()} threads\n| stations | points each | placed together | pairs tried | "
          "run, s | processor, s | peak MB |\n|" + "---|" * 7)
    rows = [measure(program, count) for count in counts]
    print(f"\nfrom {counts[0]} to {counts[-1]} stations:")
    print_exponents(rows, "n")
    large = [row for row in rows if row[0] >= 20]
    if 1 < len(large) < len(rows):
        print(f"from {large[0][0]} to {counts[-1]}:")
        print_exponents(large, "n")


def sweep_points(program, file_format, scene_name):
    campaign_throughput.print_head(file_format, scene_name)
    rows = [campaign_throughput.measure(program, file_format, step, scene_name)
            for step in campaign_throughput.SCENES[scene_name].steps_deg]
    print()
    print_exponents(rows, "m")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=os.path.abspath)
    sweeps = parser.add_subparsers(dest="sweep", required=True)
    sweeps.add_parser("stations").add_argument("counts", nargs="*", type=int)
    points = sweeps.add_parser("points")
    points.add_argument("format", nargs="?", default="las")
    points.add_argument("--scene", choices=campaign_throughput.SCENES, default="square")
    arguments = parser.parse_args()
    if arguments.sweep == "stations":
        sweep_stations(arguments.program, arguments.counts or STATIONS)
    else:
        sweep_points(arguments.program, arguments.format, arguments.scene)


if __name__ == "__main__":
    main()

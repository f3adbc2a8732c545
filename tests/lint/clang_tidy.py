#!/usr/bin/env python3
"""Runs clang-tidy over sources that a configured build directory compiles.

    clang_tidy.py BUILD_DIRECTORY [FILE...]

JOBS: how many at a time (all cores). Without files: all of core graph io stages pipeline.

Most of clang-tidy's time goes into headers that all sources share. So sources that are compiled with
the same options and give their internal names to nothing in common are read as one; where that does
not compile after all, each half by itself."""

import collections
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("core", "graph", "io", "stages", "pipeline")
MOST_TOGETHER = 16
DOES_NOT_COMPILE = "[clang-diagnostic-error]"

# Highway's kernels include themselves, once for every instruction set.
ALONE = re.compile(r"HWY_TARGET_INCLUDE")
INTERNAL = re.compile(r"^namespace \{$(.*?)^\}  // namespace$", re.MULTILINE | re.DOTALL)
# What begins in the first column: its name stands before the parameters, the value or the body.
DEFINITION = re.compile(r"^(?!template)[a-zA-Z][^\n]*?(\w+) ?[(={;\[]", re.MULTILINE)


def internal_names(text):
    return {name for part in INTERNAL.findall(text) for name in DEFINITION.findall(part)}


def options_of(entry):
    """How a source is compiled, whatever it is called."""
    command = entry["command"].split(" -o ")[0]
    return re.sub(r" -M[FT] \S+| -MD", "", command)


def make_groups(entries):
    """Sources that can be read as one: same options, no internal name in common."""
    groups = collections.defaultdict(list)  # by options: names, entries
    alone = []
    for entry in entries:
        text = pathlib.Path(entry["file"]).read_text(encoding="utf-8")
        if ALONE.search(text):
            alone.append([entry])
            continue
        names = internal_names(text)
        of_options = groups[options_of(entry)]
        for taken, members in of_options:
            if len(members) < MOST_TOGETHER and not names & taken:
                break
        else:
            taken, members = set(), []
            of_options.append((taken, members))
        taken |= names
        members.append(entry)
    together = [members for of_options in groups.values() for _, members in of_options]
    return sorted(together + alone, key=len, reverse=True)


def run(entries, scratch):
    """What clang-tidy prints of these sources, and whether it found nothing."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=scratch))
    source = folder / "group.cpp"
    source.write_text("".join(f'#include "{entry["file"]}"\n' for entry in entries))
    # A name may hide one of another source.
    command = f"{options_of(entries[0])} -Wno-shadow -o {folder}/group.o -c {source}"
    database = [{"directory": entries[0]["directory"], "command": command, "file": str(source)}]
    (folder / "compile_commands.json").write_text(json.dumps(database))
    tidy = subprocess.run(
        ["clang-tidy", "-p", folder, "--quiet", f"--config-file={ROOT / '.clang-tidy'}", source],
        capture_output=True, text=True)
    if DOES_NOT_COMPILE in tidy.stdout and len(entries) > 1:
        middle = len(entries) // 2
        halves = [run(entries[:middle], scratch), run(entries[middle:], scratch)]
        return "".join(text for text, _ in halves), all(clean for _, clean in halves)
    if tidy.returncode == 0:
        return "", True
    return tidy.stdout or tidy.stderr, False


def main():
    build, *files = sys.argv[1:]
    if not files:
        patterns = [f"{folder}/*.cpp" for folder in FOLDERS]
        files = subprocess.run(["git", "ls-files", "--", *patterns], cwd=ROOT, check=True,
                               capture_output=True, text=True).stdout.splitlines()
    wanted = {str((ROOT / file).resolve()) for file in files}
    database = json.loads((ROOT / build / "compile_commands.json").read_text())
    entries = [entry for entry in database if entry["file"] in wanted]
    missing = wanted - {entry["file"] for entry in entries}
    if missing or not entries:
        sys.exit(f"clang_tidy: {build} compiles no {', '.join(sorted(missing)) or 'source'}")
    started = time.monotonic()
    jobs = int(os.environ.get("JOBS", os.cpu_count()))
    clean = True
    with tempfile.TemporaryDirectory(prefix="backsight-tidy-") as scratch, \
            concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for text, is_clean in pool.map(lambda group: run(group, scratch), make_groups(entries)):
            print(text, end="")
            clean &= is_clean
    if not clean:
        sys.exit(1)
    print(f"clang-tidy: {len(entries)} files clean in {time.monotonic() - started:.0f} s")


if __name__ == "__main__":
    main()

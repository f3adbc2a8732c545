#!/usr/bin/env python3
"""Runs clang-tidy over sources that a configured build directory compiles.

    clang_tidy.py BUILD_DIRECTORY [FILE...]

JOBS: how many at a time (all cores). Without files: all of core graph io stages pipeline.

Most of clang-tidy's time goes into headers that all sources share. So sources that are compiled with
the same options and give their internal names to nothing in common are read as one; where that does
not compile after all, each half by itself."""

import bisect
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("core", "graph", "io", "stages", "pipeline")
MOST_TOGETHER = 16
DOES_NOT_COMPILE = "[clang-diagnostic-error]"

# What would reach the sources behind; Highway's kernels also include themselves.
ALONE = re.compile(r"^\s*#\s*(define|undef|pragma)", re.MULTILINE)
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


def tidy(database, source):
    """What clang-tidy prints of a source, and whether it found nothing."""
    done = subprocess.run(
        ["clang-tidy", "-p", database, "--quiet", f"--config-file={ROOT / '.clang-tidy'}", source],
        capture_output=True, text=True)
    if done.returncode == 0:
        return "", True
    return done.stdout + (done.stderr if done.returncode < 0 or not done.stdout else ""), False


def write_group(entries, folder):
    """One source of all texts, with how it is compiled. Returns the line before each text."""
    lines, before = [], []
    for number, entry in enumerate(entries):
        lines.append(f"#define BACKSIGHT_SOURCE_{number}")  # includes are counted anew after it
        before.append(len(lines))
        lines += pathlib.Path(entry["file"]).read_text(encoding="utf-8").splitlines()
    source = folder / "group.cpp"
    source.write_text("\n".join(lines) + "\n", encoding="utf-8")
    # A name may hide one of another source.
    command = f"{options_of(entries[0])} -Wno-shadow -o group.o -c {shlex.quote(str(source))}"
    database = [{"directory": entries[0]["directory"], "command": command, "file": str(source)}]
    (folder / "compile_commands.json").write_text(json.dumps(database))
    return before


def run(entries, build, scratch):
    """The same of all these sources."""
    if len(entries) == 1:
        return tidy(build, entries[0]["file"])
    folder = pathlib.Path(tempfile.mkdtemp(dir=scratch))
    before = write_group(entries, folder)
    text, is_clean = tidy(folder, folder / "group.cpp")
    if DOES_NOT_COMPILE in text:
        middle = len(entries) // 2
        halves = [run(half, build, scratch) for half in (entries[:middle], entries[middle:])]
        return "".join(text for text, _ in halves), all(clean for _, clean in halves)

    def place(match):
        line = int(match[1])
        index = bisect.bisect_left(before, line) - 1
        return f"{entries[index]['file']}:{line - before[index]}:"

    return re.sub(rf"{re.escape(str(folder))}/group\.cpp:(\d+):", place, text), is_clean


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    build, *files = sys.argv[1:]
    build = (ROOT / build).resolve()
    if not files:
        patterns = [f"{folder}/*.cpp" for folder in FOLDERS]
        files = subprocess.run(["git", "ls-files", "--", *patterns], cwd=ROOT, check=True,
                               capture_output=True, text=True).stdout.splitlines()
    wanted = {(ROOT / file).resolve() for file in files}
    database = json.loads((build / "compile_commands.json").read_text())
    entries = [entry for entry in database if pathlib.Path(entry["file"]).resolve() in wanted]
    missing = wanted - {pathlib.Path(entry["file"]).resolve() for entry in entries}
    if missing or not entries:
        names = ", ".join(sorted(map(str, missing)))
        sys.exit(f"clang_tidy: {build} compiles no {names or 'source'}")
    started = time.monotonic()
    jobs = int(os.environ.get("JOBS") or len(os.sched_getaffinity(0)))
    clean = True
    with tempfile.TemporaryDirectory(prefix="backsight-tidy-") as scratch, \
            concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        groups = make_groups(entries)
        for text, is_clean in pool.map(lambda group: run(group, build, scratch), groups):
            print(text, end="")
            clean &= is_clean
    if not clean:
        sys.exit(1)
    print(f"clang-tidy: {len(entries)} files clean in {time.monotonic() - started:.0f} s")


if __name__ == "__main__":
    main()

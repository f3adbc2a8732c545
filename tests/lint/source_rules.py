#!/usr/bin/env python3
"""Cheap rules for the tracked files that no compiler checks. Prints `file:line: what is wrong` for
each violation and exits with 1 if there is any."""

import pathlib
import re
import subprocess
import sys

FOLDERS = ("core", "graph", "io", "stages", "pipeline")
MAX_LINES = 450
MAX_BYTES = 1_000_000

TO_DO = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b(?!\(#\d+\))")
MACHINE_PATH = re.compile(r"(^|[^A-Za-z0-9_.-])/(work|farm|root|home|Users)/[A-Za-z.]")
EXIT = re.compile(r"(?<![\w.>])(?:std::|::)?(?:quick_)?exit\s*\(")
ANGLE_INCLUDE = re.compile(r"^\s*#\s*include\s+<([^>]+)>")
# Standard headers have neither a folder nor an extension.
HEADER_MAY_INCLUDE = re.compile(r"[a-z_0-9]+|Eigen/.+")
TEST_HEADER_MAY_INCLUDE = re.compile(r"[a-z_0-9]+|(Eigen|gtest|gmock|benchmark)/.+")


def code_of(line):
    """The line without string literals and its comment."""
    return re.sub(r'"(\\.|[^"\\])*"', '""', line).split("//", 1)[0]


def line_findings(path, line):
    """What is wrong with one line of a text file."""
    if path.endswith("source_rules.py"):
        return  # names what it looks for
    if TO_DO.search(line):
        yield "a to-do names its issue: TODO(#12)"
    if MACHINE_PATH.search(line):
        yield "path of one machine; name things relative to the project"
    top = path.split("/", 1)[0]
    if top in FOLDERS and path.endswith((".cpp", ".h")) and path != "pipeline/main.cpp":
        if EXIT.search(code_of(line)):
            yield "only pipeline/main.cpp may call exit(); throw instead"
    if path.endswith(".h"):
        include = ANGLE_INCLUDE.match(line)
        allowed = TEST_HEADER_MAY_INCLUDE if top == "tests" else HEADER_MAY_INCLUDE
        if include and not allowed.fullmatch(include[1]):
            yield f"<{include[1]}> belongs into a .cpp; headers show our types, Eigen and std only"


def file_findings(path, data):
    """(line, what) for everything wrong with one tracked file, given its bytes."""
    if len(data) > MAX_BYTES:
        yield 1, f"{len(data)} bytes; no tracked file is larger than {MAX_BYTES}"
    if b"\0" in data[:8000]:
        return
    lines = data.decode("utf-8", errors="replace").splitlines()
    if path.endswith((".cpp", ".h", ".py")) and len(lines) > MAX_LINES:
        yield MAX_LINES, f"{len(lines)} lines, more than {MAX_LINES}: does it hold two ideas?"
    if path.endswith(".h") and "#pragma once" not in lines:
        yield 1, "header without #pragma once"
    for number, line in enumerate(lines, 1):
        for what in line_findings(path, line):
            yield number, what


def unbuilt_sources(files):
    """Sources that no CMakeLists.txt names, so that nobody compiles them. `files`: path -> bytes."""
    named = {path: data.decode("utf-8", errors="replace") for path, data in files.items()
             if path.endswith("CMakeLists.txt")}
    for path in sorted(files):
        if not path.endswith(".cpp") or path.split("/", 1)[0] not in (*FOLDERS, "tests"):
            continue
        parents = pathlib.PurePosixPath(path).parents
        listed = any(
            re.search(rf"(?<![\w/]){re.escape(str(pathlib.PurePosixPath(path).relative_to(p)))}\b",
                      named.get(str(p / "CMakeLists.txt"), "")) for p in parents)
        if not listed:
            yield path, 1, "no CMakeLists.txt names it, so nobody compiles it"


def findings(files):
    for path in sorted(files):
        for line, what in file_findings(path, files[path]):
            yield path, line, what
    yield from unbuilt_sources(files)


def tracked_files(root):
    names = subprocess.run(["git", "ls-files", "-z"], cwd=root, check=True,
                           capture_output=True).stdout.decode().split("\0")
    paths = {name: root / name for name in names if name}
    return {name: path.read_bytes() for name, path in paths.items() if path.is_file()}


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    files = tracked_files(root)
    found = list(findings(files))
    for path, line, what in found:
        print(f"{path}:{line}: {what}")
    print(f"source rules: {len(files)} files, {len(found)} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

"""Runs that find too little disk, memory or time: refused or ended cleanly, and nothing is lost."""

import os
import pathlib
import re
import resource
import shutil
import subprocess
import tempfile
import unittest

import campaign

TEMPORARY = re.compile(r"\.tmp-\d+-\d+$")


class Survey(unittest.TestCase):
    """A folder for a campaign and its runs; nothing of a test's run is left to the next."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="backsight-budget-")
        cls.folder = pathlib.Path(cls.scratch.name)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def setUp(self):
        for name in ("out", "work"):
            shutil.rmtree(self.folder / name, ignore_errors=True)


class Budget(Survey):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.text = campaign.simulate(cls.folder).replace("merged: []",
                                                         "merged: [{format: las, path: %s}]")
        cls.small = cls.folder / "small"
        cls.small.mkdir()

    def project(self, cloud="out/merged.las", more=""):
        path = self.folder / "survey.yaml"
        path.write_text(self.text % cloud + more)
        return path

    def mount(self, kilobytes):
        """A file system of its own, unmounted at the test's end."""
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs",
                                  self.small], capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("mounting a small file system is not allowed here")
        self.addCleanup(subprocess.run, ["umount", self.small], check=True)

    def expect_nothing_half_written(self):
        self.assertEqual([str(path) for path in self.folder.rglob("*")
                          if TEMPORARY.search(path.name)], [])

    def test_disk_that_cannot_hold_the_cloud_is_found_before_the_start(self):
        scene = (self.folder / "scene.yaml").read_text().replace("format: ptx", "format: las")
        (self.folder / "las.yaml").write_text(scene)
        subprocess.run([campaign.PROGRAM, "simulate", self.folder / "las.yaml", self.folder],
                       check=True, capture_output=True)
        self.mount(300)
        project = self.project("small/merged.las")
        project.write_text(project.read_text().replace(".ptx", ".las"))
        run = campaign.run(project, "--quiet")
        self.assertEqual(run.returncode, 6, run.stderr)
        too_little = r"small: this run writes \d\.\d MB at least, 0\.3 MB are free"
        self.assertRegex(run.stderr.decode(), too_little)
        check = subprocess.run([campaign.PROGRAM, "check", project], capture_output=True, text=True)
        self.assertEqual(check.returncode, 6, check.stderr)
        self.assertRegex(check.stderr, too_little)
        self.assertFalse(list((self.folder / "work").rglob("station.artifact")))
        run = campaign.run(project, "--quiet", "--only", "network")  # which writes no cloud
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_disk_that_fills_up_costs_the_cloud_only(self):
        """A thinned cloud may become as small as it likes, so that nothing can be said before."""
        self.mount(200)
        text = (self.text % "small/merged.las").replace("merged.las}", "merged.las, thin_m: 0.001}")
        project = self.folder / "survey.yaml"
        project.write_text(text)
        run = campaign.run(project, "--quiet")
        self.assertEqual(run.returncode, 6, run.stderr)
        self.assertIn("No space left on device", run.stderr.decode())
        self.assertEqual(list(self.small.iterdir()), [])
        self.assertIn("registered", (self.folder / "out" / "poses.csv").read_text())
        subprocess.run(["mount", "-o", "remount,size=100m", self.small], check=True)
        before = {path: path.stat().st_mtime_ns
                  for path in (self.folder / "work").rglob("*.artifact")}
        again = campaign.run(project, "--quiet")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual({path: path.stat().st_mtime_ns for path in before}, before)
        self.assertGreater((self.small / "merged.las").stat().st_size, 200_000)
        self.expect_nothing_half_written()

    def test_work_folder_that_fills_up_stops_the_run(self):
        self.mount(3000)
        run = campaign.run(self.project(), "--quiet", "--work", self.small)
        self.assertEqual(run.returncode, 6, run.stderr)
        self.assertIn("What is finished is kept", run.stdout.decode())
        self.expect_nothing_half_written()
        subprocess.run(["mount", "-o", "remount,size=100m", self.small], check=True)
        again = campaign.run(self.project(), "--quiet", "--work", self.small)
        self.assertEqual(again.returncode, 0, again.stderr)

    def within(self, megabytes, *arguments):
        """Runs the program where the system gives it no more memory than that."""
        limit = (megabytes * 10**6,) * 2
        return subprocess.run([campaign.PROGRAM, *arguments], capture_output=True, text=True,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, limit))

    def test_tasks_on_a_cluster_count_pairs_that_found_no_memory_as_failed(self):
        project = self.project(more="resources: {threads: 4, memory_gb: 1}\n")
        for station in range(4):
            subprocess.run([campaign.PROGRAM, "work", project, "--station", str(station)],
                           check=True, capture_output=True)
        if self.within(150, "--version").returncode != 0:
            self.skipTest("a sanitizer reserves more")
        for megabytes in range(150, 60, -20):
            shutil.rmtree(self.folder / "work" / "pairs", ignore_errors=True)
            task = self.within(megabytes, "work", project, "--shards", "1", "--shard", "0")
            stored = len(list((self.folder / "work" / "pairs").rglob("full.artifact")))
            if task.returncode == 6:  # even what leads from pair to pair found none
                self.assertIn("the budget of 1 GB of memory is used up", task.stderr)
            else:
                self.assertEqual(task.returncode, 0 if stored == 6 else 3, task.stderr)
                if stored < 6:
                    self.assertIn(f"{6 - stored} failed", task.stderr)
            if re.search("(station S.|pair S. S.): needs more memory", task.stderr):
                return
        self.fail("there was memory for every pair and its stations")

    def test_pairs_that_take_too_long_are_named_and_tried_again_next_time(self):
        run = campaign.run(self.project(more="resources: {pair_limit_s: 0.001}\n"), "--quiet")
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn("took longer than its limit of 0.001 s", run.stderr.decode())
        links = (self.folder / "out" / "links.csv").read_text()
        self.assertEqual(links.count(",failed,"), 6, links)
        again = campaign.run(self.project(), "--quiet")
        self.assertEqual(again.returncode, 0, again.stderr)


class Memory(Survey):
    """Fine scans and small voxels, which half a gigabyte is just enough for."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.text = campaign.simulate(cls.folder, step_deg=0.14)
        cls.text += "registration: {resolution_m: 0.035}\n"

    def run_within(self, memory_gb, text, exit_code):
        """Returns what the run says on stderr; its memory may not exceed the budget."""
        project = self.folder / "survey.yaml"
        project.write_text(text)
        with open(self.folder / "stderr", "w+b") as log:
            run = subprocess.Popen([campaign.PROGRAM, "run", project, "--quiet", "--memory-gb",
                                    str(memory_gb), "--threads", "4"],
                                   stdout=subprocess.DEVNULL, stderr=log)
            _, status, usage = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
            log.seek(0)
            stderr = log.read().decode()
        print(f"peak RSS {usage.ru_maxrss * 1024e-9:.3f} GB of {memory_gb} GB")
        self.assertEqual(run.returncode, exit_code, stderr)
        self.assertLess(usage.ru_maxrss * 1024, memory_gb * 1e9)
        return stderr

    def test_stations_that_find_no_memory_are_named_and_found_with_more(self):
        stderr = self.run_within(0.25, self.text, 6)
        named = re.findall(r"station (S\d): needs more memory than the budget leaves", stderr)
        self.assertGreaterEqual(len(named), 3, stderr)  # one may just find enough alone
        self.assertIn(f"error: stations: each of {', '.join(named)} needs more memory", stderr)
        self.run_within(1.0, self.text, 0)

    def test_other_faults_are_told_beside_those_of_memory(self):
        (self.folder / "scans" / "bad.ptx").write_text("3\n")
        scans = self.text.replace("scans/S2.ptx", "scans/bad.ptx")
        self.run_within(0.25, scans, 5)
        report = (self.folder / "out" / "report.json").read_text()
        self.assertIn("bad.ptx", report)
        self.assertIn("needs more memory than the budget leaves", report)


if __name__ == "__main__":
    unittest.main()

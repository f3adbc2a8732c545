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


class Budget(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="backsight-budget-")
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.text = campaign.simulate(cls.folder).replace("merged: []",
                                                         "merged: [{format: las, path: %s}]")
        cls.small = cls.folder / "small"
        cls.small.mkdir()

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def setUp(self):
        for name in ("out", "work"):
            shutil.rmtree(self.folder / name, ignore_errors=True)

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
        self.assertRegex(run.stderr.decode(),
                         r"small: this run writes \d\.\d MB at least, 0\.3 MB are free")
        self.assertFalse(list((self.folder / "work").rglob("station.artifact")))

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

    def test_memory_stays_within_its_budget(self):
        run = subprocess.Popen([campaign.PROGRAM, "run", self.project(), "--quiet", "--memory-gb",
                                "0.3", "--threads", "4"], stdout=subprocess.PIPE)
        run.stdout.read()
        _, status, usage = os.wait4(run.pid, 0)
        run.stdout.close()
        run.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(run.returncode, 0)
        print(f"peak RSS {usage.ru_maxrss / 1e6 * 1.024:.3f} GB of 0.3 GB")
        self.assertLess(usage.ru_maxrss * 1024, 0.3e9)

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
            self.assertEqual(task.returncode, 0 if stored == 6 else 3, task.stderr)
            if stored < 6:
                self.assertIn(f"{6 - stored} failed", task.stderr)
            if re.search("pair S. S.: needs more memory", task.stderr):
                return
        self.fail("there was memory for every pair")

    def test_pairs_that_take_too_long_are_named_and_tried_again_next_time(self):
        run = campaign.run(self.project(more="resources: {pair_limit_s: 0.001}\n"), "--quiet")
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn("took longer than its limit of 0.001 s", run.stderr.decode())
        links = (self.folder / "out" / "links.csv").read_text()
        self.assertEqual(links.count(",failed,"), 6, links)
        again = campaign.run(self.project(), "--quiet")
        self.assertEqual(again.returncode, 0, again.stderr)


if __name__ == "__main__":
    unittest.main()

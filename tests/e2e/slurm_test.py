"""Runs on a Slurm cluster: the same bytes as a local run, whatever happens to a task."""

import filecmp
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import campaign
import slurm_cluster


def interrupt(process):
    process.send_signal(signal.SIGINT)
    return process.communicate(timeout=60)


class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="backsight-slurm-test-")
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.folder = pathlib.Path(cls.scratch.name) / "it's a \"survey\" $HOME 100%j; `x`"
        cls.folder.mkdir()
        cls.project = cls.folder / "town hall.yaml"
        cls.text = campaign.simulate(cls.folder).replace("merged: []",
                                                         "merged: [{format: las, path: out/m.las}]")
        cls.text += "resources: {threads: 1, memory_gb: 1}\n"
        cls.project.write_text(cls.text)
        local = campaign.run(cls.project, "--quiet")
        assert local.returncode == 0, local.stderr
        cls.reference = cls.folder / "local"
        cls.reference.mkdir()
        cls.forget(keep=cls.reference)
        cls.cluster = slurm_cluster.Cluster()
        cls.addClassCleanup(cls.cluster.stop)

    @classmethod
    def forget(cls, keep=None):
        for name in ("out", "work"):
            if keep:
                (cls.folder / name).rename(keep / name)
            else:
                shutil.rmtree(cls.folder / name, ignore_errors=True)

    def setUp(self):
        self.forget()
        self.project.write_text(self.text)

    def tearDown(self):
        """No job of one test outlives it."""
        self.cluster.run("scancel", "--user=root")
        if (self.folder / "work" / "slurm" / "jobs.json").exists():
            self.cluster.wait_for_end([job["id"] for job in self.jobs()])

    def backsight(self, *arguments):
        return self.cluster.run(campaign.PROGRAM, *arguments)

    def submit(self, *options):
        run = self.backsight("run", self.project, "--executor", "slurm", *options)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertRegex(run.stdout, r"^\d+( \d+)*\n$")
        return run.stdout.split()

    def follow(self, *options):
        return subprocess.Popen([campaign.PROGRAM, "run", self.project, "--executor", "slurm",
                                 "--wait", *options], env=self.cluster.environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def result(self):
        path = self.folder / "work" / "slurm" / "result.json"
        self.assertTrue(path.exists(), self.logs())
        return json.loads(path.read_text())

    def logs(self):
        return "\n".join(f"{path.name}: {path.read_text()}" for path in
                         sorted((self.folder / "work" / "slurm" / "logs").iterdir()))

    def jobs(self):
        return json.loads((self.folder / "work" / "slurm" / "jobs.json").read_text())["jobs"]

    def expect_local_bytes(self, reference=None):
        reference = (reference or self.reference) / "out"
        names = campaign.files_of(self.folder / "out")
        self.assertEqual(names, campaign.files_of(reference))
        _, differing, errors = filecmp.cmpfiles(self.folder / "out", reference, names,
                                                shallow=False)
        self.assertEqual((differing, errors), ([], []))

    def grow(self):
        """Has the network decide which pairs are registered. Returns where the results of a local
        run are."""
        self.project.write_text(self.text + "pair_selection: {strategy: grow}\n")
        grown = self.folder / "grown"
        if not grown.exists():
            local = self.backsight("run", self.project, "--quiet")
            self.assertEqual(local.returncode, 0, local.stderr)
            grown.mkdir()
            self.forget(keep=grown)
        return grown

    def running_task_of(self, job):
        """The first task of an array, or the job, that is seen running."""
        end = time.monotonic() + 300
        while time.monotonic() < end:
            queue = self.cluster.run("squeue", "--noheader", "--array", "--states=RUNNING",
                                     "--format=%i", "--jobs=" + job).stdout.split()
            if queue:
                return queue[0]
            time.sleep(0.05)
        self.fail(f"no task of {job} ran")

    def wait_for_rounds(self, ids):
        """Until all jobs have ended, those of rounds that were begun meanwhile too."""
        self.cluster.wait_for_end(ids)
        while set(ids) != {job["id"] for job in self.jobs()}:
            ids = [job["id"] for job in self.jobs()]
            self.cluster.wait_for_end(ids)

    def wait_for_final_run(self):
        """Until the final job's program goes on. Slurm may drop a job that is requeued earlier."""
        end = time.monotonic() + 300
        while not (self.folder / "work" / "latest_run.json").exists():
            self.assertLess(time.monotonic(), end, "the final job's program did not begin")
            time.sleep(0.02)

    def kill_task_of(self, job):
        task = self.running_task_of(job)
        self.cluster.run("scancel", "--signal=KILL", "--full", task)
        return task

    def requeue_task_of(self, job):
        """As Slurm does when a node dies; without the pause that it makes then."""
        task = self.running_task_of(job)
        requeue = self.cluster.run("scontrol", "requeue", task)
        self.assertEqual(requeue.returncode, 0, requeue.stderr)
        end = time.monotonic() + 60
        while "BeginTime" not in self.cluster.run("squeue", "--noheader", "--format=%r",
                                                  "--jobs=" + task).stdout:
            self.assertLess(time.monotonic(), end, f"{task} was not queued again")
            time.sleep(0.2)
        self.cluster.run("scontrol", "update", "JobId=" + task, "StartTime=now")
        return task

    def test_killed_tasks_cost_nothing_but_time(self):
        """Submission, refusal of a second run, status, two killed tasks, and equal bytes."""
        stations, pairs, final = self.submit()
        for executor in ("local", "slurm"):
            second = self.backsight("run", self.project, "--executor", executor)
            self.assertEqual(second.returncode, 75, second.stderr)
            self.assertIn(f"{stations} {pairs} {final}", second.stderr)
        status = self.backsight("status", self.project).stdout
        self.assertRegex(status, rf"  {stations} stations, 4 task\(s\): \d+ (RUNNING|PENDING|CONF)")
        self.assertRegex(status, rf"  {final} final, 1 task\(s\): 1 PENDING")
        print("killed", self.kill_task_of(stations), "and", self.kill_task_of(pairs))
        self.cluster.wait_for_end([stations, pairs, final])
        self.assertEqual(self.result()["exit_code"], 0, self.logs())
        self.assertEqual(self.result()["job"], final)
        self.expect_local_bytes()
        self.assertEqual(len(list((self.folder / "work" / "slurm" / "logs").iterdir())), 4 + 6 + 1)
        status = self.backsight("status", self.project).stdout
        self.assertRegex(status, rf"  {final} final, 1 task\(s\): ended\n  result: Complete")
        again = self.backsight("run", self.project, "--quiet")
        self.assertEqual(again.returncode, 0, again.stderr)

    def test_what_is_started_again_gives_the_same_bytes(self):
        """A station, pairs, and the final job."""
        ids = self.submit()
        print("requeued", *(self.requeue_task_of(job) for job in ids[:2]))
        self.wait_for_final_run()
        print("requeued", self.requeue_task_of(ids[2]))
        self.cluster.wait_for_end(ids)
        if not (self.folder / "work" / "slurm" / "result.json").exists():
            # Slurm may drop what it requeues while it ends: the same command goes on from there.
            print("Slurm dropped", ids[2])
            ids = self.submit()
            self.cluster.wait_for_end(ids)
        self.assertEqual(self.result()["exit_code"], 0, self.logs())
        self.assertEqual(self.result()["job"], ids[-1])
        self.expect_local_bytes()

    def test_all_but_the_final_job_precompute(self):
        """The final run finds every station, and every pair registered in full."""
        ids = self.submit("--slurm-options", "--comment='two words' --nice=1")
        self.cluster.run("scancel", ids[2])
        self.cluster.wait_for_end(ids)
        status = self.backsight("status", self.project).stdout
        self.assertIn("stations: 4 of 4 up to date", status)
        self.assertIn("pairs: 6 of 6 up to date", status)
        local = self.backsight("run", self.project, "--quiet")
        self.assertEqual(local.returncode, 0, local.stderr)
        self.expect_local_bytes()

    def test_growing_discovery_goes_in_rounds(self):
        """Coordinators have every attempt made by tasks; the final run computes none."""
        grown = self.grow()
        follower = self.follow()
        _, stderr = follower.communicate(timeout=1200)
        self.assertEqual(follower.returncode, 0, stderr + self.logs())
        self.expect_local_bytes(grown)
        parts = [job["part"] for job in self.jobs()]
        self.assertGreaterEqual(parts.count("coordinator"), 2, self.logs())
        self.assertEqual(parts.count("pairs"), parts.count("coordinator") - 1, self.logs())
        log = self.logs()
        self.assertRegex(log, r"[1-9]\d* attempts at pairs are stored, [1-9]\d* are needed next")
        self.assertRegex(log, r"[1-9]\d* attempts at pairs are stored, 0 are needed next")

    def test_coordinator_that_is_started_again_does_no_harm(self):
        """Where Slurm begins the final job before it, it leaves everything to that."""
        grown = self.grow()
        ids = self.submit()
        print("requeued", self.requeue_task_of(ids[1]))
        self.wait_for_rounds(ids)
        self.assertEqual(self.result()["exit_code"], 0, self.logs())
        self.assertEqual(self.result()["job"], ids[2])
        self.expect_local_bytes(grown)

    def test_without_its_coordinator_the_final_run_does_all_itself(self):
        grown = self.grow()
        ids = self.submit()
        self.cluster.run("scancel", self.running_task_of(ids[1]))
        self.wait_for_rounds(ids)
        self.assertEqual(self.result()["exit_code"], 0, self.logs())
        self.expect_local_bytes(grown)

    def test_wait_ends_as_the_run(self):
        follower = self.follow()
        stdout, stderr = follower.communicate(timeout=1200)
        self.assertEqual(follower.returncode, 0, stderr + self.logs())
        self.assertRegex(stdout, r"^Complete: .* Report: .*report\.html\n$")
        self.assertRegex(stderr, r"submitted jobs \d+ \d+ \d+")
        self.assertIn("stations", stderr)
        self.expect_local_bytes()

    def test_wait_returns_the_code_of_a_partial_run(self):
        scan = self.folder / "scans" / "S4.ptx"
        original = scan.read_bytes()
        half = original.rfind(b"\n", 0, len(original) // 2) + 1
        self.project.write_text(self.text + "gates: {require_all_stations: false}\n")
        try:
            scan.write_bytes(original[:half] + b"12.5 garbage\n" + original[half:])
            follower = self.follow("--quiet")
            stdout, stderr = follower.communicate(timeout=1200)
        finally:
            scan.write_bytes(original)
        self.assertEqual(follower.returncode, 3, stderr + self.logs())
        self.assertRegex(stdout, r"^Partial: ")

    def test_interrupted_wait_leaves_the_jobs(self):
        follower = self.follow("--slurm-options=--begin=now+1hour")
        jobs = self.folder / "work" / "slurm" / "jobs.json"
        while not jobs.exists() or len(self.jobs()) < 3:
            time.sleep(0.05)
        time.sleep(2)
        stdout, stderr = interrupt(follower)
        self.assertEqual(follower.returncode, 130, stderr)
        found = re.search(r"To cancel them: scancel ((\d+ ?)+)", stdout)
        self.assertTrue(found, stdout)
        queue = self.cluster.run("squeue", "--noheader", "--format=%F").stdout.split()
        self.assertEqual(sorted(set(queue)), sorted(found[1].split()))

    def test_what_slurm_refuses_is_said(self):
        run = self.backsight("run", self.project, "--executor", "slurm",
                             "--slurm-options", "--partition=nowhere")
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn("invalid partition specified: nowhere", run.stderr)
        self.assertFalse((self.folder / "work" / "slurm" / "jobs.json").exists())
        run = self.backsight("run", self.project, "--executor", "slurm", "--slurm-options", "'x")
        self.assertEqual(run.returncode, 2)
        self.assertIn("quote", run.stderr)

    def test_where_slurm_cannot_be_asked_nothing_is_risked(self):
        ids = self.submit("--slurm-options=--hold")
        without = {**os.environ, "PATH": "/nowhere"}
        refused = campaign.run(self.project, "--quiet", env=without)
        self.assertEqual(refused.returncode, 75)
        self.assertIn("Slurm cannot be asked", refused.stderr.decode())
        self.assertIn(" ".join(ids), refused.stderr.decode())
        self.cluster.run("scancel", *ids)
        forced = campaign.run(self.project, "--quiet", "--force", env=without)
        self.assertEqual(forced.returncode, 0, forced.stderr)


if __name__ == "__main__":
    reason = slurm_cluster.why_not()
    if reason:
        print("SKIPPED:", reason)
        sys.exit(77)
    unittest.main()

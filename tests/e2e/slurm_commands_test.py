"""What is asked of Slurm's commands, and what becomes of answers that are late, odd or none: with
programs of the test's own in place of sbatch, squeue, scancel and scontrol."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import campaign

# Each writes its words down. sbatch counts ids up from 1; what else they do a test may add.
FAKES = {
    "sbatch": 'n=$(grep -c "^sbatch " "$FAKE/calls")\n%s\necho "$n"',
    "squeue": '%s\ncat "$FAKE/queue"',
    "scancel": "%s",
    "scontrol": "%s",
}


class SlurmCommands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="backsight-slurm-commands-")
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.project = cls.folder / "survey.yaml"
        cls.text = campaign.simulate(cls.folder) + "resources: {threads: 1, memory_gb: 1}\n"
        cls.work = cls.folder / "work"
        cls.jobs = cls.work / "slurm" / "jobs.json"
        cls.tools = cls.folder / "bin"
        cls.tools.mkdir()
        cls.environment = {"PATH": f"{cls.tools}:/usr/bin:/bin", "FAKE": str(cls.folder)}

    def setUp(self):
        for name in ("out", "work"):
            shutil.rmtree(self.folder / name, ignore_errors=True)
        self.project.write_text(self.text)
        (self.folder / "calls").write_text("")
        self.queue()
        for name in FAKES:
            self.fake(name)

    def fake(self, name, more=""):
        path = self.tools / name
        path.write_text(f'#!/bin/sh\necho "{name} $*" >>"$FAKE/calls"\n{FAKES[name] % more}\n')
        path.chmod(0o755)

    def queue(self, *jobs):
        """What squeue answers: jobs with their states."""
        (self.folder / "queue").write_text("".join(f"{job}\n" for job in jobs))

    def calls(self, name):
        lines = (self.folder / "calls").read_text().splitlines()
        return [line.removeprefix(name + " ") for line in lines if line.startswith(name + " ")]

    def start(self, *arguments, **more):
        return subprocess.Popen([campaign.PROGRAM, *arguments], env={**self.environment, **more},
                                text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def backsight(self, *arguments, **more):
        process = self.start(*arguments, **more)
        stdout, stderr = process.communicate()
        return subprocess.CompletedProcess(arguments, process.returncode, stdout, stderr)

    def submit(self, *options):
        return self.backsight("run", self.project, "--executor", "slurm", *options)

    def write_jobs(self, *parts):
        """Ids count up from 1."""
        self.jobs.parent.mkdir(parents=True, exist_ok=True)
        jobs = [{"id": str(i), "part": part, "tasks": 1} for i, part in enumerate(parts, 1)]
        self.jobs.write_text(json.dumps({"schema_version": 1, "submitted_utc": "now",
                                         "jobs": jobs}))

    def ids(self):
        return [job["id"] for job in json.loads(self.jobs.read_text())["jobs"]]

    def wait_until(self, is_so):
        end = time.monotonic() + 120
        while not is_so():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)

    def interrupt_when(self, process, is_so):
        """Ctrl-C; returns what the process printed. It must end by itself."""
        try:
            self.wait_until(is_so)
            process.send_signal(signal.SIGINT)
            return process.communicate(timeout=30)
        except BaseException:
            process.kill()
            process.communicate()
            raise

    def test_jobs_wait_for_each_other(self):
        run = self.submit("--slurm-options=-p cpu")
        self.assertEqual((run.returncode, run.stdout), (0, "1 2 3\n"), run.stderr)
        stations, pairs, final = self.calls("sbatch")
        self.assertNotIn("--dependency", stations)
        self.assertIn("--array=0-3", stations)
        self.assertIn("--dependency=afterany:1", pairs)
        self.assertIn("--dependency=afterany:2", final)
        self.assertIn(" -p cpu ", final)

    def test_jobs_before_a_refused_one_are_cancelled(self):
        self.fake("sbatch", 'if [ "$n" = 3 ]; then echo "no such account" >&2; exit 1; fi')
        run = self.submit()
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn("no such account", run.stderr)
        self.assertEqual(self.calls("scancel"), ["1 2"])
        self.assertFalse(self.jobs.exists())

    def test_jobs_that_cannot_be_cancelled_are_not_forgotten(self):
        self.fake("sbatch", 'if [ "$n" = 3 ]; then echo "no such account" >&2; exit 1; fi')
        self.fake("scancel", 'echo "Unable to contact slurm controller" >&2; exit 1')
        self.queue("1 RUNNING", "2 PENDING")
        run = self.submit()
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn("cancel them: scancel 1 2", run.stderr)
        self.assertEqual(self.ids(), ["1", "2"])
        again = self.submit()
        self.assertEqual(again.returncode, 75, again.stderr)
        self.assertIn("scancel 1 2", again.stderr)
        self.queue()  # they have ended meanwhile, which is no fault of scancel's
        self.fake("sbatch")
        self.assertEqual(self.submit().returncode, 0)

    def test_interrupted_wait_names_the_jobs_of_all_rounds(self):
        self.queue("3 PENDING")
        follower = self.start("run", self.project, "--executor", "slurm", "--wait")
        self.wait_until(lambda: self.calls("squeue"))
        self.write_jobs("stations", "coordinator", "final", "pairs", "coordinator")
        stdout, stderr = self.interrupt_when(follower, lambda: True)
        self.assertEqual(follower.returncode, 130, stderr)
        self.assertTrue(stdout.endswith("To cancel them: scancel 1 2 3 4 5\n"), stdout)

    def test_a_run_that_may_begin_forgets_the_jobs(self):
        self.write_jobs("stations", "pairs", "final")
        (self.tools / "squeue").unlink()
        refused = self.backsight("run", self.project, "--quiet")
        self.assertEqual(refused.returncode, 75, refused.stderr)
        self.assertIn("--force", refused.stderr)
        for more in (["--force"], []):
            run = self.backsight("run", self.project, "--quiet", *more)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertFalse(self.jobs.exists())

    def test_a_final_job_that_is_started_again_forgets_its_result(self):
        self.write_jobs("final")
        result = self.jobs.parent / "result.json"
        result.write_text('{"schema_version": 1, "job": "1", "exit_code": 75, "summary": "old"}')
        run = self.start("run", self.project, "--final-job", SLURM_JOB_ID="1")
        self.interrupt_when(run, lambda: not result.exists())
        self.assertEqual(run.returncode, 130)
        self.assertFalse(result.exists())

    def test_status_says_whether_jobs_are_going(self):
        def status():
            return self.backsight("status", self.project).stdout

        self.assertIn("courtyard: no run is going\n", status())
        self.write_jobs("stations", "pairs", "final")
        self.queue("1 RUNNING", "1 RUNNING", "3 PENDING")
        self.assertRegex(status(), "courtyard: jobs are going\nSlurm jobs, submitted at now:\n"
                                   r"  1 stations, 1 task\(s\): 2 RUNNING\n  2 pairs, .* ended\n"
                                   r"  3 final, 1 task\(s\): 1 PENDING\n")
        self.queue()
        self.assertIn("courtyard: no run is going\n", status())
        self.fake("squeue", "exit 1")
        self.assertIn("courtyard: it is not known whether jobs are going\n", status())

    def coordinate(self, job="2"):
        self.project.write_text(self.text + "pair_selection: {strategy: grow}\n")
        return self.backsight("work", self.project, "--coordinate", SLURM_JOB_ID=job)

    def dependencies(self):
        """Of the jobs that were submitted, and what else the final job was told to wait for."""
        submitted = [re.search(r"--dependency=afterany:(\d+)", call) for call in
                     self.calls("sbatch")]
        return [found and found[1] for found in submitted], self.calls("scontrol")

    def test_a_round_begins_and_the_final_job_waits_for_each_of_its_jobs(self):
        self.write_jobs("stations", "coordinator", "final")
        (self.folder / "calls").write_text("sbatch of before\n" * 3)
        self.queue("2 RUNNING", "3 PENDING")
        run = self.coordinate()
        self.assertEqual(run.returncode, 0, run.stderr)
        calls = [line.split()[0] for line in (self.folder / "calls").read_text().splitlines()]
        self.assertEqual([call for call in calls[3:] if call != "squeue"],
                         ["sbatch", "scontrol", "sbatch", "scontrol"])
        self.assertEqual(self.dependencies(),
                         ([None] * 4 + ["4"], ["update JobId=3 Dependency=afterany:4",
                                               "update JobId=3 Dependency=afterany:5"]))
        self.assertEqual(self.ids(), ["1", "2", "3", "4", "5"])

    def test_a_coordinator_that_is_started_again_begins_no_second_round(self):
        for jobs, submitted, waits_for in (
                (["pairs"], ["4"], ["4", "5"]),
                (["pairs", "coordinator"], [], ["5"]),
                (["pairs", "coordinator", "pairs", "coordinator"], [], ["7"])):
            with self.subTest(jobs=jobs):
                self.setUp()
                self.write_jobs("stations", "coordinator", "final", *jobs)
                (self.folder / "calls").write_text("sbatch of before\n" * (3 + len(jobs)))
                self.queue("2 RUNNING", "3 PENDING")
                run = self.coordinate()
                self.assertEqual(run.returncode, 0, run.stderr)
                ids, told = self.dependencies()
                self.assertEqual(ids[3 + len(jobs):], submitted)
                self.assertEqual(told, [f"update JobId=3 Dependency=afterany:{job}"
                                        for job in waits_for])

    def test_a_coordinator_begins_nothing_when_no_final_job_waits(self):
        for final in ([], ["3 RUNNING"]):
            self.setUp()
            self.write_jobs("stations", "coordinator", "final")
            self.queue("2 RUNNING", *final)
            run = self.coordinate()
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(self.dependencies(), ([], []))

    def test_a_round_that_fails_is_taken_back(self):
        self.write_jobs("stations", "coordinator", "final")
        (self.folder / "calls").write_text("sbatch of before\n" * 3)
        self.queue("2 RUNNING", "3 PENDING")
        self.fake("scontrol", "exit 1")
        run = self.coordinate()
        self.assertEqual(run.returncode, 75, run.stderr)
        self.assertEqual(self.calls("scancel"), ["4"])
        self.assertEqual(self.ids(), ["1", "2", "3"])

    def test_a_round_is_submitted_whole_when_a_stop_is_requested(self):
        self.write_jobs("stations", "coordinator", "final")
        (self.folder / "calls").write_text("sbatch of before\n" * 3)
        self.queue("2 RUNNING", "3 PENDING")
        self.fake("sbatch", '[ "$n" = 4 ] && kill -TERM "$PPID" && sleep 1')
        self.assertEqual(self.coordinate().returncode, 0)
        self.assertEqual(self.ids(), ["1", "2", "3", "4", "5"])
        self.assertEqual(self.calls("scontrol")[-1], "update JobId=3 Dependency=afterany:5")

    def test_the_final_job_leaves_alone_what_tasks_may_be_writing(self):
        self.write_jobs("final")
        half = self.work / "stations" / "S1" / "station.artifact.tmp-123-1"
        half.parent.mkdir(parents=True)
        half.write_text("half")
        run = self.backsight("run", self.project, "--final-job", "--quiet", SLURM_JOB_ID="1")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue(half.exists())
        run = self.backsight("run", self.project, "--quiet")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertFalse(half.exists())

    def test_ctrl_c_ends_a_submission_that_hangs(self):
        """What was submitted is cancelled, and no command is left behind."""
        self.fake("sbatch", 'if [ "$n" = 3 ]; then echo $$ >"$FAKE/hangs"; exec sleep 1000; fi')
        run = self.start("run", self.project, "--executor", "slurm")
        hangs = self.folder / "hangs"
        _, stderr = self.interrupt_when(run, lambda: hangs.exists() and hangs.read_text())
        self.assertEqual(run.returncode, 130, stderr)
        self.assertFalse(os.path.exists(f"/proc/{hangs.read_text().strip()}"))
        self.assertEqual(self.calls("scancel"), ["1 2"])
        self.assertFalse(self.jobs.exists())


if __name__ == "__main__":
    unittest.main()

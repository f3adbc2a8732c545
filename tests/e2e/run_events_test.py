"""The event log of real runs against docs/schema/events.schema.json, and the one line on stdout."""

import json
import os
import pathlib
import signal
import subprocess
import tempfile
import unittest

import jsonschema

import campaign

VALIDATOR = jsonschema.Draft202012Validator(
    json.loads((campaign.ROOT / "docs/schema/events.schema.json").read_text()))


def events_of(log):
    """The events of a log's bytes; raises where a line is not what the schema says."""
    if not log.endswith(b"\n"):
        raise ValueError("the last line has no end")
    events = [json.loads(line.decode("utf-8")) for line in log.splitlines()]
    for event in events:
        VALIDATOR.validate(event)
    return events


class RunEvents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="backsight-events-")
        # A folder whose name is Latin-1: no valid UTF-8.
        cls.folder = pathlib.Path(cls.scratch.name) / os.fsdecode(b"caf\xe9")
        cls.folder.mkdir()
        cls.good = campaign.simulate(cls.folder)
        for name in ("empty.ptx", "empty2.ptx"):
            (cls.folder / name).write_text("")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def project(self, text):
        path = self.folder / "survey.yaml"
        path.write_text(text)
        return path

    def expect(self, run, exit_code, beginning):
        """One line on stdout, whatever else."""
        self.assertEqual(run.returncode, exit_code, run.stderr)
        self.assertEqual(run.stdout.count(b"\n"), 1, run.stdout)
        self.assertTrue(run.stdout.endswith(b"\n"), run.stdout)
        self.assertTrue(run.stdout.startswith(beginning), run.stdout)

    def test_complete_run_logs_what_the_schema_says(self):
        log = self.folder / "logs" / "night.jsonl"
        run = campaign.run(self.project(self.good), "--threads", "2", "--log-json", log)
        self.expect(run, 0, b"Complete: all 4 stations placed")
        self.assertIn(b"report.html", run.stdout)
        events = events_of(log.read_bytes())
        first, last = events[0], events[-1]
        self.assertEqual((first["event"], first["stations"], first["threads"]),
                         ("run_started", 4, 2))
        self.assertIn("caf\N{REPLACEMENT CHARACTER}/survey.yaml", first["project"])
        self.assertEqual((last["event"], last["exit_code"]), ("run_finished", 0))
        self.assertTrue(run.stdout.decode("latin-1").startswith(last["verdict"]))
        finished = [event["stage"] for event in events if event["event"] == "stage_finished"]
        manifest = json.loads((self.folder / "out" / "manifest.json").read_bytes())
        self.assertEqual(finished, [stage["stage"] for stage in manifest["stages"]])
        for stage, units in (("stations", 4), ("pairs", 6)):  # pairs may be tried once more
            steps = [(event["done"], event["total"]) for event in events
                     if event["event"] == "progress" and event["stage"] == stage]
            self.assertEqual(steps[0][1], units)
            if stage == "stations":  # pairs may be done beside them
                self.assertEqual(steps[0][0], 0)
            self.assertEqual(steps[-1][0], steps[-1][1])
            self.assertEqual(steps, sorted(steps))
        times = [event["time_utc"] for event in events]
        self.assertEqual(times, sorted(times))
        self.refuse_damaged(log.read_bytes())

    def refuse_damaged(self, log):
        """Everything that can be wrong with a line is found."""
        lines = log.splitlines(keepends=True)
        for number, line in enumerate(lines[:1] + lines[-1:]):
            event = json.loads(line)
            damaged = [line[:-2] + b"\n", line[:-1], line.replace(b"time_utc", b"time"), b"\n",
                       line.replace(b"Z\"", b"\"", 1), line.replace(b'"event"', b'"more":1,"event"'),
                       line.replace(b'"event":"', b'"event":"x'), line[:40] + b"\xe9" + line[40:]]
            for key in event:
                without = {name: value for name, value in event.items() if name != key}
                damaged.append(json.dumps(without).encode() + b"\n")
                damaged.append(json.dumps({**event, key: [1]}).encode() + b"\n")
            for bad in damaged:
                with self.subTest(line=number, damaged=bad):
                    with self.assertRaises((ValueError, jsonschema.ValidationError)):
                        events_of(bad)

    def test_partial_run_survives_a_full_disk_of_the_log(self):
        bad = self.good.replace("outputs:", "  - {id: BAD, scan: empty.ptx}\noutputs:")
        run = campaign.run(self.project(bad), "--log-json", "/dev/full")
        self.expect(run, 3, b"Partial: 4 of 5 stations placed")
        self.assertEqual(run.stderr.count(b"the event log goes no further"), 1, run.stderr)

    def test_summary_that_stdout_does_not_take_is_said(self):
        project = self.project(self.good)
        with open("/dev/full", "wb") as full:
            run = subprocess.run([campaign.PROGRAM, "run", project, "--quiet"], stdout=full,
                                 stderr=subprocess.PIPE, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertRegex(run.stderr, rb"stdout did not take the summary line .*: Complete: all 4")

    def test_failed_gate_is_said_although_nobody_reads_the_log_any_more(self):
        project = self.project(self.good + "gates: {max_station_sigma_mm: 0.001}\n")
        process, log = self.start_with_pipe(project)
        with log:
            log.readline()
        run = self.finish(process)
        self.expect(run, 4, b"Gate max_station_sigma_mm failed")
        self.assertEqual(run.stderr.count(b"Broken pipe"), 1, run.stderr)

    def test_no_usable_input_is_said(self):
        project = self.project("schema_version: 1\nname: n\nstations:\n"
                               "  - {id: A, scan: empty.ptx}\n  - {id: B, scan: empty2.ptx}\n")
        log = self.folder / "none.jsonl"
        run = campaign.run(project, "--log-json", log)
        self.expect(run, 5, b"No usable input")
        self.assertEqual(events_of(log.read_bytes())[-1]["exit_code"], 5)

    def test_interrupted_run_says_what_is_kept_and_how_to_continue(self):
        for number, code in ((signal.SIGTERM, 143), (signal.SIGINT, 130)):
            with self.subTest(signal=number):
                self.interrupt(number, code)

    @staticmethod
    def start_with_pipe(project):
        """A run that goes on, and the end of the pipe that its log can be read from."""
        reader, writer = os.pipe()
        process = subprocess.Popen(
            [campaign.PROGRAM, "run", project, "--log-json", f"/dev/fd/{writer}"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, pass_fds=[writer])
        os.close(writer)
        return process, os.fdopen(reader, "rb")

    @staticmethod
    def finish(process):
        out, err = process.communicate()
        return subprocess.CompletedProcess([], process.returncode, out, err)

    def interrupt(self, number, code):
        """Stops the run at its first progress."""
        process, log = self.start_with_pipe(self.project(self.good))
        with log:
            lines = [log.readline()]
            while b'"progress"' not in lines[-1]:
                lines.append(log.readline())
            process.send_signal(number)
            lines.append(log.read())
        run = self.finish(process)
        self.expect(run, code, b"Interrupted: ")
        self.assertIn(b"same command", run.stdout)
        events = events_of(b"".join(lines))
        self.assertEqual([event["event"] for event in events[-2:]], ["interrupted", "run_finished"])
        self.assertEqual(events[-2]["signal"], signal.Signals(number).name)
        self.assertEqual(events[-1]["exit_code"], code)

    def test_failure_amid_the_run_is_said(self):
        out = self.folder / "blocked"
        (out / "poses.csv").mkdir(parents=True)
        log = self.folder / "blocked.jsonl"
        run = campaign.run(self.project(self.good), "--out", out, "--log-json", log)
        self.expect(run, 2, b"Failed: ")
        self.assertIn(b"error: ", run.stderr)
        events = events_of(log.read_bytes())
        self.assertEqual((events[-2]["event"], events[-2]["level"]), ("message", "error"))
        self.assertEqual((events[-1]["event"], events[-1]["exit_code"]), ("run_finished", 2))

    def test_refused_project_is_logged_but_has_no_summary(self):
        project = self.project(self.good.replace("scans/S1.ptx", "scans/nowhere.ptx"))
        log = self.folder / "refused.jsonl"
        run = campaign.run(project, "--log-json", log)
        self.assertEqual((run.returncode, run.stdout), (2, b""))
        events = events_of(log.read_bytes())
        self.assertEqual([event["event"] for event in events], ["message", "run_finished"])
        self.assertIn("nowhere.ptx", events[0]["text"])

    def test_file_that_is_no_log_is_not_written_over(self):
        project = self.project(self.good)
        run = campaign.run(project, "--log-json", project)
        self.assertEqual(run.returncode, 2)
        self.assertIn(b"no event log", run.stderr)
        self.assertEqual(project.read_text(), self.good)


if __name__ == "__main__":
    unittest.main()

"""Runs that are killed, repeated, damaged and changed: what is finished is kept, and only that."""

import filecmp
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import campaign

TEMPORARY = re.compile(r"\.tmp-\d+-\d+$")


def simulate_six(folder):
    """Six stations about a courtyard, with control, scanned coarsely. Returns the project file."""
    scene = (campaign.ROOT / "tests/e2e/scenes/courtyard.yaml").read_text()
    scene, found = re.subn(r"step_deg: 0\.25", "step_deg: 0.6", scene)
    assert found == 1, "the scene has another scanner now"
    scene, found = re.subn(r"(  - \{id: S4, .*\}\n)",
                           r"\1  - {id: S5, position_m: [0.5, 7.5]}\n"
                           r"  - {id: S6, position_m: [-0.5, -8.5]}\n", scene)
    assert found == 1, "the scene has other stations now"
    path = folder / "scene.yaml"
    path.write_text(scene)
    subprocess.run([campaign.PROGRAM, "simulate", path, folder], check=True, capture_output=True)
    project = folder / "courtyard.yaml"
    text = project.read_text().replace(
        "thin_m: 0.01}]", "thin_m: 0.02}]\n  stations: {format: e57, path: out/registered}")
    project.write_text(text)
    return project


def start(project, threads):
    return subprocess.Popen([campaign.PROGRAM, "run", project, "--threads", str(threads), "--quiet"],
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def artifacts_of(folder):
    """What is finished, and when each was written."""
    return {str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.stat().st_ino)
            for path in (folder / "work").rglob("*.artifact")}


class Resume(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="backsight-resume-")
        cls.folder = pathlib.Path(cls.scratch.name) / "survey"
        cls.folder.mkdir()
        cls.project = simulate_six(cls.folder)
        cls.text = cls.project.read_text()
        cls.run_whole(threads=1)
        cls.reference = pathlib.Path(cls.scratch.name) / "reference"
        shutil.copytree(cls.folder / "out", cls.reference / "out")
        shutil.copytree(cls.folder / "work", cls.reference / "work")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def setUp(self):
        """The finished run as it was, with its times, whatever the test before did."""
        self.project.write_text(self.text)
        self.forget()
        shutil.copytree(self.reference / "out", self.folder / "out")
        shutil.copytree(self.reference / "work", self.folder / "work")
        if "everything is up to date" not in self.dry_run():  # a scan was written to
            self.assertEqual(self.run_whole(), [])
        self.before = artifacts_of(self.folder)

    @classmethod
    def forget(cls):
        shutil.rmtree(cls.folder / "out", ignore_errors=True)
        shutil.rmtree(cls.folder / "work", ignore_errors=True)

    @classmethod
    def run_whole(cls, threads=2, exit_code=0):
        """Runs to the end; returns the warnings of the log."""
        process = start(cls.project, threads)
        _, stderr = process.communicate()
        assert process.returncode == exit_code, (process.returncode, stderr)
        return [line for line in stderr.decode().splitlines() if "damaged" in line]

    def expect_reference(self):
        names = campaign.files_of(self.folder / "out")
        self.assertEqual(names, campaign.files_of(self.reference / "out"))
        _, differing, errors = filecmp.cmpfiles(self.folder / "out", self.reference / "out", names,
                                                shallow=False)
        self.assertEqual((differing, errors), ([], []))

    def redone(self):
        """Names of artifacts written since setUp, but what is known of scan files."""
        now = artifacts_of(self.folder)
        return sorted(name for name, written in now.items()
                      if self.before.get(name) != written and not name.startswith("work/scans/"))

    def begin(self):
        """A run that has noted its beginning."""
        process = start(self.project, 2)
        note = self.folder / "work" / "latest_run.json"
        while process.poll() is None:
            if f'"process": {process.pid},' in note.read_text():
                return process
        raise AssertionError("the run ended before it could be looked at")

    def status(self, *folders):
        run = subprocess.run([campaign.PROGRAM, "status", self.project, *folders],
                             capture_output=True, check=True, text=True)
        return run.stdout

    def dry_run(self):
        run = subprocess.run([campaign.PROGRAM, "run", self.project, "--dry-run"],
                             capture_output=True, check=True, text=True)
        return run.stdout

    def test_killed_at_any_moment_it_goes_on(self):
        """50 kills; a campaign that came to its end is begun anew."""
        dice = random.Random(20240607)
        began = time.monotonic()
        self.forget()
        self.run_whole()
        whole_s = time.monotonic() - began
        self.forget()
        kills = ends = 0
        finished = {}
        while kills < 50:
            process = start(self.project, dice.choice([1, 2, 4]))
            time.sleep(dice.uniform(0.0, whole_s / 3))
            process.send_signal(signal.SIGKILL)
            _, stderr = process.communicate()
            now = artifacts_of(self.folder) if (self.folder / "work").exists() else {}
            for name, written in finished.items():
                self.assertEqual(now.get(name), written, f"{name} was done twice")
            finished = now
            if process.returncode == -signal.SIGKILL:
                kills += 1
                continue
            self.assertEqual(process.returncode, 0, stderr)
            self.expect_reference()
            self.forget()
            finished = {}
            ends += 1
        self.run_whole()
        now = artifacts_of(self.folder)
        self.assertTrue(all(now.get(name) == written for name, written in finished.items()))
        self.expect_reference()
        self.assertEqual([str(path) for path in self.folder.rglob("*")
                          if TEMPORARY.search(path.name)], [])
        print(f"{kills} kills, {ends + 1} campaigns came to their end, {whole_s:.1f} s undisturbed")

    def test_finished_run_does_nothing_again(self):
        self.assertIn("everything is up to date", self.dry_run())
        self.run_whole(threads=4)
        self.assertEqual(self.redone(), [])
        self.expect_reference()

    def test_moved_folder_gives_the_same_bytes(self):
        moved = self.folder.parent / "elsewhere"
        self.folder.rename(moved)
        try:
            run = campaign.run(moved / "courtyard.yaml", "--quiet")
            self.assertEqual(run.returncode, 0, run.stderr)
        finally:
            moved.rename(self.folder)
        self.expect_reference()
        self.assertFalse([name for name in self.redone() if not name.startswith("work/outputs/")])
        self.assertEqual({name: written for name, written in artifacts_of(self.folder).items()
                          if name.startswith("work/scans/")},
                         {name: written for name, written in self.before.items()
                          if name.startswith("work/scans/")})

    def test_changed_scan_costs_what_depends_on_it(self):
        scan = self.folder / "scans" / "S3.ptx"
        original = scan.read_bytes()
        lines = original.splitlines(keepends=True)
        lines[2000:2050] = lines[1950:2000]
        try:
            scan.write_bytes(b"".join(lines))
            plan = self.dry_run()
            self.assertRegex(plan, r"station S3: not known \(only a run reads its scan")
            self.assertRegex(plan, r"pair S3 S1 full: not known \(station S3\)")
            self.assertRegex(plan, r"network: not known")
            self.assertNotRegex(plan, r"station S1|pair S2 S1 full")
            self.run_whole()
        finally:
            scan.write_bytes(original)
        for name in self.redone():
            self.assertRegex(name, r"S3|network/|outputs/")
        self.assertIn("work/stations/S3/station.artifact", self.redone())

    def test_changed_option_costs_what_reads_it(self):
        self.project.write_text(self.text + "network: {score_noise: 0.011}\n")
        self.assertRegex(self.dry_run(), r"network: outdated \(network\.score_noise\)")
        self.run_whole()
        self.assertTrue(self.redone())
        for name in self.redone():
            self.assertRegex(name, r"network/|outputs/")

    def test_changed_control_costs_the_outputs(self):
        text, found = re.subn(r"(\{id: P1, .*sigma_m: \[)", r"\g<1>1", self.text)
        self.assertEqual(found, 1)
        self.project.write_text(text)  # its sigma is larger by a metre now
        self.assertRegex(self.dry_run(), r"merged\.las: outdated \(control P1\)")
        self.run_whole()
        self.assertTrue(self.redone())
        for name in self.redone():
            self.assertRegex(name, r"work/outputs/")

    def test_excluded_pair_costs_the_network(self):
        self.project.write_text(self.text + "pairs: {exclude: [[S1, S2]]}\n")
        self.assertRegex(self.dry_run(), r"network: outdated \(pairs\)")
        self.run_whole()
        self.assertIn("work/network/network.artifact", self.redone())
        for name in self.redone():
            self.assertRegex(name, r"network/|outputs/|symmetries|predicted|thorough")
        self.assertIn("everything is up to date", self.dry_run())

    def test_damaged_artifacts_are_found_and_made_anew(self):
        dice = random.Random(5)
        damaged = sorted(name for name in self.before if not name.startswith("work/scans/"))
        for name in damaged:
            path = self.folder / name
            content = bytearray(path.read_bytes())
            how = dice.randrange(3)
            if how == 0:
                content = content[:dice.randrange(len(content))]
            elif how == 1:
                content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
            else:
                content += b"more"
            path.write_bytes(content)
        complaints = self.run_whole()
        for name in damaged:  # also where its key merely looks like another
            self.assertTrue(any(name in line for line in complaints), name)
        self.expect_reference()
        self.assertEqual(self.redone(), damaged)

    def test_output_that_was_touched_is_written_again(self):
        cloud = self.folder / "out" / "merged.las"
        cloud.write_bytes(cloud.read_bytes()[:-30])
        (self.folder / "out" / "registered" / "S2.e57").unlink()
        self.assertRegex(self.dry_run(), r"S2\.e57: outdated \(its files are gone")
        self.assertRegex(self.dry_run(), r"merged\.las: outdated \(its files are gone")
        self.run_whole()
        self.expect_reference()
        self.assertEqual(len(self.redone()), 2)

    def test_split_cloud_is_written_again_where_a_part_is_gone(self):
        self.project.write_text(self.text.replace("thin_m: 0.02}", "thin_m: 0.02, max_points: 20000}"))
        self.run_whole()
        parts = sorted((self.folder / "out").glob("merged-*.las"))
        self.assertGreater(len(parts), 2)
        before = [part.read_bytes() for part in parts]
        self.assertIn("everything is up to date", self.dry_run())
        parts[1].unlink()
        self.assertRegex(self.dry_run(), r"merged\.las: outdated \(its files are gone")
        self.run_whole()
        self.assertEqual([part.read_bytes() for part in parts], before)

    def test_ranking_of_pairs_is_kept(self):
        self.project.write_text(self.text + "pair_selection: {strategy: grow}\n")
        self.run_whole()
        self.before = artifacts_of(self.folder)
        self.assertIn("work/network/ranking.artifact", self.before)
        (self.folder / "work" / "network" / "network.artifact").unlink()
        self.run_whole()
        self.assertEqual(self.redone(), ["work/network/network.artifact"])

    def test_second_run_is_refused_by_name(self):
        self.forget()
        (self.folder / "work").mkdir()
        (self.folder / "work" / "progress.json").write_text(
            '{"stage": "merge", "done": 1, "total": 1}\n')  # as last night's run left it
        first = start(self.project, 1)
        try:
            lock = self.folder / "work" / "run.lock"
            while not (lock.exists() and lock.read_text()):
                time.sleep(0.01)
            second = campaign.run(self.project, "--quiet")
            status = subprocess.run([campaign.PROGRAM, "status", self.project],
                                    capture_output=True, text=True, check=True)
        finally:
            first.kill()
            first.communicate()
        self.assertEqual(second.returncode, 75)
        self.assertIn(f"{os.uname().nodename}, process {first.pid}", second.stderr.decode())
        self.assertIn(f"process {first.pid}", status.stdout)
        self.assertNotIn("merge 1 of 1", status.stdout)
        status = subprocess.run([campaign.PROGRAM, "status", self.project], capture_output=True,
                                text=True, check=True)
        self.assertIn("no run is going", status.stdout)
        self.assertEqual(campaign.run(self.project, "--quiet").returncode, 0)

    def test_stages_are_done_anew_or_left_as_asked_for(self):
        run = campaign.run(self.project, "--quiet", "--from", "network")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("work/network/network.artifact", self.redone())
        for name in self.redone():
            self.assertRegex(name, r"work/(network|outputs)/")
        self.expect_reference()

        self.forget()
        run = campaign.run(self.project, "--quiet", "--only", "pairs")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("6 of 6 stations can be used, 15 pairs were tried", run.stdout.decode())
        self.assertEqual(campaign.files_of(self.folder / "out"), [])
        self.before = artifacts_of(self.folder)
        for name in self.before:
            self.assertRegex(name, r"work/(scans|stations|pairs)/")
        run = campaign.run(self.project, "--quiet", "--only", "network")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("report.html", campaign.files_of(self.folder / "out"))
        self.assertFalse((self.folder / "out" / "merged.las").exists())
        self.run_whole()
        self.expect_reference()
        for name in self.redone():
            self.assertRegex(name, r"work/(network|outputs)/")

    def test_status_says_what_is_done_and_how_it_ended(self):
        shutil.rmtree(self.folder / "work" / "stations" / "S5")
        status = self.status()
        self.assertIn("stations: 5 of 6 up to date\n  station S5: missing", status)
        self.assertIn("network: 2 of 2 up to date", status)  # it will be the same again
        self.assertRegex(status, r"last report: Complete: .*\(exit code 0\)")
        self.assertNotIn("no run has left", status)
        elsewhere = self.folder / "elsewhere"
        status = self.status("--out", elsewhere / "out", "--work", elsewhere / "work")
        self.assertIn(f"no run has left a state in {elsewhere / 'work'} or", status)
        self.assertFalse(elsewhere.exists())

    def test_plan_knows_the_program_by_what_it_starts_with(self):
        """Threads load more libraries, and a plan without stations starts none."""
        shutil.rmtree(self.folder / "work" / "stations")
        plan = self.dry_run()
        self.assertIn("station S1: missing", plan)
        self.assertNotRegex(plan, r"program|pair |network|outputs")

    def test_scans_are_known_however_they_are_spelled(self):
        known = {path: path.stat().st_mtime_ns for path in (self.folder / "work").rglob("*")}
        for folder, project in ((self.folder, self.project.name), ("/", self.project),
                                (self.folder / "scans", f"../{self.project.name}")):
            plan = subprocess.run([campaign.PROGRAM, "run", project, "--dry-run"], cwd=folder,
                                  capture_output=True, check=True, text=True)
            self.assertIn("everything is up to date", plan.stdout)
            subprocess.run([campaign.PROGRAM, "status", project], cwd=folder, check=True,
                           capture_output=True)
        self.assertEqual(
            {path: path.stat().st_mtime_ns for path in (self.folder / "work").rglob("*")}, known)

    def test_plan_reads_no_scan_and_writes_nothing(self):
        shutil.rmtree(self.folder / "work" / "scans")
        plan = self.dry_run()
        for unit in ("station S1", "pair S2 S1 full", "network", "moving objects"):
            self.assertRegex(plan, rf"{unit}: not known")
        self.assertFalse((self.folder / "work" / "scans").exists())
        self.run_whole()
        self.assertEqual(self.redone(), [])

    def test_corrupt_scan_costs_one_station(self):
        scan = self.folder / "scans" / "S4.ptx"
        original = scan.read_bytes()
        half = original.rfind(b"\n", 0, len(original) // 2) + 1
        try:
            scan.write_bytes(original[:half] + b"12.5 garbage\n" + original[half:])
            self.project.write_text(self.text.replace("require_all_stations: true",
                                                      "require_all_stations: false"))
            self.run_whole(exit_code=3)
            report = (self.folder / "out" / "report.json").read_text()
            links = (self.folder / "out" / "links.csv").read_text()
            status, plan = self.status(), self.dry_run()
            before = artifacts_of(self.folder)
            self.run_whole(exit_code=3)
            again = artifacts_of(self.folder)
        finally:
            scan.write_bytes(original)
        self.assertIn("5 of 6 stations placed", report)
        line = original[:half].count(b"\n") + 1
        self.assertRegex(report, rf"S4\.ptx:{line}\b")
        self.assertEqual(links.count("unusable_station"), 5)
        for text in (status, plan):
            self.assertRegex(text, rf"\n  station S4: failed \(.*S4\.ptx:{line}\b")
        self.assertEqual(plan.count("\n"), 2, plan)  # nothing waits for what cannot be read
        self.assertIn("network: 2 of 2 up to date", status)
        self.assertRegex(status, r"last run: ended at .*: Partial: .* \(exit code 3\)")
        self.assertEqual({name for name in again if again[name] != before.get(name)},
                         {"work/stations/S4/station-fault.artifact"})

    def test_pair_that_failed_is_known(self):
        self.project.write_text(self.text + "resources: {pair_limit_s: 0.000001}\n")
        shutil.rmtree(self.folder / "work" / "pairs" / "S2__S1")
        self.run_whole(exit_code=3)
        plan = self.dry_run()
        self.assertRegex(plan, r"\n  pair S2 S1 full: failed \(.*longer")
        self.assertEqual(plan.count("\n"), 2, plan)
        self.project.write_text(self.text)
        self.run_whole()
        self.expect_reference()
        self.assertIn("everything is up to date", self.dry_run())

    def test_pair_that_failed_is_known_where_not_all_are_tried(self):
        grow = self.text + "pair_selection: {strategy: grow}\n"
        self.project.write_text(grow)
        self.run_whole()
        shutil.rmtree(self.folder / "work" / "pairs" / "S2__S1")
        self.project.write_text(grow + "resources: {pair_limit_s: 0.000001}\n")
        self.run_whole(exit_code=3)
        self.assertRegex(self.dry_run(), r"\n  pair S2 S1 \w+: failed \(.*longer")

    def test_status_tells_a_killed_run_from_one_that_ended(self):
        self.assertRegex(self.status(), r"last run: ended at .*: Complete: .* \(exit code 0\)")
        shutil.rmtree(self.folder / "work" / "network")
        process = self.begin()
        process.kill()
        process.communicate()
        status = self.status()
        self.assertRegex(status, rf"last run: begun at .*, process {process.pid}; it was killed")
        self.assertRegex(status, r"last report: Complete: .*\(exit code 0\)")
        process = self.begin()
        process.terminate()
        process.communicate()
        self.assertRegex(self.status(), r"last run: ended at .*: Interrupted: .* \(exit code 143\)")


if __name__ == "__main__":
    unittest.main()

"""docs/nightly.md and the files in docs/nightly, tried out: the units, the rotation of logs, the mail
and the cron line."""

import getpass
import grp
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

import campaign

NIGHTLY = campaign.ROOT / "docs/nightly"
PAGE = (campaign.ROOT / "docs/nightly.md").read_text()
UNITS = ("backsight-nightly.service", "backsight-nightly.timer")


class Nightly(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory(prefix="backsight-nightly-")
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def here(self, text):
        """The text with the paths and the user of this machine."""
        for there, path in (("/usr/local/bin/backsight", campaign.PROGRAM),
                            ("/usr/local/lib/backsight", NIGHTLY),
                            ("/srv/survey/town", self.folder),
                            ("/srv/survey/*", self.folder)):
            text = text.replace(there, str(path))
        group = grp.getgrgid(os.getgid()).gr_name
        return (text.replace("su survey survey", f"su {getpass.getuser()} {group}")
                .replace("User=survey", f"User={getpass.getuser()}"))

    def copy(self, name):
        path = self.folder / name
        path.write_text(self.here((NIGHTLY / name).read_text()))
        path.chmod(0o644)
        return path

    def verify_units(self):
        run = subprocess.run(["systemd-analyze", "verify", *(self.folder / n for n in UNITS)],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return run.returncode, run.stdout

    def test_systemd_has_nothing_to_say_about_the_units(self):
        for name in UNITS:
            self.copy(name)
        self.assertEqual(self.verify_units(), (0, ""))
        service = self.folder / UNITS[0]
        service.write_text(service.read_text().replace("Nice=10", "Nicer=10"))
        self.assertIn("Nicer", self.verify_units()[1])

    def test_service_keeps_what_the_page_promises(self):
        service = (NIGHTLY / UNITS[0]).read_text()
        never = re.search(r"^RestartPreventExitStatus=(.*)$", service, re.M)[1].split()
        good = re.search(r"^SuccessExitStatus=(.*)$", service, re.M)[1].split()
        codes = set(re.findall(r"\d+", " ".join(re.findall(r"^\| ([\d, ]+) \|", PAGE, re.M))))
        self.assertEqual(codes - {"0"} - set(never) - set(good), {"75"})

    def test_no_exec_line_empties_the_output_of_another(self):
        """systemd opens `truncate:` for every one of them."""
        service = (NIGHTLY / UNITS[0]).read_text()
        if len(re.findall(r"^Exec\w+=", service, re.M)) > 1:
            self.assertNotIn("=truncate:", service)

    def test_service_runs_and_mails_the_line_of_the_run(self):
        (self.folder / "survey.yaml").write_text(campaign.simulate(self.folder))
        service = self.here((NIGHTLY / UNITS[0]).read_text())
        start, stop = (shlex.split(re.search(rf"^{name}=(.*)$", service, re.M)[1])
                       for name in ("ExecStart", "ExecStopPost"))
        (self.folder / "summary.txt").write_text("of last night\n" * 9)
        run = subprocess.run(start, cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stdout), (0, ""), run.stderr)
        subject, recipient, text = self.mailed_by(stop, "0")
        self.assertRegex(subject, r"^backsight, \S+ on \S+: Complete: ")
        self.assertEqual(recipient, "surveyor@example.com")
        self.assertRegex(text, r"^Complete: .*report\.html\n\nExit status 0: complete")

    def test_page_explains_every_exit_code(self):
        rows = re.findall(r"^\| ([\d, ]+) \|", PAGE, re.M)
        conventions = (campaign.ROOT / "docs/conventions.md").read_text()
        self.assertEqual(rows, re.findall(r"^\| ([\d, ]+) \|", conventions, re.M))

    def test_logrotate_accepts_the_snippet_and_finds_the_log(self):
        snippet = self.copy("backsight.logrotate")
        (self.folder / "night.jsonl").write_text("{}\n")
        run = subprocess.run([shutil.which("logrotate", path="/usr/sbin:/sbin:/usr/bin"), "--debug",
                              "--state", self.folder / "state", snippet],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.assertEqual(run.returncode, 0, run.stdout)
        self.assertNotIn("error", run.stdout)
        self.assertIn(f"considering log {self.folder}/night.jsonl", run.stdout)

    def test_scripts_are_clean(self):
        run = subprocess.run(["shellcheck", NIGHTLY / "mail_summary"], capture_output=True)
        self.assertEqual((run.returncode, run.stdout), (0, b""))

    def mailed_by(self, command, status):
        """(subject, recipient, text) that the command gives to a `mail` of the test's own."""
        tools = self.folder / "bin"
        tools.mkdir(exist_ok=True)
        fake = tools / "mail"
        fake.write_text('#!/bin/sh\nprintf "%s\\n" "$@" >"$SENT.args"\ncat >"$SENT.text"\n')
        fake.chmod(0o755)
        sent = self.folder / "sent"
        subprocess.run(command, check=True, cwd=self.folder,
                       env={"PATH": f"{tools}:/usr/bin:/bin", "SENT": sent, "EXIT_STATUS": status})
        option, subject, recipient = pathlib.Path(f"{sent}.args").read_text().splitlines()
        self.assertEqual(option, "-s")
        return subject, recipient, pathlib.Path(f"{sent}.text").read_text()

    def mail(self, summary, status):
        """What is mailed of a night whose run printed `summary`."""
        file = self.folder / "summary.txt"
        file.unlink(missing_ok=True)
        if summary is not None:
            file.write_text(summary)
        return self.mailed_by([NIGHTLY / "mail_summary", file, "someone@example.com"], status)

    def test_mail_holds_the_summary_line_and_the_exit_code(self):
        line = "Partial: 4 of 5 stations placed $(id) `id` %s. Report: /srv/out/report.html"
        subject, recipient, text = self.mail(line + "\n", "3")
        here = f"backsight, {self.folder.name} on {os.uname().nodename}: "
        self.assertEqual(subject, here + line.split(" Report:")[0])
        self.assertEqual(recipient, "someone@example.com")
        self.assertTrue(text.startswith(line + "\n\nExit status 3: partial"), text)

    def test_mail_is_sent_when_there_is_no_summary(self):
        for summary in (None, ""):
            subject, _, text = self.mail(summary, "KILL")
            self.assertIn("No summary", subject)
            self.assertIn("killed, perhaps for want of memory", text)
        self.assertIn("Complete: all.", self.mail("Complete: all.", "0")[0])

    def test_mail_knows_every_exit_code(self):
        for row in re.findall(r"^\| ([\d, ]+) \|", PAGE, re.M):
            for code in row.split(", "):
                self.assertNotIn("see the journal.", self.mail("x\n", code)[2])
        self.assertIn("see the journal.", self.mail("x\n", "77")[2])

    def test_cron_line_works_as_written(self):
        project = campaign.simulate(self.folder)
        (self.folder / "survey.yaml").write_text(project)
        crontab = re.search(r"```cron\n(.*?)```", PAGE, re.S)[1]
        command = re.search(r"^\d\S* \S+ \S+ \S+ \S+ +(.*)$", crontab, re.M)[1]
        self.assertNotIn("%", command, "cron takes it for the end of the line")
        run = subprocess.run(["/bin/sh", "-c", self.here(command)], capture_output=True, text=True,
                             env={"PATH": "/usr/bin:/bin"})
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue(run.stdout.startswith("Complete: "), run.stdout)
        self.assertEqual(run.stdout.count("\n"), 1)
        last = (self.folder / "night.jsonl").read_text().splitlines()[-1]
        self.assertEqual(json.loads(last)["exit_code"], 0)


if __name__ == "__main__":
    unittest.main()

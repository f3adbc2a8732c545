#!/usr/bin/env python3
"""report.html of made-up runs, opened in a headless Chromium, on a screen and as wide as A4 paper: nothing
is wider than the page, the console stays silent, and nothing is asked of the network. Skipped with a
message where Chromium is missing.

    report_page_test.py SAMPLE_REPORT"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
SKIPPED = 77  # SKIP_RETURN_CODE of the test
SAMPLE_REPORT = sys.argv[1]
PAGES = ("sample", "two", "large")

# What sticks out, found in a copy of the page: the page itself has no script.
PROBE = """<script>
addEventListener("load", () => {
  const found = [];
  const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > width) found.push("page");
  for (const element of document.querySelectorAll("table, svg, p, h1, h2, h3, li, figure, .legend")) {
    const box = element.getBoundingClientRect();
    if (box.right > width + 0.5 || element.scrollWidth > element.clientWidth + 1 && element.clientWidth)
      found.push(element.tagName + " " + (element.textContent || "").trim().slice(0, 60));
  }
  const labels = [...document.querySelectorAll("svg.plan")].flatMap(svg => {
    const frame = svg.getBoundingClientRect();
    return [...svg.querySelectorAll("text")].filter(text => {
      const box = text.getBoundingClientRect();
      return box.left < frame.left - 1 || box.right > frame.right + 1;
    }).map(text => "label " + text.textContent);
  });
  document.title = "PROBE" + JSON.stringify([...found, ...labels]);
});
</script>"""


def chromium(profile, page, *options):
    return subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
         f"--user-data-dir={profile}", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--enable-logging=stderr",
         "--host-resolver-rules=MAP * ~NOTFOUND", *options, page.as_uri()],
        capture_output=True, text=True, errors="replace", timeout=180)


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        cls.path = pathlib.Path(cls.folder.name)
        subprocess.run([SAMPLE_REPORT, cls.path], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def html(self, name):
        return (self.path / name / "report.html").read_text()

    def probe(self, html, width):
        """What is too wide, and what the console says."""
        page = self.path / "probe.html"
        page.write_text(html.replace("</body>", PROBE + "</body>"))
        result = chromium(self.path / "profile", page, f"--window-size={width},1200",
                          "--virtual-time-budget=10000", "--dump-dom")
        title = re.search(r"<title>PROBE(.*?)</title>", result.stdout, re.S)
        self.assertIsNotNone(title, result.stderr[-2000:])
        console = [line for line in result.stderr.splitlines() if "CONSOLE" in line]
        return title[1], console

    def test_nothing_sticks_out(self):
        for name in PAGES:
            for width in (1400, 688):  # 688 px: A4 less its margins
                with self.subTest(page=name, width=width):
                    self.assertEqual(self.probe(self.html(name), width), ("[]", []))

    def test_the_probe_sees_what_sticks_out(self):
        wide = self.html("two").replace("<h2>Links</h2>",
                                        "<table style='min-width:3000px'><tr><td>x</table>")
        found, _ = self.probe(wide, 1000)
        self.assertIn("page", found)
        self.assertIn("TABLE", found)
        broken = self.html("two").replace("</body>", "<script>missing()</script></body>")
        self.assertTrue(self.probe(broken, 1000)[1])

    def test_nothing_leaves_the_page(self):
        for name in PAGES:
            html = self.html(name)
            self.assertNotIn("<script", html)
            for reference in re.findall(r"""(?:src|href|action|data)\s*=\s*["']?([^"'>\s]+)""", html):
                self.assertTrue(reference.startswith("data:image/png;base64,"), reference[:80])
            for reference in re.findall(r"url\(([^)]*)\)", html):
                self.assertTrue(reference.startswith("#"), reference[:80])
            self.assertNotRegex(html, r"@import|https?://")

    def test_it_prints(self):
        pdf = self.path / "sample.pdf"
        chromium(self.path / "profile", self.path / "sample/report.html",
                 "--no-pdf-header-footer", f"--print-to-pdf={pdf}")
        boxes = set(re.findall(rb"/MediaBox\s*\[([^\]]*)\]", pdf.read_bytes()))
        sizes = {tuple(round(float(v)) for v in box.split()) for box in boxes}
        self.assertEqual(len(sizes), 1, sizes)
        width, height = next(iter(sizes))[2:]
        self.assertAlmostEqual(width, 595, delta=2)  # A4 upright, points
        self.assertAlmostEqual(height, 842, delta=2)


if __name__ == "__main__":
    if CHROMIUM is None:
        print("skipped: chromium is not installed; dependencies.apt lists it")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])

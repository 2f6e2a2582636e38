import base64
import json
import os
import re
import shutil
import struct
import subprocess

from case import PROGRAM, SOURCE, Case, main

ELEMENT = '<script type="application/json" id="recorded">'


class ViewReplay(Case):
    """What `view` writes and reports hold, with a page of its own: this needs no Node."""

    def setUp(self):
        super().setUp()
        self.program = self.path("bin/ferrule")
        os.mkdir(self.path("bin"))
        shutil.copy(PROGRAM, self.program)
        shutil.copytree(SOURCE + "/data", self.path("share/ferrule"))
        with open(self.path("share/ferrule/page.html"), "w") as page:
            page.write("<!doctype html>" + ELEMENT + "</script>")

    def installed(self, *arguments, code=0):
        run = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True,
                             timeout=600)
        self.assertEqual(run.returncode, code, run.stderr)
        return run

    def recorded_in(self, html):
        return json.loads(html.split(ELEMENT)[1].split("</script>")[0])

    def test_an_exported_file_holds_what_was_recorded(self):
        files = self.record(self.path("episodes"), episodes=2)
        out = self.path("out.html")
        self.installed("view", self.path("episodes"), "--export", out)
        recorded = self.recorded_in(open(out).read())
        self.assertEqual([run["name"] for run in recorded["runs"]],
                         [os.path.basename(file) for file in files])
        columns = recorded["columns"]
        for file, run in zip(files, recorded["runs"]):
            said = json.loads(self.done("replay", file, "--json").stdout)
            self.assertEqual(run["outcome"], said["outcome"])
            data = base64.b64decode(run["rows"], validate=True)
            self.assertEqual(len(data), 4 * run["count"] * len(columns))
            last = struct.unpack("<%df" % len(columns), data[-4 * len(columns):])
            self.assertAlmostEqual(last[columns.index("t_s")], said["recorded_s"], 3)
            for event in run["events"]:
                at = struct.unpack_from("<f", data, 4 * len(columns) * event["row"])[0]
                self.assertAlmostEqual(at, event["t_s"], 6)

    def test_a_report_has_every_trial_on_its_map_and_failures_to_watch(self):
        report = self.path("report.html")
        run = self.installed("evaluate", "--baseline", "constant-velocity", "--scene", "bench",
                             "--trials", 30, "--report", report, "--json")
        said = json.loads(run.stdout)
        html = open(report).read()
        frame = re.search(r'srcdoc="([^"]*)"', html).group(1)
        for code, character in (("&lt;", "<"), ("&gt;", ">"), ("&quot;", '"'), ("&amp;", "&")):
            frame = frame.replace(code, character)
        recorded = self.recorded_in(frame)
        points = recorded["maps"][0]["points"]
        self.assertEqual(len(points), 30)
        outcomes = [point["outcome"] for point in points]
        for outcome, count in said["outcomes"].items():
            self.assertEqual(outcomes.count(outcome), count)
        watched = [point for point in points if "run" in point]
        self.assertGreater(len(watched), 5)
        for point in watched:
            self.assertNotEqual(point["outcome"], "inserted")
            self.assertEqual(recorded["runs"][point["run"]]["outcome"], point["outcome"])
            self.assertTrue(recorded["runs"][point["run"]]["why"])

    def test_a_trial_against_another(self):
        out = self.path("out.html")
        self.installed("view", "--trial", 3, "--scene", "bench", "--against", "operator",
                       "--export", out)
        recorded = self.recorded_in(open(out).read())
        self.assertEqual([run["name"] for run in recorded["runs"]], ["simulated operator"])
        self.assertEqual(recorded["scene"]["name"], "bench")

    def test_without_a_page(self):
        os.remove(self.path("share/ferrule/page.html"))
        # The build may have one: whichever it is, a report is written, and says what it lacks.
        report = self.path("report.html")
        self.installed("evaluate", "--baseline", "constant-velocity", "--trials", 3, "--report", report)
        html = open(report).read()
        self.assertTrue("srcdoc=" in html or "install the packages nodejs and npm" in html)

    def test_what_is_refused(self):
        self.refused(2, "view", "--export", self.path("a.html"), says=["--trial"])
        self.refused(2, "view", "--trial", 3, "--export", self.path("a.html"), says=["--against"])
        self.refused(3, "view", self.path("nothing.h5"), "--export", self.path("a.html"),
                     says=["nothing.h5"])
        self.refused(3, "view", "--trial", 3, "--against", "operator", "--export",
                     self.path("no/a.html"), says=["no/a.html"])
        os.mkdir(self.path("empty"))
        self.refused(2, "view", self.path("empty"), "--export", self.path("a.html"),
                     says=["no episodes"])


if __name__ == "__main__":
    main()

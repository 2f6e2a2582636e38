import base64
import json
import os
import re
import shutil
import struct
import subprocess
import zlib

from case import PROGRAM, SOURCE, Case, main

ELEMENT = '<script type="application/json" id="recorded">'


def unpacked(run, columns):
    """The columns of a run, from what view/packed_rows.hpp makes of them."""
    data = zlib.decompress(base64.b64decode(run["rows"], validate=True), -15)
    rows = run["count"]
    assert len(data) == 4 * rows * len(columns)
    found = {}
    for place, name in enumerate(columns):
        planes = [data[(4 * place + k) * rows:][:rows] for k in range(4)]
        bits, values = 0, []
        for four in zip(*planes):
            bits = (bits + int.from_bytes(bytes(four), "little")) % 2**32
            values.append(struct.unpack("<f", struct.pack("<I", bits))[0])
        found[name] = values
    return found


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
            times = unpacked(run, columns)["t_s"]
            self.assertAlmostEqual(times[-1], said["recorded_s"], 3)
            for event in run["events"]:
                self.assertAlmostEqual(times[event["row"]], event["t_s"], 6)

    def test_a_report_has_every_trial_on_its_map_and_every_failure_to_watch(self):
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
        self.assertEqual(len(watched), 30 - outcomes.count("inserted"))
        self.assertGreater(len(watched), 5)
        for point in watched:
            self.assertNotEqual(point["outcome"], "inserted")
            self.assertEqual(recorded["runs"][point["run"]]["outcome"], point["outcome"])
            self.assertTrue(recorded["runs"][point["run"]]["why"])
        forces = self.forces_in_report(report)
        self.assertEqual(list(forces), ["constant-velocity, 20 trials"])
        friction = forces["constant-velocity, 20 trials"]["friction"]
        self.assertEqual((friction["apart"], friction["touching"]), ("0.0 %", "100.0 %"))

    def test_a_trial_against_another(self):
        out = self.path("out.html")
        self.installed("view", "--trial", 3, "--scene", "bench", "--against", "operator",
                       "--export", out)
        recorded = self.recorded_in(open(out).read())
        self.assertEqual([run["name"] for run in recorded["runs"]], ["simulated operator"])
        self.assertEqual(recorded["scene"]["name"], "bench")
        # A shipped controller goes by its name, here as well.
        self.installed("view", "--trial", 3, "search", "--scene", "ladder/c", "--against", "spiral", "--export", out)
        recorded = self.recorded_in(open(out).read())
        self.assertEqual([run["name"].rpartition("/")[2] for run in recorded["runs"]],
                         ["search.json", "blind spiral"])
        self.assertEqual(recorded["scene"]["name"], "ladder/c")

    def test_without_a_page(self):
        os.remove(self.path("share/ferrule/page.html"))
        # The build may have one: whichever it is, a report is written, and says what it lacks.
        report = self.path("report.html")
        self.installed("evaluate", "--baseline", "constant-velocity", "--trials", 3, "--report", report)
        html = open(report).read()
        self.assertTrue("srcdoc=" in html or "install the packages nodejs and npm" in html)
        self.assertEqual(list(self.forces_in_report(report)), ["constant-velocity, 3 trials"])
        # Of parts that do not fit no force acted.
        self.installed("evaluate", "--baseline", "constant-velocity", "--scene", "tolerance", "--set",
                       "tolerance.bore_diameter_um=[124,124.2]", "--trials", 2, "--report", report)
        self.assertNotIn("Which force acted when", open(report).read())

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

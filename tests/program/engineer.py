"""Answers for an engineer: sweep, map, sensitivity, and the page of their results."""

import copy
import csv
import glob
import json
import math
import os
import re
import shutil
import signal
import subprocess
import time

from case import PROGRAM, Case, ferrule, main

# Short: 30 um instead of 270.
SHORT = ["--scene", "bench", "--set", "start.distance_um=20", "--set", "success.depth_um=10",
         "--set", "start.lateral_sd_um=8", "--seed", 3]
STRAIGHT = "constant-velocity"


class Engineer(Case):
    def json_of(self, *arguments):
        return json.loads(self.done(*arguments, "--json").stdout)

    def evaluated(self, *settings, trials=12):
        words = [word for setting in settings for word in ("--set", setting)]
        return self.json_of("evaluate", "--baseline", STRAIGHT, *SHORT, *words, "--trials", trials)

    # A row of sweep or map is what evaluate says of its scene.
    def is_evaluation(self, row, alone):
        for key in ("trials", "successes", "feasible", "outcomes", "mated", "mated_tuned", "success_rate"):
            self.assertEqual(row[key], alone[key], key)
        self.assertEqual([row["low"], row["high"]], [alone["wilson_low"], alone["wilson_high"]])
        for key, p95 in (("time_s", "time_p95_s"), ("peak_force_uN", "peak_force_p95_uN"),
                         ("loss_dB", "loss_p95_dB")):
            self.assertEqual([row[key], row[p95]], [alone[key]["median"], alone[key]["p95"]])

    def test_a_sweep_is_an_evaluation_at_each_point(self):
        arguments = ["sweep", STRAIGHT, "ferrule.bore_diameter_um=126,125.5+1/-0",
                     "limits.force_uN=20:80:3:log", *SHORT, "--trials", 12]
        result = self.json_of(*arguments, "--plot", self.path("s.svg"))
        self.assertEqual(result["keys"], ["ferrule.bore_diameter_um", "limits.force_uN"])
        rows = result["rows"]
        self.assertEqual([row["values"]["limits.force_uN"] for row in rows], [20, 40, 80] * 2)
        self.assertEqual([row["values"]["ferrule.bore_diameter_um"] for row in rows],
                         [126] * 3 + [{"uniform": [125.5, 126.5]}] * 3)
        for row, bore in ((rows[1], "126"), (rows[5], "125.5..126.5")):
            self.is_evaluation(row, self.evaluated(
                f"ferrule.bore_diameter_um={bore}", f"limits.force_uN={row['values']['limits.force_uN']}"))
        self.assertIn("</svg>", open(self.path("s.svg")).read())
        for threads in (1, 2):
            again = self.json_of(*arguments, "--threads", threads)
            self.assertEqual(again["rows"], rows)
        table = list(csv.DictReader(self.done(*arguments, "--csv").stdout.splitlines()))
        self.assertEqual([float(row["values.limits.force_uN"]) for row in table], [20, 40, 80] * 2)
        text = self.done(*arguments).stdout
        self.assertEqual(len(re.findall(r"^ +125\.5\+1/-0 ", text, re.M)), 3)
        # Whatever a point must not be is said before the first trial.
        for wrong, says in (("bore=1,2", "unknown key"), ("limits.force_uN=5,-1", "limits.force_uN = -1"),
                            ("limits.force_uN", "KEY=a,b,c"), ("limits.force_uN=", "KEY=a,b,c"),
                            ("limits.force_uN=1:2", "limits.force_uN 1:2")):
            self.refused(2, "sweep", STRAIGHT, wrong, says=[says])
        self.refused(3, "sweep", "no.json", "limits.force_uN=5,6", says=["no.json"])

    MAP = ["map", STRAIGHT, "start.lateral_sd_um=1..20", "limits.force_uN=5..500:log", *SHORT,
           "--trials", 60, "--target", 0.7, "--width", 0.0625]

    def test_a_map_finds_the_line_with_few_trials(self):
        result = self.json_of(*self.MAP, "--plot", self.path("m.svg"))
        self.assertIn("</svg>", open(self.path("m.svg")).read())
        rows = {tuple(row["values"][key] for key in ("start.lateral_sd_um", "limits.force_uN")): row
                for row in result["rows"]}
        self.assertEqual(len(rows), len(result["rows"]))
        self.assertEqual(result["trials"], sum(row["trials"] for row in rows.values()))
        self.assertEqual(result["uniform_grid_trials"], 17 ** 2 * 60)
        self.assertLess(result["trials"], 0.2 * result["uniform_grid_trials"])
        self.assertEqual(result["contour_begins"][0], 0)
        # Each point of the line is between two neighbours of the grid, one on either side of the target.
        cell = [19 / 16, 100 ** (1 / 16)]
        for x, y in result["contour"]:
            near = [row["success_rate"] for (a, b), row in rows.items()
                    if abs(a - x) < 1.001 * cell[0] and 1 / cell[1] ** 1.001 < b / y < cell[1] ** 1.001]
            self.assertLess(min(near), 0.7)
            self.assertGreaterEqual(max(near), 0.7)
        # More force is needed from farther aside.
        line = sorted(result["contour"])
        self.assertLess(line[0][1], line[-1][1])
        some = list(rows.items())[len(rows) // 2]
        alone = self.evaluated(f"start.lateral_sd_um={some[0][0]}", f"limits.force_uN={some[0][1]}",
                               trials=some[1]["trials"])
        self.is_evaluation(some[1], alone)
        self.assertEqual(self.json_of(*self.MAP, "--threads", 1)["rows"], result["rows"])
        text = self.done(*self.MAP).stdout
        self.assertIn("70 % inserted along", text)
        self.assertIn(f"{result['trials']} trials at {len(rows)} points", text)
        table = list(csv.DictReader(self.done(*self.MAP, "--csv").stdout.splitlines()))
        self.assertEqual(len(table), len(rows))

    # Pairs of parts that cannot be together do not insert.
    def test_a_map_goes_where_parts_do_not_fit(self):
        result = self.json_of("map", STRAIGHT, "ferrule.bore_diameter_um=124.5..127",
                              "start.lateral_sd_um=1..8", *SHORT, "--trials", 20, "--target", 0.5,
                              "--width", 0.25)
        for row in result["rows"]:
            fits = row["values"]["ferrule.bore_diameter_um"] > 125
            self.assertEqual(row["can_be"], fits)
            self.assertEqual(row["trials"] > 0, fits)
            if not fits:
                self.assertIsNone(row["success_rate"])
                self.assertIsNone(row["time_s"])

    def test_what_a_map_cannot_be_is_said_at_once(self):
        one = "limits.force_uN=5..50"
        for words, says in (([one], "2"), ([one, one], "both keys"), ([one, "bore=1..2"], "unknown key"),
                            ([one, "fibre.cleave_deg=0..20"], "fibre.cleave_deg"),
                            ([one, "start.lateral_sd_um=5"], "low..high"),
                            ([one, "start.lateral_sd_um=5..1"], "low"),
                            ([one, "start.lateral_sd_um=0..5:log"], "positive"),
                            ([one, "start.lateral_sd_um=1..5", "--target", "2"], "--target")):
            self.refused(2, "map", STRAIGHT, *words, says=[says])

    def test_ctrl_c_keeps_the_points_that_are_whole(self):
        process = subprocess.Popen([PROGRAM, *map(str, self.MAP[:-6]), "--trials", "3000", "--json"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        self.addCleanup(process.kill)
        time.sleep(5)
        process.send_signal(signal.SIGINT)
        told = process.communicate(timeout=20)[0]
        self.assertEqual(process.returncode, 130)
        result = json.loads(told)
        self.assertIn("points", result["provenance"]["partial"])
        for row in result["rows"]:  # 30: it was only looked at
            self.assertTrue(row["trials"] in (30, 3000) or row["target"]["verdict"] != "undecided", row)

    # The answer that report prints of a map of these rows, (x, y, verdict, success rate), and lines.
    def answer_of_map(self, rows, lines):
        if not hasattr(self, "map"):
            self.map = self.json_of("map", STRAIGHT, "start.lateral_sd_um=2..20", "limits.force_uN=10..200:log", *SHORT,
                                    "--trials", 1, "--width", 1, "--target", 0.5)
        made = copy.deepcopy(self.map)
        template = made["rows"][0]
        made["rows"], made["contour"], made["contour_begins"] = [], [], []
        for x, y, verdict, rate in rows:
            row = copy.deepcopy(template)
            row["values"] = {"start.lateral_sd_um": x, "limits.force_uN": y}
            row["target"]["verdict"] = verdict
            row["success_rate"] = rate
            made["rows"].append(row)
        for line in lines:
            made["contour_begins"].append(len(made["contour"]))
            made["contour"] += [list(point) for point in line]
        made["undecided"] = sum(row[2] == "undecided" for row in rows)
        made["width"] = made["asked_width"] = 1 / 16
        with open(self.path("made.json"), "w") as out:
            json.dump(made, out)
        printed = self.done("report", self.path("made.json"), "--out", self.path("made.html")).stdout
        return [line.split(": ", 1)[1] for line in printed.splitlines() if line.startswith("  With a ")]

    # The points of a map, decided where it is far from the line: success(x, y) in 0..1 of 0.5.
    def points(self, success, close=0.2):
        rows = []
        for i in range(9):
            for j in range(17):
                x, y = 2 + 18 * i / 8, 10 * 20 ** (j / 16)
                rate = success(x, y)
                verdict = "undecided" if abs(rate - 0.5) < close else "shown" if rate > 0.5 else "refuted"
                rows.append((x, y, verdict, rate))
        return rows

    def test_what_a_map_says_follows_from_points_that_are_decided(self):
        def steep(at):
            return lambda x, y: 1 / (1 + math.exp(-8 * math.log(y / at)))
        flat = [[2, 36], [20, 36]]
        self.assertEqual(self.answer_of_map(self.points(steep(36)), [flat]), ["for a force limit of at least 36 uN."] * 3)
        falling = self.points(lambda x, y: 1 - steep(36)(x, y))
        self.assertEqual(self.answer_of_map(falling, [flat]), ["for a force limit up to 36 uN."] * 3)
        band = self.points(lambda x, y: min(steep(25)(x, y), 1 - steep(90)(x, y)))
        self.assertEqual(self.answer_of_map(band, [[[2, 25], [20, 25]], [[2, 90], [20, 90]]]),
                         ["for a force limit from 25 to 90 uN."] * 3)
        gap = [(x, y, {"shown": "refuted", "refuted": "shown"}.get(verdict, verdict), 1 - rate)
               for x, y, verdict, rate in band]
        self.assertEqual(self.answer_of_map(gap, [[[2, 25], [20, 25]], [[2, 90], [20, 90]]]),
                         ["for a force limit up to 25 uN and of at least 90 uN."] * 3)
        # The line rises: what is beside it further on lies on its other side.
        slope = [[2, 20], [20, 110]]
        answers = self.answer_of_map(self.points(lambda x, y: steep(10 + 5 * x)(x, y), close=0.45), [slope])
        self.assertEqual(answers, [f"for a force limit of at least {10 + 5 * x:.4g} uN." for x in (3.8, 11, 18.2)])
        # Points close to the line that say the opposite are not decided: they do not count.
        for wrong in (self.points(steep(36)), falling):
            for x, y, verdict, rate in list(wrong):
                for near, other in ((35.9, rate), (36.1, rate)):
                    wrong.append((x, near, "undecided", 0.5 + (0.02 if near < 36 else -0.02)))
                    wrong.append((x, near, "undecided", 0.5 + (0.02 if near > 36 else -0.02)))
            said = "of at least" if wrong[0][2] == "refuted" else "up to"
            self.assertEqual(self.answer_of_map(wrong, [flat]), [f"for a force limit {said} 36 uN."] * 3)

    def test_what_no_point_of_a_map_decides_is_not_said(self):
        flat = [[2, 36], [20, 36]]
        everywhere = [(x, y, rate) for x, y, _, rate in self.points(lambda x, y: 1 if y > 36 else 0)]
        open_ = ["too few points are decided to say for which force limit."] * 3
        undecided = [(x, y, "undecided", rate) for x, y, rate in everywhere]
        for lines in ([flat], [], [flat, [[2, 50], [20, 50]]]):
            self.assertEqual(self.answer_of_map(undecided, lines), open_)
        # One that is decided, among them; one alone; none at all.
        self.assertEqual(self.answer_of_map([*undecided, (11, 100, "shown", 1)], [flat]), open_)
        self.assertEqual(self.answer_of_map([(11, 100, "shown", 1)], []), open_)
        self.assertEqual(self.answer_of_map([], []), open_)
        # Noise: what some show others refute.
        noise = [(x, y, ("shown", "refuted")[(3 * round(x) + 7 * round(y)) % 2], rate) for x, y, rate in everywhere]
        for lines in ([flat], []):
            for answer in self.answer_of_map(noise, lines):
                self.assertNotRegex(answer, "at least|up to|any|for no")
        # Half of it: what is shown above the line says nothing of below.
        half = [(x, y, "shown" if y > 36 else "undecided", rate) for x, y, rate in everywhere]
        self.assertEqual(self.answer_of_map(half, [flat]),
                         ["for a force limit of at least 36 uN; up to 36 uN it is not decided."] * 3)
        self.assertEqual(self.answer_of_map([(x, y, "shown", 1) for x, y, _ in everywhere], []), ["for any force limit."] * 3)
        self.assertEqual(self.answer_of_map([(x, y, "refuted", 0) for x, y, _ in everywhere], []), ["for no force limit."] * 3)

    # Trials of a straight push are over in a moment: less time than the line takes.
    def test_time_ends_a_map_where_it_is_coarser(self):
        finer = [*self.MAP[:-4], "--target", 0.7, "--width", 1 / 512]
        for seconds in (2, 4, 8, 16, 32):  # whatever the machine does besides, one of them knows a line
            result = self.json_of(*finer, "--time", f"{seconds}s")
            self.assertEqual(result["ended_by"], "time")
            looked_at = [row for row in result["rows"] if row["target"]["verdict"] == "undecided" and row["trials"] < 60]
            if result["contour"] and not looked_at:
                break
        self.assertEqual(result["asked_width"], 1 / 512)
        self.assertGreater(result["width"], 1 / 512)
        # The same as if that width had been asked for, which has all the time.
        alone = self.json_of(*self.MAP[:-4], "--target", 0.7, "--width", result["width"], "--time", "1h")
        self.assertEqual(alone["ended_by"], "width")
        for key in ("contour", "contour_begins", "undecided", "width"):
            self.assertEqual(result[key], alone[key], key)
        rows = {str(row["values"]): row for row in result["rows"]}
        for row in alone["rows"]:
            self.assertEqual(rows[str(row["values"])], row)
        run = self.done(*finer, "--time", f"{2 * seconds}s")
        self.assertRegex(run.stdout, r"known to 1/\d+ of either range: the time ended it")
        self.assertRegex(run.stderr, r"after \d+ s known to 1/4: 70 % along")
        with open(self.path("m.json"), "w") as out:
            json.dump(result, out)
        self.assertIn("The time that was given ended it", self.done(
            "report", self.path("m.json"), "--out", self.path("m.html")).stdout)

    # All points of the coarsest grid are looked at before any is decided.
    def test_a_map_has_a_line_early(self):
        process = subprocess.Popen([PROGRAM, *map(str, self.MAP[:-6]), "--target", "0.7", "--trials", "3000", "--json"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        self.addCleanup(process.kill)
        self.assertRegex(process.stderr.readline(), "after [0-9]+ s known to 1/4: 70 % along ")
        process.send_signal(signal.SIGINT)
        result = json.loads(process.communicate(timeout=60)[0])
        self.assertEqual(process.returncode, 130)
        self.assertEqual(result["ended_by"], "interrupt")
        self.assertTrue(result["contour"])
        self.assertEqual(result["width"], 1 / 4)
        self.assertIn(30, [row["trials"] for row in result["rows"]])

    def test_a_map_without_time_says_what_it_knows(self):
        words = [*self.MAP[:-4], "--target", 0.7, "--time", "0.001"]
        result = self.json_of(*words)
        self.assertEqual([result["width"], result["ended_by"], result["contour"]], [None, "time", []])
        text = self.done(*words).stdout
        self.assertIn("no line: of", text)
        self.assertNotIn("everywhere", text)
        with open(self.path("m.json"), "w") as out:
            json.dump(result, out)
        self.assertNotIn("known to", self.done("report", self.path("m.json"), "--out", self.path("m.html")).stdout)
        for wrong in ("soon", "0s", "-1s", "2 years"):
            self.refused(2, *self.MAP, "--time", wrong, says=["--time"])
        self.refused(2, *self.MAP, "--time", "5s", "--shard", "1/2", "--out", self.path("job"), says=["--time"])
        self.assertFalse(os.path.exists(self.path("job")))

    # What varies has no one value: no line says that of the scene that the points were made of.
    def test_a_page_assumes_nothing_of_what_varies(self):
        def page_of(*arguments):
            with open(self.path("r.json"), "w") as out:
                out.write(self.done(*arguments, "--json").stdout)
            self.done("report", self.path("r.json"), "--out", self.path("r.html"))
            return json.load(open(self.path("r.json"))), open(self.path("r.html")).read()

        def assumed(html):
            cells = re.findall(r"<tr><t[dh][^>]*><code>([^<]*)</code></t[dh]><t[dh][^>]*>([^<]*)<", html)
            self.assertEqual(len(cells), len(dict(cells)))
            return {key: value.strip() for key, value in cells}

        sweep, html = page_of("sweep", STRAIGHT, "limits.force_uN=45,80", "fibre.edge_um=0.5,5", *SHORT, "--trials", 20,
                              "--prefer", "loss")
        self.assertEqual(assumed(html)["limits.force_uN"], "45, 80 uN")
        self.assertEqual(assumed(html)["fibre.edge_um"], "0.5, 5 um")
        self.assertNotIn("of the scene is 60", html)
        best, = (row for row in sweep["rows"] if row["damage"]["text"] in html and
                 f"the force limit there is {row['values']['limits.force_uN']} uN" in html)
        limit, edge = best["values"]["limits.force_uN"], best["values"]["fibre.edge_um"]
        damage = self.evaluated(f"fibre.edge_um={edge}", f"limits.force_uN={limit}", trials=1)["damage"]
        self.assertIn(damage["text"], html)
        self.assertEqual(best["damage"], damage)
        self.assertNotIn("damage", sweep)
        result, html = page_of("map", STRAIGHT, "limits.force_uN=20..90", "fibre.edge_um=0.5..5", *SHORT, "--trials", 5,
                               "--width", 1, "--target", 0.5)
        self.assertEqual(assumed(html)["limits.force_uN"].replace(".0", ""), "20..90 uN")
        self.assertIn("the force limit is 20 to 90 uN", html)
        for edge in (0.5, 5):
            self.assertIn(self.evaluated(f"fibre.edge_um={edge}", trials=1)["damage"]["text"], html)
        # Drawn: the whole of it is named.
        result, html = page_of("evaluate", "--baseline", STRAIGHT, *SHORT, "--trials", 10, "--set", "limits.force_uN=40..90",
                               "--set", "fibre.diameter_um=125+-0.3")
        self.assertIn("the force limit is 40..90 uN", html)
        self.assertIn("with what is drawn at its centre", html)
        self.assertEqual(result["damage"]["over_limit"], result["damage"]["force_uN"] / 90)
        run = self.done("evaluate", "--baseline", STRAIGHT, *SHORT, "--trials", 1, "--set", "limits.force_uN=40..90")
        self.assertIn("note: limits.force_uN = 40..90: the fibre may be damaged before", run.stdout)

    def test_sensitivity_tells_what_matters(self):
        arguments = ["sensitivity", STRAIGHT, *SHORT, "--trials", 150, "--set",
                     "ferrule.bore_diameter_um=126+-0.3", "--set", "laws.friction.burgers_nm=0.19..0.21"]
        result = self.json_of(*arguments)
        found = {(row["of"], row["key"]): row for row in result["rows"]}
        self.assertEqual({key for of, key in found},
                         {"start.lateral_sd_um", "start.tilt_sd_mrad", "sensor",
                          "ferrule.bore_diameter_um", "laws.friction.burgers_nm"})
        self.assertEqual({of for of, key in found}, {"success", "time_s", "peak_force_uN", "loss_dB"})
        for row in found.values():
            if row["total"] is not None:
                self.assertLessEqual(row["low"], row["total"])
                self.assertGreaterEqual(row["high"], row["total"])
            if row["first"] is not None:
                self.assertLessEqual(row["first_low"], row["first"])
                self.assertGreaterEqual(row["first_high"], row["first"])
                self.assertAlmostEqual(row["interaction"], max(0, row["total"] - row["first"]))
        # The straight push does not look at the sensor; where it starts decides, the bore the loss.
        self.assertEqual(found["success", "sensor"]["total"], 0)
        self.assertGreater(found["success", "start.lateral_sd_um"]["low"], 0.6)
        self.assertGreater(found["loss_dB", "ferrule.bore_diameter_um"]["total"], 0.3)
        self.assertEqual(result["success_rate"], self.evaluated(
            "ferrule.bore_diameter_um=126+-0.3", "laws.friction.burgers_nm=0.19..0.21",
            trials=150)["success_rate"])
        self.assertEqual(self.json_of(*arguments, "--threads", 1)["rows"], result["rows"])
        # Half as uncertain is what evaluate says of a scene in which it is.
        half = {"ferrule.bore_diameter_um": "126+-0.15", "laws.friction.burgers_nm": "0.195..0.205",
                "start.lateral_sd_um": 4, "start.tilt_sd_mrad": 0.5}
        drawn = {"ferrule.bore_diameter_um": "126+-0.3", "laws.friction.burgers_nm": "0.19..0.21"}
        for key, value in half.items():
            alone = self.evaluated(*(f"{k}={v}" for k, v in {**drawn, key: value}.items()), trials=150)
            row = found["success", key]
            self.assertEqual(row["halved"], alone["success_rate"], key)
            self.assertAlmostEqual(row["halved_change"], alone["success_rate"] - result["success_rate"])
            self.assertLessEqual(row["halved_change_low"], row["halved_change"])
            self.assertGreaterEqual(row["halved_change_high"], row["halved_change"])
            self.assertEqual(found["time_s", key]["halved"], alone["time_s"]["median"])
        self.assertEqual(found["success", "sensor"]["halved_change"], 0)
        self.assertGreater(found["success", "start.lateral_sd_um"]["halved_change_low"], 0)
        text = self.done(*arguments).stdout
        for part in ("Sobol indices", "first order", "half as uncertain", "interaction"):
            self.assertIn(part, text)
        # The page says what is gained, and adds up nothing that is no share.
        with open(self.path("s.json"), "w") as out:
            json.dump(result, out)
        printed = self.done("report", self.path("s.json"), "--out", self.path("s.html")).stdout
        self.assertRegex(printed, r"Half as uncertain, each alone, raises the success: .*start lateral sd from \S+ % to")
        self.assertRegex(printed, r"Of the variance of success, alone: .* The rest, \d+ %, several make together")
        self.assertNotIn("force sensor", printed)
        self.refused(2, "sensitivity", STRAIGHT, "--scene", "paper", "--set", "start.lateral_sd_um=0",
                     "--set", "start.tilt_sd_mrad=0", says=["decided by chance"])

    def test_the_page_answers_each_result(self):
        files = {}
        for verb, arguments in {
                "evaluate": ["evaluate", "--baseline", STRAIGHT, *SHORT, "--trials", 30, "--target", 0.5],
                "sweep": ["sweep", STRAIGHT, "limits.force_uN=20,80", *SHORT, "--trials", 30],
                "map": ["map", STRAIGHT, "start.lateral_sd_um=1..20", "limits.force_uN=5..500:log", *SHORT,
                        "--trials", 20, "--target", 0.7, "--width", 0.25],
                "sensitivity": ["sensitivity", STRAIGHT, *SHORT, "--trials", 40]}.items():
            files[verb] = self.path(verb + ".json")
            with open(files[verb], "w") as out:
                out.write(self.done(*arguments, "--json").stdout)
        for verb, file in files.items():
            page = self.path(verb + ".html")
            run = self.done("report", file, "--out", page)
            html = open(page).read()
            question = run.stdout.splitlines()[0]
            self.assertTrue(question.endswith("?"), question)
            self.assertIn("<h1>" + question, html)
            # The answer is in the first lines.
            self.assertLess(html.index("<p class=big>"), html.index("<h2>"))
            for part in ("What was assumed", "How it was made", "seed of trials 3", "limits.force_uN", "simulated"):
                self.assertIn(part, html)
            if verb in ("evaluate", "sweep"):  # a grade says what it is for
                for part in ("joint.bore_concentricity_sd_um", "assumed: the scene does not state it", "1310, 1550"):
                    self.assertIn(part, html)
            self.assertNotRegex(html, r"src=\"http|0\.2333333")
            self.styled_by_its_own(html)
        result = json.load(open(files["evaluate"]))
        html = open(self.path("evaluate.html")).read()
        self.assertIn(f"{result['successes']} of {result['feasible']} simulated trials", html)
        self.assertIn("uN (1 um, polished)", html)
        both = self.path("both.html")
        words = ["report", files["sweep"], files["sensitivity"], "--out", both]
        if shutil.which("chromium"):
            self.done(*words, "--pdf", self.path("both.pdf"))
            self.assertTrue(open(self.path("both.pdf"), "rb").read().startswith(b"%PDF"))
        else:
            self.done(*words)
        self.assertEqual(open(both).read().count("<h1>"), 2)
        self.assertEqual(glob.glob(self.path("*.part")), [])

    # A sweep of bores whose rows have these successes, trials, mated means, times, forces.
    def sweep_of(self, rows):
        file = self.path("rows.json")
        if not hasattr(self, "swept"):
            self.swept = self.json_of("sweep", STRAIGHT, "ferrule.bore_diameter_um=126,127", *SHORT, "--trials", 2)
        result = json.loads(json.dumps(self.swept))
        like, result["rows"] = result["rows"][0], []
        for k, (successes, feasible, mean, time_s, force) in enumerate(rows):
            row = json.loads(json.dumps(like))
            z, p = 1.959963984540054, successes / feasible
            centre, n = (p + z * z / 2 / feasible) / (1 + z * z / feasible), feasible
            half = z / (1 + z * z / n) * (p * (1 - p) / n + z * z / 4 / n / n) ** 0.5
            row.update(successes=successes, feasible=feasible, trials=feasible, success_rate=p, low=centre - half,
                       high=centre + half, time_s=time_s, peak_force_uN=force)
            row["values"]["ferrule.bore_diameter_um"] = 126 + k
            row["mated"].update(pairs=10000, mean_dB=mean, mean_low_dB=0.95 * mean, mean_high_dB=1.05 * mean,
                                p97_dB=2 * mean, grade="C" if mean <= 0.25 else "D", grade_best="C",
                                grade_worst="D")
            row["mated_tuned"] = row["mated"]
            result["rows"].append(row)
        with open(file, "w") as out:
            json.dump(result, out)
        return file

    # Success alone does not choose where the trials cannot tell one from another.
    def test_the_best_is_by_a_rule_that_is_said(self):
        def told(rows, *more):
            out = self.done("report", self.sweep_of(rows), "--out", self.path("page.html"), *more).stdout
            return out.splitlines()

        # One insertion more, at a worse grade: both are the same, and the smaller loss is taken.
        two = [(199, 200, 0.40, 20, 30), (197, 198, 0.20, 20, 30)]
        lines = told(two)
        self.assertIn("bore diameter 127 um", lines[1])
        self.assertIn("2 of 2 insert equally often, as far as the trials can tell", lines[2])
        self.assertIn("197 of 198", lines[2])
        self.assertIn("199 of 200", lines[2])
        # None is best in all: both are named, and --prefer chooses.
        three = [(199, 200, 0.40, 10, 30), (197, 198, 0.20, 20, 30), (150, 200, 0.10, 5, 10)]
        lines = told(three)
        self.assertIn("2 of 3 insert equally often", lines[1])
        self.assertIn("bore diameter 126 um: 199 of 200", lines[3])
        self.assertIn("bore diameter 127 um: 197 of 198", lines[4])
        self.assertIn("bore diameter 126 um", told(three, "--prefer", "time")[1])
        self.assertIn("bore diameter 127 um", told(three, "--prefer", "loss")[1])
        # What does not differ by what is preferred is chosen by the rest.
        self.assertIn("bore diameter 127 um", told(three, "--prefer", "force")[1])
        prices = ["--price", "ferrule.bore_diameter_um=3,1.5,0"]
        self.assertIn("bore diameter 127 um", told(three, "--prefer", "price", *prices)[1])
        self.assertIn("price", open(self.path("page.html")).read())
        # A success that is clearly higher is the best, whatever is preferred.
        clear = [(200, 200, 0.40, 20, 30), (180, 200, 0.20, 10, 20)]
        for more in ([], ["--prefer", "loss"], ["--prefer", "time"]):
            self.assertIn("bore diameter 126 um", told(clear, *more)[1])
        file = self.sweep_of(three)
        for wrong, says in ((["--prefer", "price"], "--price"), (["--prefer", "beauty"], "beauty"),
                            (["--price", "limits.force_uN=1,2,3"], "ferrule.bore_diameter_um"),
                            (["--price", "ferrule.bore_diameter_um=1,2"], "3 values"),
                            (["--price", "ferrule.bore_diameter_um=1,2,x"], "x"), (["--price", "1,2"], "KEY=COST")):
            self.refused(2, "report", file, "--out", self.path("none.html"), *wrong, says=[says])
        self.assertFalse(os.path.exists(self.path("none.html")))

    def test_a_sweep_says_what_it_cannot_tell_apart(self):
        arguments = ["sweep", STRAIGHT, "limits.force_uN=80,81", *SHORT, "--trials", 24]
        text = self.done(*arguments).stdout
        self.assertIn("2 of 2 insert equally often, as far as the trials can tell", text)
        self.assertIn("grades are for 1310 and 1550 nm", text.lower())
        self.assertNotIn("loss [dB] ", text)
        priced = self.json_of(*arguments, "--prefer", "price", "--price", "limits.force_uN=2,1")
        self.assertEqual([row["price"] for row in priced["rows"]], [2, 1])
        self.assertEqual(priced["prefer"], "price")
        for row in priced["rows"]:
            self.assertEqual(row["mated_joint"]["bore_concentricity_sd_um"], 0.3)
        # Before the first trial.
        self.refused(2, *arguments[:3], "--trials", 100000000, "--price", "limits.force_uN=2", says=["2 values"])

    # Whatever of a file is another text, it is text on the page, or the file is refused.
    def test_texts_of_a_file_are_text_on_the_page(self):
        mark = """<script>alert(1)</script><img src=x onerror=alert(1)>'"&"""
        results = {
            "evaluate": self.evaluated(trials=12),
            "sensitivity": self.json_of("sensitivity", STRAIGHT, *SHORT, "--trials", 20)}
        file, page = self.path("result.json"), self.path("page.html")

        def leaves(value, at=()):
            if isinstance(value, (dict, list)) and value:
                for key, part in value.items() if isinstance(value, dict) else enumerate(value):
                    yield from leaves(part, (*at, key))
            else:
                yield at

        shown = 0
        for verb, result in results.items():
            seen = set()
            for at in leaves(result):
                kind = tuple("*" if isinstance(key, int) else key for key in at)
                # Of a list one, and of the scene's numbers some.
                if kind in seen or (at[:2] == ("provenance", "scene") and len(at) > 5):
                    continue
                seen.add(kind)
                changed = json.loads(json.dumps(result))
                place = changed
                for key in at[:-1]:
                    place = place[key]
                place[at[-1]] = f"ferrule {verb} {mark}" if at[-1] == "command" else mark
                with open(file, "w") as out:
                    json.dump(changed, out)
                run = ferrule("report", file, "--out", page)
                self.assertIn(run.returncode, (0, 2), (at, run.stderr))
                if run.returncode != 0:
                    continue
                html = open(page).read()
                shown += "&lt;script&gt;" in html
                for tag in ("<script", "<img src=x"):
                    self.assertNotIn(tag, html, at)
                self.styled_by_its_own(html)
                self.assertNotIn("script-src", html)
        self.assertGreater(shown, 20)

    def test_the_page_refuses_what_is_no_result(self):
        with open(self.path("other.json"), "w") as out:
            out.write('{"rows": [], "provenance": {"command": "ferrule sweep"}}')
        self.refused(2, "report", self.path("other.json"), says=["other.json", "--json"])
        with open(self.path("half.json"), "w") as out:
            out.write('{"rows": [')
        self.refused(2, "report", self.path("half.json"), says=["half.json"])
        self.refused(3, "report", self.path("none.json"), says=["none.json"])
        self.assertFalse(os.path.exists("report.html"))


if __name__ == "__main__":
    main()

import csv
import glob
import json
import math
import os
import re
import signal
import subprocess
import time
import xml.dom.minidom

import h5py
import numpy

from case import PROGRAM, SOURCE, Case, ferrule, main

# Short: 30 um instead of 270.
SCENE = ["--set", "start.distance_um=20", "--set", "success.depth_um=10",
         "--set", "start.lateral_sd_um=8"]
TRIALS = 12


def wilson(successes, trials):
    z = 1.959963984540054
    p = successes / trials
    centre = (p + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * math.sqrt(p * (1 - p) / trials + z * z / (4 * trials ** 2))
    return max(0, centre - half), min(1, centre + half)


class Compare(Case):
    def setUp(self):
        super().setUp()
        self.out = self.path("out")
        self.done("record", "--scene", "bench", *SCENE, "--episodes", 5, "--out", self.out)

    def compared(self, *more):
        return self.done("compare", self.out, *SCENE, "--trials", TRIALS, "--learners",
                         "linear,insertion", *more)

    def test_all_on_the_same_trials(self):
        plots = self.path("plots")
        run = self.compared("--json", "--demonstrations", "4,9", "--transfer", "tight", "--plot",
                            plots)
        self.assertIn("9 demonstrations asked for, 5 are there", run.stderr)
        found = json.loads(run.stdout)
        rows = {row["controller"]: row for row in found["rows"]}
        self.assertEqual(list(rows), ["constant velocity", "tuned by hand",
                                      "best demonstration again", "simulated operator",
                                      "ceres, linear", "ceres, insertion"])
        operator = rows["simulated operator"]
        for name, row in rows.items():
            for part in (row, row["supervised"]):
                self.assertEqual(sum(part["outcomes"].values()), TRIALS)
                self.assertEqual(part["feasible"], TRIALS)
                self.assertEqual(part["outcomes"].get("inserted", 0), part["successes"])
                low, high = wilson(part["successes"], TRIALS)
                self.assertAlmostEqual(part["wilson_low"], low, delta=1e-12)
                self.assertAlmostEqual(part["wilson_high"], high, delta=1e-12)
            self.assertNotIn("interventions", row)
            self.assertIn("retreat", row["supervised"]["interventions"])
            self.assertEqual(sum(ring["feasible"] for ring in row["misalignment"]), TRIALS)
            self.assertEqual(sum(ring["inserted"] for ring in row["misalignment"]),
                             row["successes"])
            self.assertGreater(row["ns_per_action"], 0)
            fitted = name.startswith("ceres")
            self.assertEqual(row["held_out_mm_s"] is not None, fitted)
            self.assertEqual(row["parameters"],
                             {"ceres, linear": 6, "ceres, insertion": 12}.get(name, 0))
            if row is operator:
                self.assertNotIn("against_operator", row)
                continue
            against = row["against_operator"]
            self.assertAlmostEqual(against["difference"],
                                   row["success_rate"] - operator["success_rate"], delta=1e-12)
            self.assertLessEqual(against["difference_low"], against["difference"])
            self.assertLessEqual(against["difference"], against["difference_high"])
            force = against["peak_force_difference_uN"]
            self.assertLessEqual(force["low"], force["median"])
            self.assertLessEqual(force["median"], force["high"])

        # The trials are those of evaluate.
        alone = json.loads(self.done("evaluate", "--baseline", "constant-velocity", "--scene",
                                     "bench", *SCENE, "--trials", TRIALS, "--json").stdout)
        for key in ("successes", "outcomes", "time_s", "peak_force_uN", "loss_dB"):
            self.assertEqual(alone[key], rows["constant velocity"][key])

        self.assertEqual([(l["controller"], l["demonstrations"])
                          for l in found["by_demonstrations"]],
                         [("ceres, linear", 4), ("ceres, insertion", 4)])
        self.assertEqual([(t["scene"], t["controller"]) for t in found["transfer"]],
                         [("tight", name) for name in rows])
        for there in found["transfer"]:
            self.assertEqual(there["trials"], TRIALS)
            self.assertIn("interventions", there["supervised"])
        drawn = sorted(name for name in os.listdir(plots) if name.endswith(".svg"))
        self.assertEqual(len(drawn), 2 + len(rows))
        for name in drawn:
            xml.dom.minidom.parse(os.path.join(plots, name))
        forces = self.forces_in_report(plots + "/report.html")
        self.assertEqual(list(forces),
                         ["5 demonstrations", *(f"{name}, {TRIALS} trials" for name in rows)])
        for runs in forces.values():
            self.assertEqual(list(runs), list(forces["5 demonstrations"]))
            self.assertEqual(runs["gravity"]["acts"], "100.0 %")
            self.assertEqual(runs["gravity"]["reaches"], "0.0 %")
        friction = []  # of all rows that were learned from [uN]
        for file in glob.glob(self.out + "/*.h5"):
            with h5py.File(file) as episode:
                rows = episode["data/demo_0/rows/forces"]
                at = list(rows.attrs["columns"]).index(b"friction_x")
                friction.append(1e6 * numpy.linalg.norm(rows[:, at:at + 3], axis=1))
        friction = numpy.concatenate(friction)
        acting = friction[friction > 0]
        told = forces["5 demonstrations"]["friction"]
        self.assertEqual(told["acts"], f"{100 * len(acting) / len(friction):.1f} %")
        self.assertEqual(told["median uN"], f"{numpy.median(acting):.4g}")
        self.assertEqual(told["largest uN"], f"{acting.max():.4g}")

    def test_everybody_climbs_the_ladder(self):
        trials = 4
        found = json.loads(self.done("compare", self.out, "search", *SCENE, "--trials", trials, "--learners",
                                     "linear", "--seeds", "3,5", "--ladder", "--supervise", "--ablate",
                                     "force,tilt,variation", "--json").stdout)["ladder"]
        rungs = sorted("ladder/" + os.path.basename(file)[:-5]
                       for file in glob.glob(SOURCE + "/data/scenes/ladder/*.json"))
        who = [(row["controller"], row["training_seed"]) for row in found if row["rung"] == rungs[0]]
        self.assertEqual(who[:5], [("constant velocity", None), ("tuned by hand", None),
                                   ("best demonstration again", None), ("simulated operator", None),
                                   ("blind spiral", None)])
        self.assertEqual(who[5][0], "search")
        self.assertEqual(who[5][1], None)
        less = [(f"ceres, linear, no {what}", seed) for seed in (3, 5) for what in ("force", "variation")]
        self.assertEqual(who[6:], [("ceres, linear", 3), ("ceres, linear", 5), *less,
                                   ("search, no force", None), ("search, no tilt", None)])
        self.assertEqual([row["rung"] for row in found], [rung for rung in rungs for _ in who])
        for row in found:
            self.assertEqual(row["trials"], trials)
            self.assertEqual(row["without"], row["controller"].partition(", no ")[2] or None)
            self.assertLessEqual(row["wilson_low"], row["success_rate"])
            if row["success_rate"] > 0:
                self.assertLess(row["search_s"], row["time_s"])
            else:
                self.assertIsNone(row["time_s"])
        for name, arguments in ((who[5][0], ["search"]), ("blind spiral", ["--baseline", "spiral"])):
            alone = json.loads(self.done("evaluate", *arguments, "--scene", "ladder/c", "--trials", trials,
                                         "--json").stdout)
            row, = (r for r in found if (r["rung"], r["controller"]) == ("ladder/c", name))
            self.assertEqual(row["success_rate"], alone["success_rate"])
            self.assertEqual(row["time_s"], alone["time_s"]["median"])
            self.assertEqual(row["peak_force_uN"], alone["peak_force_uN"]["median"])
            kept = json.loads(self.done("evaluate", *arguments, "--scene", "ladder/c", "--trials", trials, "--supervise",
                                        "--json").stdout)
            for key in ("success_rate", "time_s", "peak_force_uN", "interventions", "gave_up"):
                self.assertEqual(row["supervised"][key], kept[key])
        # One learner that was fitted once has the seed of that.
        plots = self.path("rungs")
        once = self.done("compare", self.out, *SCENE, "--trials", 20, "--learners", "linear", "--fit-seed", 9,
                         "--ladder", "--plot", plots).stdout
        drawn = glob.glob(plots + "/ladder_*.svg")
        self.assertTrue(drawn)
        for file in drawn:
            self.assertIn("ladder/" + os.path.basename(file)[len("ladder_"):-len(".svg")], rungs)
            xml.dom.minidom.parse(file)
        self.assertIn("ceres, linear, seed 9", once)
        self.assertRegex(once, r"constant velocity .* of \S+ to \S+")  # its worst tenth

    # With --seeds each recording is learned from anew, in all that is asked for.
    def test_each_recording_is_learned_from(self):
        arguments = ["compare", self.out, "tuned_by_hand", *SCENE, "--trials", 4, "--learners", "linear",
                     "--demonstrations", "4", "--transfer", "tight"]
        found = json.loads(self.done(*arguments, "--seeds", "3,5", "--json").stdout)
        operator = next(row for row in found["rows"] if row["controller"] == "simulated operator")
        for row, seed in zip(found["by_seeds"], (3, 5), strict=True):
            self.assertEqual((row["controller"], row["seed"]), ("ceres, linear", seed))
            self.assertAlmostEqual(row["against_operator"]["difference"],
                                   row["success_rate"] - operator["success_rate"], delta=1e-12)
            # That recording is one which anybody can make.
            again = self.path(f"again_{seed}")
            self.done("record", *SCENE, "--scene", "bench", "--episodes", 5, "--seed", seed, "--out", again)
            alone = json.loads(self.done(*[again if a == self.out else a for a in arguments], "--fit-seed", seed,
                                         "--json").stdout)
            for key in ("by_demonstrations", "transfer"):
                self.assertEqual([r for r in found[key] if r.get("training_seed") == seed],
                                 [r for r in alone[key] if r.get("training_seed") == seed])
        self.assertEqual(len({row["time_s"]["median"] for row in found["by_demonstrations"]}), 2)
        self.assertEqual([(row["controller"], row["training_seed"]) for row in found["transfer"][-3:]],
                         [("tuned_by_hand", None), *(("ceres, linear", seed) for seed in (3, 5))])
        table = self.done(*arguments, "--seeds", "3,5").stdout
        for part in ("the worst of the seeds, and their median", "median of 2",
                     "of several seeds the worst, and below it the median"):
            self.assertIn(part, table)

    def test_the_result_does_not_depend_on_threads(self):
        def timeless(text):  # without what is measured by a clock
            found = json.loads(text)
            for row in found["rows"]:
                del row["fit_s"], row["ns_per_action"]
            return found
        one, two = (timeless(self.compared("--json", "--threads", n).stdout) for n in (1, 2))
        self.assertEqual(one, two)
        table = self.compared().stdout
        for part in ("under the supervisor", "McNemar", "minus simulated operator"):
            self.assertIn(part, table)

    def test_refusals(self):
        self.refused(2, "compare", self.out, "--learners", "cubic", says=["cubic"])
        self.refused(2, "compare", self.out, "--learners", "linear,insertion,linear",
                     says=["linear is there twice"])
        self.refused(2, "compare", self.out, "--transfer", "paper",
                     says=["paper", "scales the hand otherwise"])
        self.refused(3, "compare", self.path("none"), says=["none"])
        # Before anything that takes long.
        by_hand = self.path("by_hand")
        self.done("record", "--scene", "bench", *SCENE, "--set", "limits.speed_um_s=100",
                  "--device", "fake:spacemouse", "--episodes", 1, "--out", by_hand)
        self.refused(2, "compare", by_hand, "--seeds", "1..2", "--json",
                     says=["fake:spacemouse", "nobody can record again"])
        for n in (1, 2, 3):
            os.remove(f"{self.out}/episode_000{n}.h5")
        self.refused(2, "compare", self.out, "--learners", "linear",
                     says=["linear", "too few demonstrations: 2"])

    # Parts as they come: pairs that interfere are counted, and no failure of anybody.
    def test_infeasible_pairs_are_no_failures(self):
        narrow = ["--set", "tolerance.bore_diameter_um=[124.8,125.6]"]
        found = json.loads(self.done("evaluate", "--baseline", "constant-velocity", "--scene",
                                     "tolerance", *SCENE, *narrow, "--trials", 40, "--json").stdout)
        infeasible = found["outcomes"]["infeasible"]
        self.assertGreater(infeasible, 3)
        self.assertLess(infeasible, 30)
        self.assertEqual(found["feasible"], 40 - infeasible)
        self.assertAlmostEqual(found["success_rate"], found["successes"] / found["feasible"],
                               delta=1e-12)
        self.assertAlmostEqual(found["wilson_low"],
                               wilson(found["successes"], found["feasible"])[0], delta=1e-12)
        none = ["--set", "tolerance.bore_diameter_um=[124,124.2]"]
        found = json.loads(self.done("evaluate", "--baseline", "constant-velocity", "--scene",
                                     "tolerance", *none, "--trials", 5, "--json").stdout)
        self.assertEqual((found["feasible"], found["success_rate"]), (0, None))

    # Whatever happened in the trials.
    def test_columns_of_csv_are_always_the_same(self):
        infeasible = ["--set", "tolerance.bore_diameter_um=[124,124.2]"]
        late = ["--set", "limits.time_s=0.01"]
        for more in ([], ["--supervise"]):
            heads = set()
            for scene in ([], infeasible, late):
                trials = self.path("trials.csv")
                text = self.done("evaluate", "--baseline", "constant-velocity", "--scene", "tolerance",
                                 *SCENE, *scene, *more, "--trials", 4, "--csv", "--trials-out", trials).stdout
                with open(trials) as file:
                    heads.add((text.splitlines()[0], file.readline()))
            self.assertEqual(len(heads), 1)
            for outcome in ("inserted", "timeout", "infeasible", "invalid_output", "gave_up"):
                self.assertIn(f"outcomes.{outcome}", next(iter(heads))[0].split(","))
        heads = {self.done("compare", self.out, *SCENE, *scene, "--trials", 2, "--learners", "linear",
                           "--csv").stdout.splitlines()[0]
                 for scene in ([], late, ["--set", 'tolerance={"fibre_diameter_sd_um":0,'
                                          '"bore_diameter_um":[124,124.2]}'])}
        self.assertEqual(len(heads), 1)

    # Constant velocity inserts from within 10 um of the axis, and nowhere else.
    def test_says_where_a_controller_fails_most(self):
        def evaluated(*more):
            arguments = ["evaluate", "--baseline", "constant-velocity", "--scene", "bench", *more]
            return json.loads(self.done(*arguments, "--json").stdout), self.done(*arguments).stdout
        told, text = evaluated("--trials", 600)
        where = told["worst_tenth_of"]
        self.assertEqual(where["key"], "start.lateral_um")
        self.assertGreater(where["low"], 10)
        self.assertEqual(told["worst_tenth"], 0)
        self.assertIn(f"where start.lateral_um is {where['low']:.4g} to {where['high']:.4g}: "
                      f"0 of {where['trials']} inserted", text)
        trials = self.path("where.csv")
        noisy = ["--set", "sensor.noise_uN=0.5..2"]
        self.done("evaluate", "--baseline", "constant-velocity", "--scene", "bench", *noisy, "--trials", 60,
                  "--trials-out", trials)
        with open(trials, newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len({row["sensor.noise_uN"] for row in rows}), 60)
        for row in rows:
            near = float(row["start.lateral_um"])
            self.assertTrue(near < 11 if row["outcome"] == "inserted" else near > 9, row)
            self.assertTrue(0.5 <= float(row["sensor.noise_uN"]) <= 2)
        told, text = evaluated("--trials", 300, "--set", "start.lateral_sd_um=2", *noisy)
        self.assertEqual(told["successes"], 300)
        self.assertIsNone(told["worst_tenth_of"]["key"])
        self.assertNotIn("fails most", text)

    # Nothing is drawn of trials that nobody runs.
    def test_trials_out_has_the_trials_that_decided(self):
        trials = self.path("few.csv")
        self.done("compare", self.out, *SCENE, "--learners", "linear", "--target", 0.5, "--trials", 20000000,
                  "--trials-out", trials)
        with open(trials, newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertIn("ceres, linear", {row["controller"] for row in rows})
        self.assertTrue(all(float(row["start.lateral_um"]) >= 0 for row in rows))

    def test_a_rate_says_what_would_show_more(self):
        def evaluated(trials, *more):
            arguments = ["evaluate", "--baseline", "constant-velocity", "--scene", "bench", *SCENE,
                         "--trials", trials, *more]
            return json.loads(self.done(*arguments, "--json").stdout), self.done(*arguments).stdout
        # All go in that begin before the bore; wilson(381, 381) is the first above 99 %.
        straight = ["--set", "start.lateral_sd_um=0", "--set", "start.tilt_sd_mrad=0"]
        told, text = evaluated(20, *straight)
        self.assertEqual(told["successes"], 20)
        self.assertGreaterEqual(wilson(381, 381)[0], 0.99)
        self.assertLess(wilson(380, 380)[0], 0.99)
        self.assertEqual(told["trials_to_show_99"], 361)
        self.assertGreaterEqual(wilson(3838, 3838)[0], 0.999)
        self.assertLess(wilson(3837, 3837)[0], 0.999)
        self.assertEqual(told["trials_to_show_99_9"], 3818)
        self.assertIn("99 %: 361 more trials without a failure", text)
        self.assertFalse(told["time_limit_decides"])
        told, text = evaluated(4, "--set", "limits.time_s=0.01")
        self.assertIsNone(told["trials_to_show_99"])
        self.assertIn("not reachable at this rate", text)
        self.assertTrue(told["time_limit_decides"])
        self.assertIn("the time limit (limits.time_s) ended 4 of 4 failures", text)
        run = self.compared("--set", "limits.time_s=0.01")
        self.assertIn("ceres, linear: the time limit (limits.time_s) ended 12 of 12 failures",
                      run.stdout)
        run = self.done("record", "--scene", "bench", *SCENE, "--set", "limits.time_s=0.01",
                        "--episodes", 2, "--out", self.path("late"))
        self.assertIn("the time limit (limits.time_s) ended 2 of 2 failures", run.stdout)

    # With nothing to compare there is no difference, and that is no error.
    def test_a_baseline_beside_a_controller_without_any_feasible_pair(self):
        law = self.path("law.json")
        self.done("fit", self.out, "--law", "linear", "--out", law)
        arguments = ("evaluate", law, "--baseline", "constant-velocity", "--scene", "tolerance",
                     "--set", "tolerance.bore_diameter_um=[124,124.2]", "--trials", 3)
        found = json.loads(self.done(*arguments, "--json").stdout)
        self.assertEqual((found["feasible"], found["baseline"]["feasible"]), (0, 0))
        self.assertNotIn("difference", found["baseline"])
        self.assertNotIn("nan", self.done(*arguments).stdout)

    def test_each_controller_is_tried_until_enough_is_known(self):
        arguments = ["compare", self.out, *SCENE, "--learners", "linear", "--json"]

        def rows(code, *more):
            run = ferrule(*arguments, *more)
            self.assertEqual(run.returncode, code, run.stderr)
            return {row["controller"]: row for row in json.loads(run.stdout)["rows"]}

        some = rows(0, "--trials", 200, "--target", 0.5)
        verdicts = {row["target"]["verdict"] for row in some.values()}
        self.assertIn("shown", verdicts)
        for row in some.values():
            for part in (row, row["supervised"]):
                self.assertEqual(part["trials"], part["target"]["trials"])
                self.assertEqual(part["target"]["verdict"] == "undecided", part["trials"] == 200)
        text = self.done(*arguments[:-1], "--trials", 200, "--target", 0.5).stdout
        self.assertIn(f"50 % shown after {some['simulated operator']['target']['trials']} trials", text)
        # None of them inserts where the time does not suffice.
        rows(1, "--trials", 60, "--target", 0.5, "--set", "limits.time_s=0.01")

    # A campaign may take long: Ctrl-C ends it with what it has, said to be partial.
    def test_ctrl_c_ends_it_at_once(self):
        process = subprocess.Popen([PROGRAM, "compare", self.out, "--trials", "100000", "--learners",
                                    "linear"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        self.addCleanup(process.kill)
        while b"fitted" not in process.stderr.readline():
            pass
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        told = process.communicate(timeout=20)[0].decode()
        self.assertEqual(process.returncode, 130)
        self.assertIn("PARTIAL", told)
        self.assertIn("constant velocity: ", told)

    def test_sensors_and_tolerances_that_cannot_be(self):
        for setting, says in (("sensor.noise_uN=-1", "sensor.noise_uN = -1: must not be negative"),
                              ("sensor.bias_uN=\"no\"", "sensor.bias_uN"),
                              ("sensor.bandwidth_Hz=0", "sensor.bandwidth_Hz = 0: must be positive"),
                              ("sensor.resolution_uN=-0.1", "sensor.resolution_uN"),
                              ("sensor.moment_arm_mm=0", "sensor.moment_arm_mm"),
                              ("sensor.noise_N=1", "unknown key"),
                              ("tolerance={\"fibre_diameter_sd_um\":-1,\"bore_diameter_um\":[125,126]}",
                               "tolerance.fibre_diameter_sd_um"),
                              ("tolerance={\"fibre_diameter_sd_um\":0.1,\"bore_diameter_um\":[126,125]}",
                               "tolerance.bore_diameter_um")):
            self.refused(2, "evaluate", "--baseline", "constant-velocity", "--scene", "bench",
                         "--set", setting, says=[says])


if __name__ == "__main__":
    main()

import csv
import glob
import json
import math
import os

import h5py

from case import QUICK, SOURCE, Case, main


class Bench(Case):
    def test_contact_gives_the_published_values(self):
        rows = json.loads(self.done("contact", "--lambda", 4, "--radius", "0.3,1,2", "--json").stdout)
        rows = rows["rows"]
        self.assertEqual([row["A"] for row in rows], [0.3, 1, 2])
        for row, m, p, d in ((rows[1], 1.044223169, -1.476575195, -0.603569589),
                             (rows[2], 1.021379139, 1.252730387, 1.782581218)):
            self.assertAlmostEqual(row["m"], m, delta=1e-9)
            self.assertAlmostEqual(row["P"], p, delta=1e-9)
            self.assertAlmostEqual(row["D"], d, delta=1e-9)
        for lam in (0.01, 0.7, 0.93, 100):
            self.done("contact", "--lambda", lam, "--curve", "--json", "--plot", self.path("c.svg"))
            self.assertIn("</svg>", open(self.path("c.svg")).read())
        for bad in ("0", "101", "nan", "x"):
            self.refused(2, "contact", "--lambda", bad, "--curve", says=["--lambda"])
        self.refused(2, "contact", "--lambda", 4, "--radius", "1,-1", says=["--radius"])

    def test_what_is_not_finite_is_an_empty_cell(self):
        rows = list(csv.DictReader(self.done("bench", "hard", "--csv").stdout.splitlines()))
        self.assertEqual(len(rows), 21)
        in_json = json.loads(self.done("bench", "hard", "--json").stdout)["rows"]
        self.assertIn(None, [value for row in in_json for value in row.values()])
        for row, wanted in zip(rows, in_json, strict=True):
            for key, value in wanted.items():
                self.assertEqual(row[key] == "", value is None, key)

    def test_solver_parameters_are_halved_and_doubled(self):
        rows = json.loads(self.done("bench", "parameters", "--scene", "easy", "--json").stdout)["rows"]
        self.assertEqual(rows[0]["parameter"], "none")
        self.assertLess(rows[0]["error_p99_clearances"], 1e-4)
        for low, high in zip(rows[1::2], rows[2::2]):
            self.assertEqual(low["parameter"], high["parameter"])
            self.assertEqual((low["factor"], high["factor"]), (0.5, 2))
            self.assertEqual(low["steps"], rows[0]["steps"])
        self.assertEqual(len({row["parameter"] for row in rows}), 16)
        radius = {row["factor"]: row for row in rows if row["parameter"] == "extrapolation_error"}
        self.assertGreater(radius[0.5]["evaluations"], radius[2]["evaluations"])

    def test_a_plan_is_a_scene_and_accuracy_applies_it(self):
        plan = json.loads(self.done("plan", "--scene", "demo", "--tolerance", 0.02, "--json",
                                    "--out", self.path("planned.json")).stdout)
        self.assertEqual(set(plan), {"tolerance", "terms", "dynamics", "step_s", "tangent",
                                     "sampled_twice", "sampling_counts", "rings_s",
                                     "error_bound", "provenance"})
        self.assertEqual(plan["tolerance"], 0.02)
        self.assertLessEqual(plan["error_bound"], 0.02)
        for term in plan["terms"]:
            self.assertEqual(set(term), {"name", "kept", "fidelity", "max_force_uN",
                                         "relative_error", "cost_ns"})
        planned = json.load(open(self.path("planned.json")))
        self.assertEqual(planned["planned_accuracy"], 0.02)
        for term in plan["terms"]:
            if not term["kept"] and term["name"] != "inertia":
                self.assertIsNone(planned["laws"][term["name"]])
        # The same scene by its key.
        self.done("record", "--scene", "demo", "--set", "accuracy=0.02", "--operator", "simulated",
                  "--episodes", 1, "--seed", 4, "--out", self.path("a"))
        self.done("record", "--scene", self.path("planned.json"), "--operator", "simulated",
                  "--episodes", 1, "--seed", 4, "--out", self.path("b"))
        with h5py.File(self.path("a/episode_0001.h5")) as a, \
                h5py.File(self.path("b/episode_0001.h5")) as b:
            recorded = json.loads(a.attrs["scene"])
            for key in recorded.pop("drawn_from")["added"]:
                del recorded["start"][key.removeprefix("start.")]
            self.assertEqual(recorded, planned)
            self.assertTrue((a["data/demo_0/states"][:] == b["data/demo_0/states"][:]).all())
        self.done("replay", self.path("a/episode_0001.h5"), "--verify")

    def test_a_plan_for_the_success_rate_keeps_it_and_its_recordings_replay(self):
        planned = self.path("planned.json")
        plan = json.loads(self.done("plan", "--scene", "bench", "--tolerance-of", "success",
                                    "--json", "--out", planned).stdout)
        self.assertLessEqual(plan["error_bound"], 0.01)
        self.assertGreater(plan["tangent"], 0)
        law = os.path.join(SOURCE, "data/controllers/tuned_by_hand.json")
        rates = [json.loads(self.done("evaluate", law, "--scene", scene, "--trials", 30,
                                      "--baseline", "constant-velocity", "--json").stdout)
                 for scene in ("bench", planned)]
        for full, reduced in zip(rates[0]["rows"], rates[1]["rows"]):
            self.assertLessEqual(reduced["wilson_low"], full["success_rate"])
            self.assertGreaterEqual(reduced["wilson_high"], full["success_rate"])
        self.done("record", "--scene", planned, "--operator", "simulated", "--episodes", 1,
                  "--seed", 4, "--out", self.path("episodes"), *QUICK)
        self.done("replay", self.path("episodes/episode_0001.h5"), "--verify")
        self.refused(2, "plan", "--tolerance", 0.9, says=["--tolerance"])
        lines = self.done("evaluate", "--baseline", "constant-velocity", "--trials", 1, "--set",
                          "accuracy=1e-6").stdout.split("\n")
        self.assertTrue(lines[0].endswith("seed of trials 7"), lines)
        self.assertIn("NOT REACHED", lines[1])
        self.refused(2, "forces", "--set", "accuracy=2", says=["accuracy = 2"])

    def test_there_is_no_plot_of_capture(self):
        self.refused(2, "bench", "capture", "--plot", self.path("plots"), says=["--plot"])

    def test_turns_change_nothing(self):
        rows = json.loads(self.done("bench", "turns", "--scenes", 1, "--json").stdout)["rows"]
        self.assertEqual(len(rows), 30)
        for row in rows:
            self.assertEqual(row["mirrored"], 0, row)
            if row["scene"] not in ("demo", "dry", "film", "paper"):
                self.assertLess(max(row["turned_90"], row["turned_37"]), 1e-6, row)
                self.assertEqual(row["off"], 0)

    def test_events_of_one_scene(self):
        rows = json.loads(self.done("bench", "events", "--scene", "easy", "--scenes", 1,
                                    "--json").stdout)["rows"]
        self.assertEqual([row["scene"] for row in rows], 21 * ["easy"])
        for row in rows:
            if row["step_s"] < 2e-5:  # the finest, which the others are compared with
                self.assertEqual(row["pose_difference_clearances"], 0)
            elif row["motion"] != "jumps":
                self.assertLess(row["pose_difference_clearances"], 0.05, row)

    def test_errors_of_the_sensor_cost_insertions(self):
        rows = json.loads(self.done("bench", "sensors", "--scene", "bench", "--trials", 20, "--json").stdout)["rows"]
        inserted = {row["sensor"]: row["inserted"] for row in rows}
        self.assertEqual(len(inserted), 8)
        self.assertGreater(inserted["as shipped"], 15)
        self.assertLess(inserted["noise 2/3"], 5)
        self.assertLess(inserted["bias 1/3"], inserted["bias 1/3, tare"] - 5)

    def test_tail_bounds_every_step(self):
        rows = json.loads(self.done("bench", "tail", "--seed", 3, "--scenes", 2,
                                    "--json").stdout)["rows"]
        files = glob.glob(os.path.join(os.path.dirname(__file__), "../../data/scenes/*.json"))
        scenes = {os.path.basename(file)[:-5] for file in files} - {"scene.schema"}
        self.assertEqual({row["scene"] for row in rows}, scenes | {"random"})
        for row in rows:
            self.assertEqual(set(row), {"scene", "steps", "not_converged", "capped",
                                        "evaluations_p9999", "evaluations_max", "p9999_us",
                                        "worst_us", "loops", "loops_that_gained"})
            self.assertLess(row["evaluations_max"], 60)
            self.assertLessEqual(row["evaluations_p9999"], row["evaluations_max"])
            self.assertLessEqual(row["p9999_us"], row["worst_us"])
            self.assertEqual(row["loops"], 6 if row["scene"] == "random" else 2)
            self.assertEqual(row["loops_that_gained"], 0)
        self.refused(2, "bench", "tail", "--scenes", 0, says=["--scenes"])

    def test_capture_takes_exactly_what_fits(self):
        rows = json.loads(self.done("bench", "capture", "--json").stdout)["rows"]
        self.assertGreater(len(rows), 1000)
        # The cone's rim is at 125 um, the fibre's radius 62.5 um, the clearance 0.5 um.
        for row in rows:
            # A rounded rim adds its radius.
            takes = (125 if row["lead_in"] else 1) + row["edge_um"] / 0.5
            if row["cleave_deg"]:
                # The foremost point of the rim, in the direction 0, within the bore of 63 um.
                angle, r = math.radians(row["direction_deg"]), 62.5
                takes = (math.sqrt(63**2 - (r * math.sin(angle))**2) - r * math.cos(angle)) / 0.5
            self.assertAlmostEqual(row["capture_clearances"], takes, delta=1e-9 * takes)
            self.assertEqual(row["inserted"], row["offset_clearances"] < takes, row)
        for lead_in in (False, True):
            mine = [row for row in rows if row["lead_in"] == lead_in]
            self.assertEqual({(row["edge_um"], row["cleave_deg"]) for row in mine},
                             {(e, 0) for e in (0, 1, 5, 10)} | (set() if lead_in else {(0, 0.5), (0, 1)}))
            mine = [row for row in mine if row["edge_um"] == row["cleave_deg"] == 0]
            self.assertGreaterEqual({row["offset_clearances"] for row in mine},
                                    {0.5, 0.9, 0.98, 1.02, 1.1, 1.5, 3, 10, 30})
            self.assertGreater(max(row["offset_clearances"] for row in mine),
                               mine[0]["capture_clearances"])
            self.assertEqual({row["direction_deg"] for row in mine}, {45.0 * k for k in range(8)})
            self.assertEqual({(row["speed_um_s"], row["step_s"]) for row in mine},
                             {(v, dt) for v in (5, 50) for dt in (1e-4, 1e-3, 1e-2)})


if __name__ == "__main__":
    main()

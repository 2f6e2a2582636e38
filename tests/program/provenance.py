import csv
import hashlib
import io
import json
import os
import signal
import subprocess
import time

from case import PROGRAM, QUICK, SOURCE, Case, main


class Provenance(Case):
    def fitted(self):
        out, law = self.path("out"), self.path("law.json")
        self.record(out, episodes=6)
        self.done("fit", out, "--out", law)
        return out, law

    def first_line(self, *arguments):
        return self.done(*arguments).stdout.split("\n")[0]

    # A controller and a recording bring their scene along; another one is said first.
    def test_the_scene_is_brought_along(self):
        out, law = self.fitted()
        few = ["--trials", 2]
        line = self.first_line("evaluate", law, *few)
        self.assertTrue(line.startswith("scene paper with "), line)
        self.assertIn("start.distance_um = 10", line)
        self.assertIn("as " + law + " was trained on", line)
        line = self.first_line("evaluate", law, *few, "--scene", "dry")
        self.assertTrue(line.startswith("scene dry, NOT the scene paper that"), line)
        line = self.first_line("evaluate", law, *few, "--scene", "paper", *QUICK)
        self.assertIn(", as ", line)
        line = self.first_line("evaluate", law, *few, "--set", "start.lateral_sd_um=1")
        self.assertIn("changed from what", line)
        self.assertIn("start.lateral_sd_um = 1", line)
        line = self.first_line("compare", out, *few, "--learners", "linear")
        self.assertIn("as " + out + " was recorded in", line)
        line = self.first_line("record", "--operator", law, "--episodes", 1, "--out",
                               self.path("by_law"))
        self.assertIn("as " + law + " was trained on", line)
        told = json.loads(self.done("evaluate", law, *few, "--scene", "dry", "--json").stdout)
        self.assertTrue(told["provenance"]["scene"]["other_than_brought"])
        told = json.loads(self.done("evaluate", law, *few, "--json").stdout)
        self.assertFalse(told["provenance"]["scene"]["other_than_brought"])

    def test_what_is_of_several_scenes_asks_for_one(self):
        out, law = self.path("out"), self.path("law.json")
        self.record(out, episodes=4)
        self.record(out, "--append", "--set", "start.lateral_sd_um=3", episodes=4)
        self.done("fit", out, "--out", law)
        self.refused(2, "evaluate", law, "--trials", 1, says=["choose a scene with --scene"])
        self.refused(2, "compare", out, "--trials", 1, says=["2 different scenes"])
        self.done("evaluate", law, "--trials", 1, "--scene", "paper")

    # Parts that are drawn are of one scene, and that is the one which is brought along.
    def test_a_scene_with_tolerances_is_one(self):
        out, law = self.path("out"), self.path("law.json")
        self.record(out, "--set", "fibre.diameter_um=125+-0.3", episodes=6)
        self.done("fit", out, "--out", law)
        told = json.loads(self.done("evaluate", law, "--trials", 3, "--json").stdout)
        changes = told["provenance"]["scene"]["changes"]
        self.assertIn("tolerance", changes)
        self.assertNotIn("fibre.diameter_um", changes)

    def test_old_controller_files_still_run(self):
        _, law = self.fitted()
        old = json.load(open(law))
        for key in ("scene", "scaling", "limits"):
            del old["trained_on"][key]
        for part in ("episodes", "held_out"):
            for episode in old["trained_on"][part]:
                del episode["seed"], episode["trial"]
        json.dump(old, open(law, "w"))
        self.assertIn("the name alone", self.first_line("evaluate", law, "--trials", 2))
        self.done("evaluate", law, "--trials", 1, "--scene", "bench")
        old["trained_on"]["scenes"] = ["mine"]
        json.dump(old, open(law, "w"))
        self.refused(2, "evaluate", law, says=["mine", "--scene"])

    def test_another_scaling_is_refused_unless_asked_for(self):
        out, law = self.fitted()
        told = json.load(open(law))["trained_on"]
        self.assertGreater(told["scaling"]["alpha_x"], 0)
        self.assertEqual(told["limits"], {"speed_um_s": 20, "force_uN": 10})
        for arguments in (["evaluate", law, "--trials", 1],
                          ["compare", out, "--trials", 1, "--learners", "linear"],
                          ["record", "--operator", law, "--episodes", 1, "--out", self.path("b")]):
            more = ["--set", "scaling.tip_force_uN=77"]
            self.refused(2, *arguments, *more, says=["scales the hand otherwise"])
            self.done(*arguments, *more, "--other-scaling")

    def test_starts_that_were_trained_on_are_noticed(self):
        _, law = self.fitted()  # seed 1, trials 1 to 6
        told = json.loads(self.done("evaluate", law, "--seed", 1, "--trials", 5, "--json").stdout)
        self.assertEqual(told["trained_starts"], 4)  # 1 to 4; there is no episode 0
        self.assertIn("4 of the 5 trials begin where a demonstration did",
                      self.done("evaluate", law, "--seed", 1, "--trials", 5).stdout)
        told = json.loads(self.done("evaluate", law, "--trials", 5, "--json").stdout)
        self.assertEqual(told["trained_starts"], 0)

    def test_what_was_read_and_run_is_stated(self):
        _, law = self.fitted()
        arguments = ["evaluate", law, "--trials", 3, "--seed", 5, "--set", "limits.force_uN=9",
                     "--scene", "paper", "--json"]
        told = json.loads(self.done(*arguments).stdout)["provenance"]
        self.assertEqual(told["command"], "ferrule " + " ".join(map(str, arguments)))
        self.assertEqual(told["seeds"], {"trials": 5})
        self.assertEqual(told["scene"]["changes"]["limits.force_uN"], {"value": 9, "shipped": 10})
        hashes = {each["file"]: each["sha1"] for each in told["read"]}
        for file in (law, SOURCE + "/data/scenes/paper.json"):
            [found] = [h for f, h in hashes.items() if os.path.samefile(f, file)]
            self.assertEqual(found, hashlib.sha1(open(file, "rb").read()).hexdigest())
        self.assertRegex(told["version"], r"^\d+\.\d+\.\d+$")
        text = self.done(*arguments[:-1]).stdout
        for part in ("scene paper with limits.force_uN = 9", "seed of trials 5", "made by ferrule"):
            self.assertIn(part, text)

    def test_tables_as_csv(self):
        out, law = self.fitted()
        trials = self.path("trials.csv")
        for arguments, rows in ((["forces", "--gap-nm", "1:10:5"], 5), (["score", out], 6),
                                (["contact", "--radius", "0.5,1"], 2), (["scene", "bore"], None),
                                (["replay", out], 6), (["plan", "--tolerance", 0.1], None),
                                (["evaluate", law, "--trials", 4, "--baseline", "constant-velocity",
                                  "--trials-out", trials], 2)):
            text = self.done(*arguments, "--csv").stdout
            table = list(csv.DictReader(io.StringIO(text, newline="")))
            self.assertGreater(len(table), 0)
            if rows:
                self.assertEqual(len(table), rows, arguments)
            for row in table:
                self.assertNotIn(None, row)
                self.assertTrue(row["command"].startswith("ferrule " + arguments[0]))
        table = list(csv.DictReader(open(trials, newline="")))
        self.assertEqual([(row["controller"], int(row["trial"])) for row in table],
                         [(name, k) for name in (law, "constant-velocity") for k in range(4)])
        told = json.loads(self.done("evaluate", law, "--trials", 4, "--json").stdout)
        self.assertEqual(sum(row["outcome"] == "inserted" for row in table[:4]), told["successes"])
        self.refused(2, "score", out, "--csv", "--json", says=["--csv"])

    # The trials that are done are the first ones, and what is said of them is as without Ctrl-C.
    def test_ctrl_c_leaves_the_first_trials(self):
        process = subprocess.Popen([PROGRAM, "evaluate", "--baseline", "constant-velocity",
                                    "--trials", "1000000", "--json"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        time.sleep(3)
        process.send_signal(signal.SIGINT)
        text, _ = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130)
        part = json.loads(text)
        self.assertGreater(part["trials"], 0)
        self.assertIn(f"{part['trials']} of 1000000 trials", part["provenance"]["partial"])
        whole = json.loads(self.done("evaluate", "--baseline", "constant-velocity", "--trials",
                                     part["trials"], "--json").stdout)
        self.assertNotIn("partial", whole["provenance"])
        for key in ("successes", "outcomes", "time_s", "peak_force_uN"):
            self.assertEqual(part[key], whole[key])


if __name__ == "__main__":
    main()

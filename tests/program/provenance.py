import csv
import hashlib
import io
import json
import os
import pty
import signal
import subprocess
import time

from case import PROGRAM, QUICK, SOURCE, Case, ferrule, main


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
        self.assertEqual(changes["fibre.diameter_um"]["value"], {"normal": [125, 0.3 / 3]})

    def test_old_controller_files_still_run(self):
        _, law = self.fitted()
        old = json.load(open(law))
        for key in ("scene", "scaling", "limits"):
            del old["trained_on"][key]
        for part in ("episodes", "held_out"):
            for episode in old["trained_on"][part]:
                del episode["seed"], episode["trial"]
        json.dump(old, open(law, "w"))
        self.assertIn("the name only", self.first_line("evaluate", law, "--trials", 2))
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

    def test_every_table_is_there_as_csv_with_where_it_comes_from(self):
        out, law = self.fitted()
        for arguments, rows in ((["record", "--scene", "paper", *QUICK, "--episodes", 2, "--out",
                                  self.path("more")], 2), (["recover", out], 0),
                                (["fit", out, "--out", law, "--seeds", "1..2"], 14),
                                (["bench", "events", "--scene", "easy"], None), (["devices"], None),
                                (["devices", "--test", "fake:pid", "--seconds", 0.5], 3)):
            table = list(csv.DictReader(io.StringIO(ferrule(*arguments, "--csv").stdout,
                                                    newline="")))
            if rows is not None:
                self.assertEqual(len(table), rows, arguments)
            for row in table:
                self.assertNotIn(None, row)
                self.assertTrue(row["command"].startswith("ferrule " + arguments[0]))
        table = list(csv.DictReader(io.StringIO(self.done(
            "fit", out, "--out", law, "--seeds", "1..2", "--csv").stdout, newline="")))
        gains = json.load(open(law))["gains"]
        found = {row["name"]: float(row["value"]) for row in table}
        for name, gain in gains.items():
            self.assertAlmostEqual(found[name], gain["value"])
        for row in table:
            self.assertLessEqual(float(row["over_seeds.lowest"]), float(row["over_seeds.highest"]))
        files = [out + f"/episode_000{n}.h5" for n in range(1, 7)]
        hashes = "".join(hashlib.sha1(open(file, "rb").read()).hexdigest() for file in files)
        self.assertEqual(table[0]["read_sha1"], hashlib.sha1(hashes.encode()).hexdigest())

    def test_every_json_says_where_it_comes_from(self):
        out, law = self.fitted()
        for arguments in (["bench", "events", "--scene", "easy"], ["devices"], ["recover", out],
                          ["devices", "--test", "fake:spacemouse", "--seconds", 0.1],
                          ["export", law, "--header", self.path("law.h")]):
            arguments = [*arguments, "--json"]
            told = json.loads(self.done(*arguments).stdout)["provenance"]
            self.assertEqual(told["command"], "ferrule " + " ".join(map(str, arguments)))
            self.assertRegex(told["version"], r"^\d+\.\d+\.\d+$")
        self.assertEqual(told["read"], [{"file": law, "sha1": hashlib.sha1(
            open(law, "rb").read()).hexdigest()}])
        for arguments in (["recover", out], ["export", law, "--header", self.path("law.h")]):
            self.assertIn("made by ferrule", self.done(*arguments).stdout)

    # One rule: what brings no scene along is in demo.
    def test_without_a_scene_it_is_demo(self):
        for arguments in (["forces"], ["plan", "--tolerance", 0.1], ["scene", "bore"],
                          ["evaluate", "--baseline", "constant-velocity", "--trials", 1],
                          ["doctor", "--seconds", 0.01],
                          ["record", "--episodes", 1, "--out", self.path("out")]):
            told = json.loads(self.done(*arguments, "--json").stdout)["provenance"]["scene"]
            self.assertEqual((told["name"], told["changes"]), ("demo", {}), arguments)
        for verb in ("forces", "plan", "scene", "evaluate", "doctor", "record", "demo"):
            text = " ".join(self.done(verb, "--help").stdout.split())
            self.assertRegex(text, "unless given .*demo")
        for verb in ("compare", "identify"):
            text = " ".join(self.done(verb, "--help").stdout.split())
            self.assertIn("unless given that of the episodes", text)

    # On a terminal it says how far it is; Ctrl-C ends it with what it has, said to be partial.
    def test_long_work_shows_progress_and_can_be_stopped(self):
        for arguments in (["plan", "--scene", "adhesive", "--set", "dynamics=inertial"], ["bench"],
                          ["bench", "hard"], ["bench", "capture"]):
            terminal, other_end = pty.openpty()
            process = subprocess.Popen([PROGRAM, *arguments, "--json"], stdout=subprocess.PIPE,
                                       stderr=other_end)
            os.close(other_end)
            told = b""
            while b"s left" not in told:
                told += os.read(terminal, 1000)
            self.assertIn(b"/s", told)
            process.send_signal(signal.SIGINT)
            text = process.communicate(timeout=60)[0]
            os.close(terminal)
            self.assertEqual(process.returncode, 130, arguments)
            self.assertTrue(json.loads(text)["provenance"]["partial"])

    def test_a_table_of_forces_is_bounded(self):
        self.refused(2, "forces", "--gap-nm", "1:500:1001", "--length-um", "1:100:200",
                     says=["at most 200000"])

    # What takes long is not lost to a file that cannot be written.
    def test_results_are_told_though_files_cannot_be_written(self):
        out, law = self.fitted()
        nowhere = ["--trials-out", self.path("none/trials.csv")]
        self.refused(3, "evaluate", law, "--trials", 2, *nowhere, says=["there is no folder"])
        self.refused(3, "compare", out, "--trials", 2, *nowhere, says=["there is no folder"])
        os.makedirs(self.path("plots/misalignment.svg"))
        run = ferrule("compare", out, "--trials", 2, "--learners", "linear", "--plot",
                      self.path("plots"), "--json")
        self.assertEqual(run.returncode, 3)
        self.assertEqual(len(json.loads(run.stdout)["rows"]), 5)

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

"""A controller that becomes better than its teacher."""

import json
import os
import signal
import subprocess

from case import PROGRAM, QUICK, SOURCE, Case, main

WORDS = ["improve", "tuned_by_hand", "--scene", "bench", *QUICK, "--trials-each", 4, "--trials", 1500, "--unseen", 40]


class Improve(Case):
    def test_the_file_is_what_it_says(self):
        out = self.path("better.json")
        result = json.loads(self.done(*WORDS, "--out", out, "--json").stdout)
        before, after = result["before"], result["after"]
        self.assertLess(after["time_s"], before["time_s"])
        self.assertLessEqual(result["trials"], 1500)
        self.assertEqual([row["trials"] for row in result["rows"]], sorted(row["trials"] for row in result["rows"]))
        with open(out) as file:
            self.schema_validator("controller.schema.json").validate(json.load(file))
        for controller, row in (("tuned_by_hand", before), (out, after)):
            alone = json.loads(self.done("evaluate", controller, "--scene", "bench", *QUICK, "--trials", 40,
                                         "--json").stdout)
            self.assertEqual(alone["time_s"]["median"], row["time_s"])
            self.assertEqual(alone["success_rate"], row["success_rate"])
        change, told = result["change"], result["change"]["told_apart"]
        self.assertLess(change["time_difference_s"]["high"], 0)
        self.assertTrue(told["time"])
        self.assertEqual(told["success"], change["difference_low"] > 0 or change["difference_high"] < 0)
        self.assertEqual(sum(centre["chosen"] for centre in result["choice"]), 1)
        self.assertEqual([centre["before"] for centre in result["choice"]],
                         [True] + (len(result["choice"]) - 1) * [False])
        text = self.done("improve", out, "--set", "limits.time_s=50", "--trials", 1000, "--trials-each", 4,
                         "--unseen", 5, "--objective", "success", "--out", self.path("again.json")).stdout
        self.assertIn("cruise_speed", text)
        self.assertIn("these trials do not tell it from before", text)
        self.assertIn("time (too few trials)", text)
        self.assertRegex(text, "chosen of [0-9]+ by 200 trials each in each scene, which (do not )?tell it from ")

    def test_a_search_keeps_the_sizes_of_its_parts(self):
        out = self.path("better.json")
        self.done("improve", "search", *WORDS[2:], "--out", out)
        with open(out) as file, open(SOURCE + "/data/controllers/search.json") as shipped:
            after, before = json.load(file)["gains"], json.load(shipped)["gains"]
        for size in ("fibre_radius", "bore_radius", "mouth_radius", "lead_in_length"):
            self.assertEqual(after[size], before[size])
        changed = [name for name in after if after[name]["source"].startswith("improved from")]
        self.assertEqual(len(changed), len(after) - 4)

    def test_several_scenes_count_alike(self):
        out = self.path("better.json")
        result = json.loads(self.done(*WORDS[:-4], "--also", "sticky,tight", "--trials", 3000, "--unseen", 40,
                                      "--out", out, "--json").stdout)
        self.assertEqual([row["scene"] for row in result["scenes"]], ["bench", "sticky", "tight"])
        self.assertEqual(result["after"], result["scenes"][0]["after"])
        for row in result["scenes"]:
            alone = json.loads(self.done("evaluate", out, "--scene", row["scene"],
                                         *(QUICK if row["scene"] == "bench" else ()), "--trials", 40,
                                         "--json").stdout)
            self.assertEqual(alone["time_s"]["median"], row["after"]["time_s"])
        with open(out) as file:
            self.assertEqual(json.load(file)["trained_on"]["scenes"], ["bench", "sticky", "tight"])
        self.refused(3, *WORDS, "--also", "stiky", "--out", out, says=["stiky", "sticky"])

    def test_what_cannot_be_improved(self):
        out = self.path("better.json")
        self.refused(2, *WORDS, "--out", out, "--objective", "beauty", says=["--objective"])
        self.refused(2, *WORDS[:-6], "--trials", 1000, "--trials-each", 100, "--out", out,
                     says=["--trials = 1000: must be at least"])
        self.refused(3, "improve", "no.json", "--out", out, says=["no.json"])
        self.refused(3, *WORDS, "--out", "/nowhere/better.json", says=["/nowhere"])
        self.assertFalse(os.path.exists(out))

    def test_ctrl_c_keeps_the_best(self):
        out = self.path("better.json")
        run = subprocess.Popen([PROGRAM, *map(str, WORDS[:-4]), "--trials", "1000000", "--out", out],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env=dict(os.environ, FERRULE_PROGRESS="lines"))
        for line in run.stderr:
            if line.startswith("progress ") and not line.startswith("progress 0 "):
                break
        run.send_signal(signal.SIGTERM)
        text, _ = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130, text)
        with open(out) as file:
            self.assertTrue(json.load(file)["trained_on"]["partial"])


if __name__ == "__main__":
    main()

import glob
import json
import os

import h5py
import numpy

from case import QUICK, Case, main


class Score(Case):
    def test_a_session_is_scored_listed_and_drawn(self):
        out = self.path("out")
        self.record(out, "--skill", 0.9, episodes=3)
        self.record(out, "--skill", 0.2, "--append", "--set", "limits.force_uN=0.5", episodes=2)
        scored = json.loads(self.done("score", out, "--json").stdout)
        result = scored["episodes"]
        self.assertEqual([e["file"] for e in result], sorted(glob.glob(out + "/*.h5")))
        self.assertEqual([e["outcome"] == "inserted" for e in result], [True] * 3 + [False] * 2)
        self.assertEqual([e["group"] for e in result], [1] * 3 + [2] * 2)
        self.assertEqual([e["score"] is None for e in result], [False] * 3 + [True] * 2)
        yardstick = scored["groups"][0]["yardstick"]
        self.assertIsNone(scored["groups"][1]["yardstick"])
        for e in result:
            if e["score"] is not None:
                mean = sum(e["parts"].values()) / len(e["parts"])
                self.assertAlmostEqual(e["score"], 100 * mean, delta=1e-9)
                part = min(1, yardstick["time_s"] / e["time_s"])
                self.assertAlmostEqual(e["parts"]["time"], part, delta=1e-12)
            with h5py.File(e["file"]) as f:
                demo = f["data/demo_0"]
                force = demo["rows/holder_wrench"][:, :3] - demo["rows/forces"][:, 6:9]
                peak = numpy.linalg.norm(force, axis=1).max() * 1e6
                self.assertAlmostEqual(e["peak_force_uN"] / peak, 1, delta=1e-9)
                names = [name.decode() for name in demo["states"].attrs["columns"]]
                touches = sum(demo["states"][:, names.index(place + "_closed")] for place in ("end", "side")) > 0
                self.assertAlmostEqual(e["contact_time_s"], touches.sum() * 1e-3, delta=1e-9)
        plot = self.path("curve.svg")
        table = self.done("score", out, "--plot", plot).stdout
        for part in ("simulated, skill 0.9, scene paper: 3 episodes",
                     "simulated, skill 0.2, scene paper: 2 episodes"):
            self.assertIn(part, table)
        self.assertIn("</svg>", open(plot).read())

    def test_persons_and_scenes_are_not_mixed(self):
        out = self.path("out")
        self.record(out, "--skill", 0.9, episodes=2)
        alone = json.loads(self.done("score", out, "--json").stdout)["episodes"]
        self.record(out, "--skill", 0.5, "--append", episodes=2)
        self.record(out, "--skill", 0.9, "--append", "--set", "start.lateral_sd_um=1", episodes=2)
        mixed = json.loads(self.done("score", out, "--json").stdout)
        self.assertEqual([e["score"] for e in mixed["episodes"][:2]], [e["score"] for e in alone])
        self.assertEqual([g["episodes"] for g in mixed["groups"]], [2, 2, 2])
        # The scene that parts were drawn in is one scene.
        drawn = self.path("drawn")
        self.record(drawn, "--set", "fibre.diameter_um=125+-0.3", episodes=3)
        self.assertEqual(len(json.loads(self.done("score", drawn, "--json").stdout)["groups"]), 1)

    def test_folders_of_several_persons_compare_in_one_scene_alone(self):
        ada, ben, other = self.path("ada"), self.path("ben"), self.path("other")
        for seed, folder in enumerate((ada, ben)):
            self.done("record", "--scene", "demo", *QUICK, "--device", "fake:spacemouse", "--episodes", 1, "--seed", seed,
                      "--trainee", os.path.basename(folder), "--out", folder)
        both = json.loads(self.done("score", ada, ben, "--json").stdout)
        self.assertEqual([g["operator"] for g in both["groups"]], ["ada", "ben"])
        self.assertEqual([s["episodes"] for s in both["sittings"]], [1, 1])
        for e in both["episodes"]:
            self.assertRegex(e["date"], r"^20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
            self.assertLessEqual(e["session"], e["date"])
        table = self.done("score", ada, ben).stdout
        self.assertRegex(table, "who +session")
        # The name that --trainee had before.
        self.done("record", "--scene", "demo", *QUICK, "--device", "fake:spacemouse", "--episodes", 1,
                  "--person", "ada", "--append", "--out", ada)
        again = json.loads(self.done("score", ada, "--json").stdout)
        self.assertEqual([g["operator"] for g in again["groups"]], ["ada"])
        self.assertEqual(len(again["sittings"]), 2)
        self.done("replay", ada, "--verify")
        self.record(other, episodes=1)
        self.refused(2, "score", ada, other, says=["another scene", "demo", "paper"])

    # What an insertion took, until the success depth, is the same number in every verb.
    def test_one_time_for_one_episode(self):
        out = self.path("out")
        told = json.loads(self.done("record", "--scene", "demo", "--episodes", 1, "--out", out,
                                    "--json").stdout)["episodes"][0]
        scored = json.loads(self.done("score", out, "--json").stdout)["episodes"][0]
        replayed = json.loads(self.done("replay", told["file"], "--json").stdout)
        self.assertEqual(told["time_s"], scored["time_s"])
        self.assertEqual(told["time_s"], replayed["time_s"])
        self.assertEqual(told["recorded_s"], replayed["recorded_s"])
        self.assertLess(told["time_s"], told["recorded_s"])

    def test_what_cannot_be_scored(self):
        out = self.path("out")
        self.refused(3, "score", out, says=["out"])
        os.mkdir(out)
        self.refused(2, "score", out, says=["no episodes"])
        files = self.record(out, "--set", "limits.force_uN=0.2", episodes=1)
        result = json.loads(self.done("score", out, "--json").stdout)["episodes"]
        self.assertIsNone(result[0]["score"])
        self.assertIn("no score", self.done("score", out).stdout)
        self.refused(2, "score", out, "--plot", self.path("none.svg"), says=["no score to draw"])
        with open(files[0], "r+b") as f:
            f.truncate(os.path.getsize(files[0]) // 2)
        self.refused(3, "score", out, says=["episode_0001.h5"])


if __name__ == "__main__":
    main()

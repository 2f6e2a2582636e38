import glob
import json
import os

import h5py
import numpy

from case import Case, main


class Score(Case):
    def test_a_session_is_scored_listed_and_drawn(self):
        out = self.path("out")
        self.record(out, "--skill", 0.9, episodes=3)
        self.record(out, "--skill", 0.2, "--append", "--set", "limits.force_uN=0.5", episodes=2)
        result = json.loads(self.done("score", out, "--json").stdout)["episodes"]
        self.assertEqual([e["file"] for e in result], sorted(glob.glob(out + "/*.h5")))
        self.assertEqual([e["outcome"] == "inserted" for e in result], [True] * 3 + [False] * 2)
        for part in result[0]["parts"]:
            self.assertEqual(max(e["parts"][part] for e in result[:3]), 1)
        for e in result:
            mean = sum(e["parts"].values()) / len(e["parts"])
            factor = 1 if e["outcome"] == "inserted" else 0.5 * e["completion"]
            self.assertAlmostEqual(e["score"], 100 * mean * factor, delta=1e-9)
            with h5py.File(e["file"]) as f:
                demo = f["data/demo_0"]
                force = demo["rows/holder_wrench"][:, :3] - demo["rows/forces"][:, 6:9]
                peak = numpy.linalg.norm(force, axis=1).max() * 1e6
                self.assertAlmostEqual(e["peak_force_uN"] / peak, 1, delta=1e-9)
                touches = (demo["states"][:, 13] + demo["states"][:, 19]) > 0
                self.assertAlmostEqual(e["contact_time_s"], touches.sum() * 1e-3, delta=1e-9)
        plot = self.path("curve.svg")
        table = self.done("score", out, "--plot", plot).stdout
        self.assertEqual(table.count("\n"), 6)
        self.assertIn("</svg>", open(plot).read())

    def test_what_cannot_be_scored(self):
        out = self.path("out")
        self.refused(3, "score", out, says=["out"])
        os.mkdir(out)
        self.refused(2, "score", out, says=["no episodes"])
        files = self.record(out, "--set", "limits.force_uN=0.2", episodes=1)
        result = json.loads(self.done("score", out, "--json").stdout)["episodes"]
        self.assertIsNone(result[0]["score"])
        self.assertIn("no episode succeeded", self.done("score", out).stdout)
        self.refused(2, "score", out, "--plot", self.path("none.svg"), says=["no episode succeeded"])
        with open(files[0], "r+b") as f:
            f.truncate(os.path.getsize(files[0]) // 2)
        self.refused(3, "score", out, says=["episode_0001.h5"])


if __name__ == "__main__":
    main()

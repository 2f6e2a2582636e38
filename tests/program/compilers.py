import glob
import json
import os
import subprocess

from case import PROGRAM, QUICK, SOURCE, Case, main

OTHER = os.environ["FERRULE_OTHER"]  # the program as another compiler makes it
SCENES = sorted(os.path.basename(file)[:-5] for file in glob.glob(SOURCE + "/data/scenes/*.json") if "schema" not in file)


class Compilers(Case):
    """The same bits from whatever compiler."""

    def by(self, program, *arguments):
        run = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=600)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stdout

    def test_they_are_of_two_compilers(self):
        self.assertNotEqual(*(self.by(program, "--version") for program in (PROGRAM, OTHER)))

    def test_recordings_of_every_scene_replay(self):
        for scene in SCENES:
            self.by(OTHER, "record", "--scene", scene, *QUICK, "--episodes", 1, "--skill", 0.4, "--out", self.path(scene))
            self.by(PROGRAM, "replay", self.path(scene) + "/episode_0001.h5", "--verify")

    def test_trials(self):
        for controller, scenes in (("tuned_by_hand", SCENES), ("search", ["bench", "ladder/b", "ladder/f"])):
            for scene in scenes:
                ours, theirs = (json.loads(self.by(program, "evaluate", controller, "--scene", scene, "--other-scaling",
                                                   "--trials", 10, "--supervise", "--baseline", "spiral", "--json"))
                                for program in (PROGRAM, OTHER))
                for found in (ours, theirs):
                    del found["provenance"]
                self.assertEqual(ours, theirs, (controller, scene))


if __name__ == "__main__":
    main()

import json
import random
import shutil

import h5py
import numpy

from case import Case, ferrule, main


class Replay(Case):
    def test_a_changed_number_is_reported_at_its_row(self):
        file = self.record(self.path("out"), episodes=1)[0]
        self.done("replay", file)
        self.assertTrue(json.loads(self.done("replay", file, "--verify", "--json").stdout)["identical"])
        with h5py.File(file) as f:
            names, labels = [], []  # of numbers, of the names of columns
            f["data/demo_0"].visititems(
                lambda name, item: (labels if item.dtype.kind == "S" else names).append(name)
                if isinstance(item, h5py.Dataset) else None)
        self.assertGreater(len(names), 14)
        self.assertGreater(len(labels), 3)
        for name in labels:
            changed = self.path("changed.h5")
            shutil.copy(file, changed)
            with h5py.File(changed, "r+") as f:
                f["data/demo_0/" + name][-1] = b"X"
            run = ferrule("replay", changed, "--verify", "--json")
            self.assertEqual(run.returncode, 1, (name, run.stderr))
            self.assertIn(name, json.loads(run.stdout)["difference"]["column"])
        for name in names:
            for row in (0, 321, -1):
                changed = self.path("changed.h5")
                shutil.copy(file, changed)
                with h5py.File(changed, "r+") as f:
                    data = f["data/demo_0/" + name]
                    value = data[row]
                    flat = numpy.atleast_1d(value).copy()
                    if flat.dtype.kind == "f":
                        flat[-1] = numpy.nextafter(flat[-1], flat.dtype.type(1e9))
                    else:
                        flat[-1] += 1
                    data[row] = flat.reshape(numpy.shape(value))
                    expected = row % data.shape[0]
                run = ferrule("replay", changed, "--verify", "--json")
                self.assertEqual(run.returncode, 1, (name, row, run.stderr))
                found = json.loads(run.stdout)["difference"]["row"]
                self.assertLessEqual(abs(found - expected), 1, (name, row))

    def test_flipped_bytes_are_never_taken_for_a_whole_file(self):
        file = self.record(self.path("out"), episodes=1)[0]
        whole = open(file, "rb").read()
        with h5py.File(file) as f:
            data = f["data/demo_0/states"]
            chunk = data.id.get_chunk_info(1)
            states = data[:]

        def says_the_same(name):  # the last byte of a deflate stream may have bits without meaning
            with h5py.File(name) as f:
                try:
                    return numpy.array_equal(f["data/demo_0/states"][:], states)
                except OSError:
                    return False
        draw = random.Random(1)
        for _ in range(25):
            changed = bytearray(whole)
            at = chunk.byte_offset + draw.randrange(chunk.size)
            changed[at] ^= 1 << draw.randrange(8)
            with open(self.path("flipped.h5"), "wb") as out:
                out.write(changed)
            run = ferrule("replay", self.path("flipped.h5"), "--verify")
            if not says_the_same(self.path("flipped.h5")):
                self.assertIn(run.returncode, (1, 3), at)
        for _ in range(60):  # anywhere: no crash, no hang
            changed = bytearray(whole)
            for _ in range(20):
                changed[draw.randrange(len(changed))] ^= 1 << draw.randrange(8)
            with open(self.path("flipped.h5"), "wb") as out:
                out.write(changed)
            run = ferrule("replay", self.path("flipped.h5"), "--verify")
            self.assertIn(run.returncode, (0, 1, 2, 3), run.stderr)

    def test_a_trace_says_why_a_step_took_its_evaluations(self):
        self.done("record", "--scene", "bench", "--episodes", 1, "--seed", 5, "--out", self.path("e"))
        file = self.path("e/episode_0001.h5")
        step = json.loads(self.done("replay", file, "--trace", "costliest", "--json").stdout)["trace"]
        ends = [s for s in step["stages"] if s["stage"] in ("accepted", "rejected")]
        self.assertEqual(sum(s["evaluations"] for s in ends), step["evaluations"])
        self.assertEqual(sum(s["stage"] == "rejected" for s in ends), step["rejected"])
        self.assertGreater(step["evaluations"], 5)
        text = self.done("replay", file, "--trace", step["to_s"]).stdout
        self.assertIn(f"{step['evaluations']} evaluations", text)
        for stage in step["stages"]:
            self.assertIn(stage["decision"], text)
        first = json.loads(self.done("replay", file, "--trace", 0, "--json").stdout)["trace"]
        self.assertEqual([s["stage"] for s in first["stages"]], ["free flight"])
        for bad in ("-1", "1e9", "nan", "worst"):
            self.refused(2, "replay", file, "--trace", bad, says=["--trace"])
        self.refused(2, "replay", self.path("e"), "--trace", 1, says=["--trace", "folder"])

    def test_not_an_episode(self):
        with open(self.path("x.h5"), "w") as out:
            out.write("hello")
        self.refused(3, "replay", self.path("x.h5"), says=["x.h5"])
        with h5py.File(self.path("y.h5"), "w") as f:
            f["a"] = 1
        self.refused(3, "replay", self.path("y.h5"), says=["not a ferrule episode"])
        self.refused(3, "replay", self.path("z.h5"), says=["z.h5"])


if __name__ == "__main__":
    main()

import copy
import csv
import glob
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time

import h5py
import numpy

from case import PROGRAM, QUICK, Case, ferrule, main


class Policies(Case):
    """Slow; only in the release build."""

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.mkdtemp(prefix="ferrule-test-")
        cls.addClassCleanup(shutil.rmtree, cls.shared, ignore_errors=True)
        cls.episodes, cls.law = cls.shared + "/episodes", cls.shared + "/law.json"
        cls.file = cls.shared + "/c.json"
        run = ferrule("record", "--scene", "demo", "--skill", 0.8, "--episodes", 20, "--out",
                      cls.episodes)
        assert run.returncode == 0, run.stderr
        run = ferrule("fit", cls.episodes, "--law", "auto", "--out", cls.law)
        assert run.returncode == 0, run.stderr
        run = ferrule("fit", cls.episodes, "--method", "torch", "--ensemble", 2, "--out", cls.file,
                      "--plot", cls.shared + "/training.svg")
        cls.torch = run.returncode == 0
        cls.gru = cls.shared + "/gru.json"
        if cls.torch:
            short = cls.shared + "/short"  # of the last micrometres: it is trained in a few seconds
            run = ferrule("record", "--scene", "demo", *QUICK, "--skill", 0.8, "--episodes", 5, "--out", short)
            assert run.returncode == 0, run.stderr
            run = ferrule("fit", short, "--method", "torch", "--network", "gru", "--out", cls.gru)
            assert run.returncode == 0, run.stderr
        else:
            assert run.returncode == 2 and "libtorch-dev" in run.stderr, run.stderr

    def needs_torch(self):
        if not self.torch:
            self.skipTest("built without libtorch")

    # Five of the episodes, for what need not be good.
    def few(self):
        folder = self.path("few")
        os.mkdir(folder)
        for file in sorted(glob.glob(self.episodes + "/*.h5"))[:5]:
            shutil.copy(file, folder)
        return folder

    # The law, but it yields otherwise in the bore and tilts under moments.
    def guarded(self):
        law = json.load(open(self.law))
        self.assertEqual(law["law"], "insertion")
        law["law"] = "guarded"
        for gain, value, unit in (("bore_yield_y", 2e-4, "m/(s N)"), ("bore_yield_z", 1.5e-3, "m/(s N)"),
                                  ("tilt_yield_y", 2e-4, "rad/(s N m)"), ("tilt_yield_z", 1e-4, "rad/(s N m)")):
            law["gains"][gain] = {"value": value, "unit": unit, "low": None, "high": None}
        with open(self.path("guarded.json"), "w") as file:
            json.dump(law, file)
        return file.name

    def weights(self, file):
        return os.path.join(os.path.dirname(file), json.load(open(file))["weights"])

    # An independent reader of both files.
    def read(self, file):
        controller = json.load(open(file))
        data = open(self.weights(file), "rb").read()
        self.assertEqual(hashlib.sha1(data).hexdigest(), controller["weights_sha1"])
        length = int.from_bytes(data[:8], "little")
        header = json.loads(data[8:8 + length])
        arrays = {}
        for name, entry in header.items():
            if name != "__metadata__":
                self.assertEqual(entry["dtype"], "F32")
                first, last = entry["data_offsets"]
                arrays[name] = numpy.frombuffer(data[8 + length + first:8 + length + last],
                                                "<f4").reshape(entry["shape"]).astype(float)
        return controller, arrays

    # Channels of a policy's inputs: those of the wrench at every sample of the past, the others once.
    def channels(self, controller):
        wrench = [c for c in controller["inputs"] if c["name"].startswith(("force", "moment"))]
        others = [c for c in controller["inputs"] if c not in wrench]
        return wrench, others

    # Inputs of the policy at every row of an episode.
    def inputs(self, controller, wrench, depth, time):
        values = dict(zip(("force_x", "force_y", "force_z", "moment_y", "moment_z"), wrench.T),
                      depth=depth, time=time)
        past, others = self.channels(controller)
        felt = numpy.column_stack([values[c["name"]] for c in past])
        columns = []
        for k in range(controller["history"]["samples"]):
            late = numpy.zeros_like(felt)
            shift = k * controller["history"]["spacing_periods"]
            late[shift:] = felt[:len(felt) - shift]
            columns.append(late)
        return numpy.column_stack(columns + [values[c["name"]] for c in others])

    def answer(self, controller, arrays, inputs):
        past, others = self.channels(controller)
        scales = past * controller["history"]["samples"] + others
        z = (inputs - [c["mean"] for c in scales]) / [c["scale"] for c in scales]
        mean = 0
        for m in range(controller["ensemble"]):
            h = z
            for i in range(len(controller["hidden"]) + 1):
                name = f"members.{m}.layers.{i}."
                h = h @ arrays[name + "weight"].T + arrays[name + "bias"]
                h = numpy.tanh(h) if i < len(controller["hidden"]) else h
            mean = mean + h[:, :3] / controller["ensemble"]
        out = controller["outputs"]
        velocity = mean * [c["scale"] for c in out] + [c["mean"] for c in out]
        speed = numpy.linalg.norm(velocity, axis=1, keepdims=True)
        return velocity * numpy.minimum(1, controller["limits"]["speed_m_s"] / speed)

    # The same of one that remembers, at every answer, from the equations in controller/gru.hpp.
    def answers_from_memory(self, controller, arrays, inputs):
        def sigmoid(x):
            return 1 / (1 + numpy.exp(-x))
        scales, units, answers = controller["inputs"], controller["memory"], []
        arrays = {name[len("members.0."):]: array for name, array in arrays.items()}
        h = numpy.zeros(units)
        for x in inputs:
            z = (x - [c["mean"] for c in scales]) / [c["scale"] for c in scales]
            a = arrays["memory.input_weight"] @ z + arrays["memory.input_bias"]
            c = arrays["memory.memory_weight"] @ h + arrays["memory.memory_bias"]
            (a_r, a_u, a_n), (c_r, c_u, c_n) = a.reshape(3, units), c.reshape(3, units)
            u = sigmoid(a_u + c_u)
            h = (1 - u) * numpy.tanh(a_n + sigmoid(a_r + c_r) * c_n) + u * h
            y = arrays["layers.1.weight"] @ numpy.tanh(arrays["layers.0.weight"] @ h + arrays["layers.0.bias"])
            y = (y + arrays["layers.1.bias"])[:len(controller["outputs"])]
            velocity = y * [c["scale"] for c in controller["outputs"]] + [c["mean"] for c in controller["outputs"]]
            speed = numpy.linalg.norm(velocity[:3])
            velocity[:3] *= min(1, controller["limits"]["speed_m_s"] / speed)
            answers.append(velocity[:3])
        return numpy.array(answers)

    # What the controller of `file` observed and did: wrench at the hand, depth, time, velocity; with
    # `motion` also displacement and height before that.
    def recorded(self, file, motion=False):
        out = self.path("by " + os.path.basename(file))
        self.done("record", "--operator", file, "--scene", "demo", "--episodes", 1, "--seed", 5,
                  "--set", "limits.speed_um_s=1000", "--out", out)
        with h5py.File(out + "/episode_0001.h5") as f:
            demo = f["data/demo_0"]
            x, force = f.attrs["alpha_x"], f.attrs["alpha_f"]
            wrench = demo["rows/holder_wrench"][:] * [force] * [1, 1, 1, x, x]
            pose = demo["rows/hand_pose"][:]
            own = (pose - pose[0], pose[:, 0]) if motion else ()
            return (wrench - wrench[0], numpy.maximum(0, -pose[:, 0]), demo["rows/time"][:].ravel(), *own,
                    demo["rows/command"][:])

    # Of a policy that does not tilt `a` has no rates of tilt.
    def close(self, a, b, tolerance=1e-6):
        self.assertGreater(len(a), 1000)
        self.assertFalse(b[:, a.shape[1]:].any())
        b = b[:, :a.shape[1]]
        scale = numpy.abs(b).max(axis=0)
        scale[scale == 0] = 1
        self.assertLessEqual((numpy.abs(a - b) / scale).max(), tolerance)

    def test_a_fitted_policy_inserts_far_more_often_than_constant_velocity(self):
        self.needs_torch()
        result = json.loads(self.done("evaluate", self.file, "--scene", "demo", "--trials", 25,
                                      "--baseline", "constant-velocity", "--json").stdout)
        self.assertGreater(result["baseline"]["difference_low"], 0.1)
        self.assertLess(result["baseline"]["mcnemar_p"], 1e-2)

    def test_files_are_of_the_schema_and_say_what_they_were_trained_on(self):
        validator = self.schema_validator("controller.schema.json")
        for file in (self.law, self.file) if self.torch else (self.law,):
            controller = json.load(open(file))
            validator.validate(controller)
            told = controller["trained_on"]
            self.assertEqual(len(told["episodes"]) + len(told["held_out"]), 20)
            for episode in told["episodes"] + told["held_out"]:
                data = open(episode["file"], "rb").read()
                self.assertEqual(hashlib.sha1(data).hexdigest(), episode["sha1"])
        self.needs_torch()
        self.assertIn("</svg>", open(self.shared + "/training.svg").read())

    def test_schema_and_program_agree_on_broken_controllers(self):
        laws = (self.law, self.guarded())
        for file in (*laws, self.file, self.gru) if self.torch else laws:
            self.broken(file, self.schema_validator("controller.schema.json"))

    def broken(self, controller, validator):
        good, paths, draw = json.load(open(controller)), [], random.Random(2)

        def walk(node, path):
            for key in node if isinstance(node, dict) else range(len(node)):
                paths.append(path + [key])
                if isinstance(node[key], (dict, list)):
                    walk(node[key], path + [key])

        walk(good, [])
        file, refused = self.path("broken.json"), 0
        if "weights" in good:
            shutil.copy(self.weights(controller), self.folder)
        for _ in range(60):
            bad, path = copy.deepcopy(good), draw.choice(paths)
            # What no schema can say: what belongs to the weights.
            if path[0] in ("weights", "weights_sha1", "ensemble", "hidden", "memory") or path[-1] == "samples":
                continue
            place = bad
            for key in path[:-1]:
                place = place[key]
            if draw.randrange(3) == 0:
                del place[path[-1]]
            else:
                place[path[-1]] = draw.choice([-1, 0, "text", None, [], {}, True, 1e300, 0.3, 7])
            json.dump(bad, open(file, "w"))
            run = ferrule("export", file, "--header", self.path("x.h"))
            self.assertIn(run.returncode, (0, 2), run.stderr)
            if path[:2] != ["trained_on", "scene"] or run.returncode == 0:  # its numbers must fit too
                self.assertEqual(run.returncode == 0, validator.is_valid(bad), (path, run.stderr))
            self.assertEqual(run.stderr.count("\n"), run.returncode != 0, run.stderr)
            refused += run.returncode != 0
        self.assertGreater(refused, 20)

    def test_the_same_command_gives_the_same_bytes(self):
        self.needs_torch()
        few, texts = self.few(), []
        for _ in range(2):
            self.done("fit", few, "--method", "torch", "--ensemble", 2, "--out", self.path("c.json"))
            texts.append([open(name, "rb").read()
                          for name in (self.path("c.json"), self.weights(self.path("c.json")))])
            self.assertEqual(len(glob.glob(self.path("c.*"))), 2)
        self.assertEqual(*texts)

    def test_a_name_without_folder_or_ending_keeps_its_weights(self):
        self.needs_torch()
        few, here = self.few(), {"cwd": self.folder}
        self.done("fit", few, "--method", "torch", "--ensemble", 1, "--out", "policy", **here)
        self.done("fit", few, "--method", "torch", "--ensemble", 1, "--out", "policy", **here)
        self.assertTrue(os.path.exists(self.weights(self.path("policy"))))

    def test_the_weights_give_the_same_answers_to_another_reader(self):
        self.needs_torch()
        controller, arrays = self.read(self.file)
        *observed, velocity = self.recorded(self.file)
        self.close(self.answer(controller, arrays, self.inputs(controller, *observed)), velocity)

    # Every 20 ms, and in between it goes on.
    def test_one_that_remembers_gives_the_same_answers_to_another_reader(self):
        self.needs_torch()
        controller, arrays = self.read(self.gru)
        self.schema_validator("controller.schema.json").validate(controller)
        wrench, _, _, displacement, height, velocity = self.recorded(self.gru, motion=True)
        every = controller["history"]["spacing_periods"]
        self.assertEqual(every, 20)
        answers = self.answers_from_memory(
            controller, arrays, numpy.column_stack([wrench, displacement, height])[::every])
        self.close(numpy.repeat(answers, every, axis=0)[:len(velocity)], velocity, 1e-5)

    def test_torchscript_of_one_that_remembers_answers_alike_in_python(self):
        self.needs_torch()
        try:
            import torch
        except ImportError:
            self.skipTest("no torch for Python")
        script = self.path("g.pt")
        self.done("export", self.gru, "--torchscript", script)
        wrench, _, _, displacement, height, velocity = self.recorded(self.gru, motion=True)
        inputs = torch.from_numpy(numpy.column_stack([wrench, displacement, height])[::20].copy())
        module, memory, answers = torch.jit.load(script), torch.zeros(1, 1, 64), []
        for row in inputs:
            answer, deviation, disagreement, memory = module(row.unsqueeze(0), memory)
            answers.append(answer[0, :3].numpy())
        self.close(numpy.repeat(answers, 20, axis=0)[:len(velocity)], velocity, 1e-5)

    def test_torchscript_answers_alike_in_python(self):
        self.needs_torch()
        try:
            import torch
        except ImportError:
            self.skipTest("no torch for Python")
        script = self.path("c.pt")
        self.done("export", self.file, "--torchscript", script)
        *observed, velocity = self.recorded(self.file)
        controller, _ = self.read(self.file)
        inputs = torch.from_numpy(self.inputs(controller, *observed))
        answer, deviation, disagreement = torch.jit.load(script)(inputs)
        self.close(answer.numpy(), velocity)
        self.assertTrue((deviation.numpy() > 0).all() and (disagreement.numpy() >= 0).all())
        self.refused(2, "export", self.law, "--torchscript", script, says=["law.json", "network"])
        # Two outputs are written both or none.
        folder = self.path("both")
        os.makedirs(folder + "/taken.h")
        for header in (folder + "/taken.h", folder + "/none/x.h"):
            self.refused(3, "export", self.file, "--torchscript", folder + "/x.pt", "--header", header)
            self.assertEqual(os.listdir(folder), ["taken.h"])

    # Feeds the header's controller what the recorded one observed.
    def by_header(self, file, motion=False, tolerance=1e-6):
        header, source, program = self.path("c.h"), self.path("c.c"), self.path("c")
        self.done("export", file, "--header", header)
        with open(source, "w") as out:
            out.write('''#include "c.h"
#include <stdio.h>
int main(void) {
  ferrule_state s;
  double x[13], v[5];
  ferrule_start(&s);
  for (;;) {
    int i;
    for (i = 0; i < COUNT; ++i)
      if (scanf("%lf", x + i) != 1) return 0;
    ferrule_command(&s, x, x[5], x[6],MOTION v);
    printf("%.17g %.17g %.17g %.17g %.17g\\n", v[0], v[1], v[2], v[3], v[4]);
  }
}
'''.replace("COUNT", "13" if motion else "7").replace("MOTION", " x + 7, x[12]," if motion else ""))
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", source,
                        "-o", program, "-lm"], check=True)
        *observed, velocity = self.recorded(file, motion)
        rows = "\n".join(" ".join(f"{x:.17g}" for x in row)
                         for row in numpy.column_stack(observed))
        run = subprocess.run([program], input=rows, capture_output=True, text=True, check=True)
        self.close(numpy.array([line.split() for line in run.stdout.splitlines()], float), velocity,
                   tolerance)

    def test_the_header_of_a_law_answers_alike(self):
        self.by_header(self.law)
        self.by_header(self.guarded())

    def test_the_header_of_a_policy_answers_alike(self):
        self.needs_torch()
        # In single precision, with another hyperbolic tangent.
        self.by_header(self.file, tolerance=1e-5)
        self.by_header(self.gru, motion=True, tolerance=1e-5)

    # The search has thresholds: only the same bits go the same way to the end.
    def test_the_header_of_a_search_inserts_bit_for_bit_as_the_search(self):
        source, program = self.path("s.c"), self.path("s")
        self.done("export", "search", "--header", self.path("s.h"))
        with open(source, "w") as out:
            out.write('''#include "s.h"
#include <stdio.h>
#include <stdlib.h>
static void read(const char* line, const char* key, int count, double* x) {
  char* at = strchr(strstr(line, key) + strlen(key), ':') + 1;
  for (int i = 0; i < count; ++i) {
    at += strspn(at, " [,");
    x[i] = strtod(at, &at);
  }
}
int main(void) {
  ferrule_state s;
  char line[4096];
  while (fgets(line, sizeof line, stdin)) {
    double wrench[5], depth, time, displacement[5], height, v[5];
    if (strstr(line, "reset")) {
      ferrule_start(&s);
      puts("{}");
    } else {
      read(line, "wrench", 5, wrench);
      read(line, "depth", 1, &depth);
      read(line, "time", 1, &time);
      read(line, "displacement", 5, displacement);
      read(line, "height", 1, &height);
      ferrule_command(&s, wrench, depth, time, displacement, height, v);
      printf("{\\"velocity\\": [%.17g, %.17g, %.17g, %.17g, %.17g]}\\n", v[0], v[1], v[2], v[3], v[4]);
    }
    fflush(stdout);
  }
  return 0;
}
''')
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow",
                        "-Werror", "-O1", source, "-o", program, "-lm"], check=True)
        # Bench touches its cone; d the front face; b has late hands, e a start beside the cone.
        for scene in ("bench", "ladder/d", "ladder/b", "ladder/e"):
            tables = []
            for name, controller in (("own", ["search"]), ("exported", ["--policy", program])):
                out = self.path(name + ".csv")
                self.done("evaluate", *controller, "--scene", scene, "--trials", 4, "--trials-out", out)
                with open(out) as file:
                    tables.append([{key: row[key] for key in ("trial", "outcome", "time_s", "depth_um",
                                                              "peak_force_uN", "tilt_mrad")}
                                   for row in csv.DictReader(file)])
            self.assertEqual(len(tables[0]), 4)
            self.assertEqual(*tables)

    def test_rounds_of_dagger(self):
        self.needs_torch()
        out = self.path("d.json")
        few = self.few()
        self.done("fit", few, "--method", "torch", "--out", out)
        before = json.load(open(out))["trained_on"]["rows"]
        self.done("fit", few, "--method", "torch", "--dagger", 1, "--out", out)
        controller, _ = self.read(out)
        [told] = controller["metrics"]["dagger"]
        self.assertEqual(told["trials"], 10)
        self.assertGreater(told["rows"], 1000)
        self.assertEqual(controller["trained_on"]["rows"], before + told["rows"])
        self.assertEqual(controller["trained_on"]["rollouts"], 10)

    # Nobody asks a person, nor a controller, what he would have done.
    def test_dagger_needs_a_simulated_teacher(self):
        self.needs_torch()
        by_law = self.path("by_law")
        self.done("record", "--operator", self.law, "--episodes", 4, "--out", by_law)
        self.refused(2, "fit", by_law, "--method", "torch", "--dagger", 1, "--out",
                     self.path("x.json"), says=["--dagger", "controller"])

    def test_a_fit_that_is_stopped_leaves_what_it_has(self):
        self.needs_torch()
        out = self.path("p.json")
        process = subprocess.Popen([PROGRAM, "fit", self.episodes, "--method", "torch", "--ensemble",
                                    "20", "--out", out], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(6)
        process.send_signal(signal.SIGINT)
        told, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)
        self.assertFalse(os.path.exists(out))
        if "PARTIAL" in told:  # else it was still reading
            part = json.load(open(self.path("p.partial.json")))
            self.assertTrue(part["trained_on"]["partial"])
            self.assertIn("whose fit was stopped",
                          self.done("evaluate", self.path("p.partial.json"), "--trials", 1).stdout)

    def test_refusals(self):
        self.refused(2, "fit", self.episodes, "--ensemble", 2, "--out", self.path("x.json"),
                     says=["--ensemble", "--method torch"])
        self.refused(2, "export", self.law, says=["--torchscript", "--header"])
        self.refused(3, "export", self.path("none.json"), "--header", self.path("x.h"),
                     says=["none.json"])
        self.assertFalse(os.path.exists(self.path("x.h")))
        self.needs_torch()
        self.refused(2, "fit", self.episodes, "--method", "torch", "--out", self.path("x.safetensors"),
                     says=[".safetensors"])
        weights = os.path.basename(self.weights(self.file))
        good = open(self.weights(self.file), "rb").read()
        shutil.copy(self.file, self.folder)
        for bad in (b"", good[:7], good[:100], good[:-4], good + b"0000", b"\xff" * 8 + good[8:],
                    good[:-4] + b"\x00\x00\xc0\x7f", good[:-1] + bytes([good[-1] ^ 1])):
            with open(self.path(weights), "wb") as out:
                out.write(bad)
            self.refused(2, "evaluate", self.path("c.json"), says=[weights])


if __name__ == "__main__":
    main()

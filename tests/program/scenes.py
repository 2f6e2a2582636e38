import copy
import glob
import json
import os
import random
import re
import shutil

import h5py

from case import SOURCE, Case, ferrule, main


class Scenes(Case):
    def test_json_nested_without_end_is_refused(self):
        file = self.path("deep.json")
        with open(file, "w") as f:
            f.write("[" * 100000 + "]" * 100000)
        self.refused(2, "plan", "--scene", file, says=("nested deeper",))

    def test_an_accuracy_that_is_not_reached_is_said(self):
        run = self.done("record", "--scene", "paper", "--episodes", 1, "--out", self.path("slow"),
                        "--set", "accuracy=1e-6", "--set", "limits.time_s=1")
        self.assertIn("accuracy = 1e-06 is not reached", run.stderr)

    def setUp(self):
        super().setUp()
        self.validator = self.schema_validator("scenes/scene.schema.json")
        self.paper = json.load(open(SOURCE + "/data/scenes/paper.json"))

    def program_takes(self, scene):
        file = self.path("scene.json")
        with open(file, "w") as out:
            json.dump(scene, out)
        run = ferrule("forces", "--scene", file, "--json")
        self.assertIn(run.returncode, (0, 2), run.stderr)
        if run.returncode == 2:
            self.assertTrue(run.stderr.startswith("ferrule: " + file + ": "), run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        return run.returncode == 0

    def test_all_shipped_scenes_are_valid(self):
        for file in glob.glob(SOURCE + "/data/scenes/**/*.json", recursive=True):
            if not file.endswith(".schema.json"):
                self.validator.validate(json.load(open(file)))
                self.assertTrue(self.program_takes(json.load(open(file))), file)

    def test_schema_and_program_agree_on_broken_scenes(self):
        draw = random.Random(4)
        paths = []

        def walk(node, path):
            if isinstance(node, dict):
                for key in node:
                    paths.append(path + [key])
                    walk(node[key], path + [key])

        walk(self.paper, [])
        values = [-1, 0, "text", None, [], {}, True, 1e-3, 0.3, 95, [0, 0], 1e300]
        refused = 0
        for _ in range(150):
            scene = copy.deepcopy(self.paper)
            path = draw.choice(paths)
            place = scene
            for key in path[:-1]:
                place = place[key]
            how = draw.randrange(4)
            if how == 0:
                del place[path[-1]]
            elif how == 1:
                place["surprise"] = draw.choice(values)
            else:
                place[path[-1]] = draw.choice(values)
            # What no schema can say: relations between keys.
            if path[-1] in ("diameter_um", "bore_diameter_um", "depth_um", "length_mm"):
                continue
            valid = self.validator.is_valid(scene)
            self.assertEqual(self.program_takes(scene), valid, (path, how, scene))
            refused += not valid
        self.assertGreater(refused, 50)

    def test_extreme_numbers_are_refused_or_computed_with(self):
        paper = copy.deepcopy(self.paper)
        for law in paper["laws"].values():
            law["form"] = "corrected"
        flat = []

        def walk(node, path):
            for key, value in node.items():
                if isinstance(value, dict):
                    walk(value, path + [key])
                elif isinstance(value, (int, float)):
                    flat.append(path + [key])

        walk(paper, [])
        computed = 0
        for path in flat:
            for value in (1e308, -1e308, 1e-300, 0):
                scene = copy.deepcopy(paper)
                place = scene
                for key in path[:-1]:
                    place = place[key]
                place[path[-1]] = value
                file = self.path("scene.json")
                with open(file, "w") as out:
                    json.dump(scene, out)
                run = ferrule("forces", "--scene", file, "--gap-nm", 10, "--tilt-mrad", 0.1, "--json")
                if run.returncode == 0:
                    self.assertTrue(self.validator.is_valid(scene), path)
                    self.assertNotIn("null", run.stdout.replace('"depth_nm": null', ""), (path, value))
                    computed += 1
                else:
                    self.assertEqual(run.returncode, 2, run.stderr)
                    self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
                    self.assertIn(path[-1], run.stderr)
                    self.assertIn("must", run.stderr)
        self.assertGreater(len(flat), 30)
        self.assertGreater(computed, 10)

    def test_every_verb_takes_scene_and_set(self):
        for verb in ("forces", "record", "evaluate"):
            text = self.done(verb, "--help").stdout
            self.assertIn("--scene", text)
            self.assertIn("--set", text)

    def test_keys_are_found(self):
        found = json.loads(self.done("scene", "bore", "diameter", "--json").stdout)["rows"]
        self.assertEqual({r["key"]: r["value"] for r in found}["ferrule.bore_diameter_um"], 126)
        for wrong, right in (("ferrule.bore_diameter", "ferrule.bore_diameter_um"),
                             ("sensor.noise_N", "sensor.noise_uN"),
                             ("limits.speed", "limits.speed_um_s"),
                             ("lateral_sd_um", "start.lateral_sd_um")):
            self.refused(2, "forces", "--set", wrong + "=\"x\"", says=["did you mean " + right])
        for wrong, right in (("ferrule.bore_diameter_mm=0.1255", "ferrule.bore_diameter_um = 125.5"),
                             ("limits.speed_mm_s=0.02", "limits.speed_um_s = 20"),
                             ("sensor.noise_nN=500", "sensor.noise_uN = 0.5")):
            self.refused(2, "forces", "--set", wrong, says=["here it is " + right])
        self.refused(2, "scene", "surely", "nothing", says=["no key"])

    def test_a_number_may_be_drawn(self):
        run = json.loads(self.done("scene", "--set", "ferrule.bore_diameter_um=126+-0.3", "--set",
                                   "fibre.young_GPa=70..74", "--json").stdout)
        values = {row["key"]: row["value"] for row in run["rows"]}
        self.assertEqual(values["ferrule.bore_diameter_um"], {"normal": [126, 0.3 / 3]})
        self.assertEqual(values["fibre.young_GPa"], {"uniform": [70, 74]})
        for setting in ("fibre.diameter_um=125+-", "fibre.young_GPa=a+-1",
                        "ferrule.bore_diameter_um=126+--0.1", "ferrule.bore_diameter_um=wide"):
            self.refused(2, "scene", "--set", setting,
                         says=["must be a number, or drawn as 126+-0.3, 125.5+1/-0 or 125.2..126.5"])
        scene = copy.deepcopy(self.paper)
        for young, valid in (({"normal": [72, 1]}, True), ({"lognormal": [72, 0.1]}, True),
                             ({"choice": [70, 71, 72]}, True), ({"choice": []}, False),
                             ({"normal": [72]}, False), ({"uniform": [70, "72"]}, False),
                             ({"normal": [72, 1], "uniform": [70, 72]}, False)):
            scene["fibre"]["young_GPa"] = young
            self.assertEqual(self.validator.is_valid(scene), valid, young)
            self.assertEqual(self.program_takes(scene), valid, young)
        scene["fibre"]["young_GPa"] = {"normal": [1, 1]}
        self.refused_file(["forces", "--scene", "FILE"], scene,
                          "line 7: fibre.young_GPa = {\"normal\":[1,1]}: may be drawn as what it must not be")

    def test_a_scene_states_what_differs(self):
        def write(name, **scene):
            with open(self.path(name), "w") as out:
                json.dump({"name": name, **scene}, out, indent=1)
            return self.path(name)

        os.mkdir(self.path("parts"))
        base = write("parts/base.json", extends="tight", limits={"force_uN": 33},
                     laws={"adhesion": {"form": "corrected", "work_of_adhesion_J_m2": 0.05,
                                        "maugis_lambda": 2}, "electrostatic": None})
        mine = write("mine.json", extends="parts/base.json", fibre={"diameter_um": {"uniform": [124, 125]}})
        for file in (base, mine):
            self.validator.validate(json.load(open(file)))
        rows = json.loads(self.done("scene", mine, "--set", "limits.time_s=7", "--json").stdout)["rows"]
        found = {row["key"]: (row["value"], row["from"]) for row in rows}
        for key, value in (("fibre.diameter_um", ({"uniform": [124, 125]}, "mine")),
                           ("limits.force_uN", (33, "base")), ("limits.time_s", (7, "--set")),
                           ("ferrule.bore_diameter_um", (125.5, "tight")), ("fibre.young_GPa", (72, "bench")),
                           ("laws.adhesion.maugis_lambda", (2, "base")),
                           ("laws.electrostatic.voltage_V", (None, ""))):
            self.assertEqual(found[key], value, key)
        self.done("record", "--scene", mine, "--set", "success.depth_um=8", "--set", "start.distance_um=10",
                  "--episodes", 1, "--out", self.path("out"))
        shutil.rmtree(self.path("parts"))  # a recording needs none of them
        self.assertIn("identical", self.done("replay", self.path("out"), "--verify").stdout)
        self.refused(3, "scene", mine, says=["base.json"])
        write("mine.json", extends="mine.json")
        self.refused(2, "scene", self.path("mine.json"), says=["does one extend itself?"])
        write("mine.json", extends=3)
        self.refused(2, "scene", self.path("mine.json"), says=["extends = 3: must be a text"])
        write("mine.json", extends="bench", fibre={"diameter": 125})
        self.refused(2, "scene", self.path("mine.json"), says=["fibre.diameter = 125: "])
        for name in ("tight", "hard"):
            self.assertIn("bench", self.done("scene", name).stdout)

    def test_what_is_drawn_is_recorded(self):
        for bore in ("125.5+1/-0", "125.5..126.5"):
            arguments = ["--set", "ferrule.bore_diameter_um=" + bore, "--set",
                         "fibre.diameter_um=125+0/-0.4", "--set", "laws.adhesion.work_of_adhesion_J_m2="
                         '{"lognormal":[0.02,0.3]}']
            scene = self.path("drawn-" + bore.replace("/", "_"))
            self.done("record", *arguments, "--scene", "paper", "--set", "success.depth_um=8", "--set",
                      "start.distance_um=10", "--episodes", 4, "--out", scene)
            self.assertIn("identical", self.done("replay", scene, "--verify").stdout)
            drawn = []
            for episode in sorted(glob.glob(scene + "/*.h5")):
                with h5py.File(episode) as file:
                    recorded = json.loads(file.attrs["scene"])
                self.validator.validate(recorded)
                added = ["start.y_um", "start.z_um", "start.tilt_y_mrad", "start.tilt_z_mrad"]
                self.assertEqual(recorded["drawn_from"], {"added": added, "was": {
                    "ferrule.bore_diameter_um": {"uniform": [125.5, 126.5]},
                    "fibre.diameter_um": {"uniform": [124.6, 125]},
                    "laws.adhesion.work_of_adhesion_J_m2": {"lognormal": [0.02, 0.3]}}})
                drawn.append((recorded["fibre"]["diameter_um"],
                              recorded["ferrule"]["bore_diameter_um"]))
            self.assertEqual(len(set(drawn)), 4)
            for fibre, hole in drawn:
                self.assertTrue(124.6 <= fibre <= 125 and 125.5 <= hole <= 126.5, drawn)

    def test_a_tolerance_states_a_deviation_or_two_diameters(self):
        scene = copy.deepcopy(self.paper)
        bore = {"bore_diameter_um": [125.5, 126.5]}
        for fibre, valid in (({"fibre_diameter_sd_um": 0.1}, True),
                             ({"fibre_diameter_um": [124.5, 125]}, True), ({}, True),
                             ({"fibre_diameter_um": [124.5]}, False),
                             ({"fibre_diameter_um": [0, 125]}, False),
                             ({"fibre_diameter_sd_um": 0.1, "fibre_diameter_um": [124.5, 125]}, False)):
            scene["tolerance"] = {**bore, **fibre}
            self.assertEqual(self.validator.is_valid(scene), valid, fibre)
            self.assertEqual(self.program_takes(scene), valid, fibre)
        scene["tolerance"] = {**bore, "fibre_diameter_um": [125, 124.5]}
        self.assertFalse(self.program_takes(scene))

    # A file of one key a line, the first on line 2.
    def refused_file(self, verb, document, says):
        file = self.path("broken.json")
        with open(file, "w") as out:
            out.write(document if isinstance(document, str) else json.dumps(document, indent=1))
        self.refused(2, *[file if word == "FILE" else word for word in verb], says=[f"{file}: {says}"])

    def test_a_wrong_key_is_named_with_its_line_before_a_missing_one(self):
        verb = ["forces", "--scene", "FILE"]
        for old, new, says in (
                ("diameter_um", "diamter_um", "fibre.diamter_um = 125: unknown key; "
                 "did you mean fibre.diameter_um?"),
                ("bore_diameter_um", "bore_diameter_mm", "ferrule.bore_diameter_mm = 126: unknown key; "
                 "here it is ferrule.bore_diameter_um = 126000"),
                ("hamaker_J", "hamacker_J", "unknown key; did you mean laws.van_der_waals.hamaker_J?"),
                ("limits", "limit", "did you mean limits?"),
                ("type", "kind", "holder.kind = ")):
            text = json.dumps(self.paper, indent=1)
            broken = re.sub(f'"{old}":', f'"{new}":', text, count=1)
            line = 1 + broken[:broken.index(f'"{new}":')].count("\n")
            file = self.path("broken.json")
            with open(file, "w") as out:
                out.write(broken)
            self.refused(2, "forces", "--scene", file, says=[f"{file}: line {line}: ", says])
            # A value of --set has no line, the others keep theirs.
            self.refused(2, "forces", "--scene", file, "--set", "limits.time_s=3" if new != "limit"
                         else "name=x", says=[f"{file} with --set: line {line}: ", says])
        self.refused_file(verb, '{\n"name": "x",\n// of silica\n"fibre": {}}',
                          "line 3: JSON has no comments")
        self.refused_file(verb, {"name": "x", "roughness_nm": 1},
                          "fibre is missing: an object {...}")
        run = ferrule("forces", "--set", "fibre.poisson=0.6")
        self.assertIn("demo.json with --set: fibre.poisson = 0.6", run.stderr)
        pen = json.load(open(SOURCE + "/data/devices/pen.json"))
        pen["mass_g"] = 1000 * pen.pop("mass_kg")
        self.refused_file(["doctor", "--device", "FILE"], pen,
                          f"line {1 + len(pen)}: mass_g = {pen['mass_g']}: unknown key; here it is "
                          "mass_kg")
        tuned = json.load(open(SOURCE + "/data/controllers/tuned_by_hand.json"))
        tuned["trained_on"]["row"] = tuned["trained_on"].pop("rows")
        text = json.dumps(tuned, indent=1).split("\n")
        line = 1 + [words.strip().split(":")[0] for words in text].index('"row"')
        self.refused_file(["evaluate", "FILE"], tuned,
                          f"line {line}: trained_on.row = 0: unknown key; did you mean trained_on.rows?")

    def test_a_scene_must_not_contradict_itself(self):
        holder = 'holder={"type":"elastic_fibre","free_length_mm":%g,"gripper_stiffness_N_m":1}'
        self.refused(2, "forces", "--set", holder % 60, says=["fibre.manipulated_length_mm"])
        self.refused(2, "forces", "--scene", "bench", "--set", "holder.free_length_mm=8", "--set",
                     "success.depth_um=10000", says=["success.depth_um", "free to go in"])

    def test_messages(self):
        self.refused(2, "forces", "--set", "ferrule.bore_diameter_um=124.9",
                     says=["demo.json", "ferrule.bore_diameter_um = 124.9", "wider than the fibre"])
        self.refused(2, "forces", "--set", "fibre.poisson=0.6", says=["fibre.poisson = 0.6"])
        self.refused(2, "forces", "--set", "scaling.tip_range_um=1e-320", says=["scaling"])
        self.refused(2, "forces", "--set", "holder.tpye=3", says=["holder.tpye = 3", "unknown key"])
        self.refused(3, "forces", "--scene", "nowhere", says=["nowhere", "paper"])
        self.refused(3, "forces", "--scene", "/no/where.json", says=["/no/where.json"])
        broken = self.path("broken.json")
        for text in ('{"name": "x",\n "fibre": NaN}', '{"name": "a", "name": "b"}', "", "[1, 2]", "\x00\xff", '{"name": 1e999}'):
            with open(broken, "w") as out:
                out.write(text)
            self.refused(2, "forces", "--scene", broken, says=[broken])


if __name__ == "__main__":
    main()

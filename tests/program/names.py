"""Files and names as other systems and libraries make them."""

import csv
import glob
import json
import os
import shutil
from xml.etree import ElementTree

import h5py

from case import QUICK, SOURCE, Case, ferrule, main

APPLE_DOUBLE = b"\0\5\x16\7\0\2\0\0Mac OS X        " + b"\0" * 4000
LEFT = {"._episode_0001.h5": APPLE_DOUBLE, ".DS_Store": b"\0\0\0\1Bud1" + b"\0" * 6000, "Thumbs.db": b"\xd0\xcf\x11\xe0",
        "desktop.ini": "[.ShellClassInfo]\r\n".encode("utf-16"), "._episode_0002.part": APPLE_DOUBLE,
        "._.DS_Store": APPLE_DOUBLE, ".episode_0001.h5.swp": b"x", "~$episode.xlsx": b"x"}


class Folders(Case):
    def setUp(self):
        super().setUp()
        self.out = self.path("out")
        self.episodes = self.record(self.out, episodes=5)
        self.episode = self.episodes[0]

    # Of different episodes: one and the same twice would count once.
    def copies(self, folder, *names):
        os.makedirs(folder, exist_ok=True)
        for episode, name in zip(self.episodes, names):
            shutil.copy(episode, os.path.join(folder, name))
        return folder

    def scored(self, folder):
        found = json.loads(self.done("score", folder, "--json").stdout)
        return [os.path.basename(row["file"]) for row in found["episodes"]]

    def test_episodes_come_in_the_order_of_their_numbers(self):
        names = ["episode_0002.h5", "episode_9999.h5", "episode_10000.h5", "episode_10000 (1).h5", "episode_100000.h5"]
        folder = self.copies(self.path("many"), *names)
        names[2:4] = names[3], names[2]  # a space comes before a dot
        self.assertEqual(self.scored(folder), names)
        self.done("view", folder, "--export", self.path("all.html"))
        with open(self.path("all.html")) as page:
            text = page.read()
        places = [text.index('"' + name) for name in names]
        self.assertEqual(places, sorted(places))

    def test_what_others_leave_in_a_folder_is_no_episode(self):
        folder = self.copies(self.path("stick"), "episode_0001.h5", "EPISODE_0002.H5", "episode_0001 (1).h5")
        for name, content in LEFT.items():
            with open(os.path.join(folder, name), "wb") as left:
                left.write(content)
        self.assertEqual(sorted(self.scored(folder)), ["EPISODE_0002.H5", "episode_0001 (1).h5", "episode_0001.h5"])
        before = sorted(os.listdir(folder))
        self.assertNotIn("._", self.done("recover", folder).stdout)
        self.assertEqual(sorted(os.listdir(folder)), before)
        self.refused(2, "record", "--scene", "paper", *QUICK, "--out", folder, says=["already holds episodes"])
        self.done("record", "--scene", "paper", *QUICK, "--episodes", 1, "--append", "--out", folder)
        self.assertIn("episode_0003.h5", os.listdir(folder))
        only = self.copies(self.path("capitals"), "EPISODE_0007.H5")
        self.refused(2, "record", "--scene", "paper", *QUICK, "--out", only, says=["already holds episodes"])

    def test_a_filter_that_is_missing_is_named(self):
        for name, options, number in (("lzf", {"compression": "lzf"}, 32000),):
            with h5py.File(self.episode) as source, h5py.File(self.path("other.h5"), "w") as target:
                for key, value in source.attrs.items():
                    target.attrs[key] = value

                def copy(path, item):
                    if isinstance(item, h5py.Dataset):
                        numbers = item.dtype.kind in "fi" and item.shape
                        made = target.create_dataset(path, data=item[()], dtype=item.dtype, **(options if numbers else {}))
                        made.attrs.update({k: v for k, v in item.attrs.items() if k not in
                                           ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")})
                    else:
                        target.require_group(path).attrs.update(item.attrs)

                source.visititems(copy)
            for command in (("replay", self.path("other.h5")), ("score", self.path("other.h5"))):
                self.refused(3, *command, says=[f"filter {number} ({name})", "missing here"])
            self.assertNotIn("damaged", ferrule("replay", self.path("other.h5")).stderr)

    def test_gzip_and_checksums_of_others_are_read(self):
        rows = h5py.File(self.episode)["data/demo_0/states"][()]
        with h5py.File(self.episode, "r+") as file:
            attributes = dict(file["data/demo_0/states"].attrs)
            del file["data/demo_0/states"]
            made = file.create_dataset("data/demo_0/states", data=rows, compression="gzip", compression_opts=9,
                                       fletcher32=True, shuffle=True)
            for key in ("unit", "columns", "about"):
                if key in attributes:
                    made.attrs[key] = attributes[key]
        self.done("score", self.episode)

    def test_names_that_are_no_utf_8_or_have_line_breaks(self):
        for odd in ("M\udcfcller", "two\nlines", "carriage\rreturn", "gr\u00f6\u00dfe \u4e2d", "tab\t'quote\"", "-dash"):
            folder = self.path(odd)
            self.copies(folder, "episode_0001.h5", "episode_0002.h5")
            for command in (["score", folder], ["score", folder, "--json"], ["score", folder, "--csv"],
                            ["replay", folder], ["replay", folder, "--json"],
                            ["view", folder, "--export", folder + "/page.html"]):
                run = self.done(*command, errors="surrogateescape")
                if "--json" in command:
                    json.loads(run.stdout)
            shutil.copy(SOURCE + "/data/controllers/tuned_by_hand.json", folder + "/law.json")
            for more in ((), ("--json",), ("--csv",), ("--report", folder + "/r.html", "--trials-out", folder + "/t.csv")):
                self.done("evaluate", folder + "/law.json", "--trials", 1, "--scene", "paper", *QUICK, "--other-scaling", *more,
                          errors="surrogateescape")
            job = ("evaluate", folder + "/law.json", "--trials", 2, "--scene", "paper", *QUICK, "--other-scaling")
            sharded = (*job, "--shard", "1/1", "--out", folder + "/job")
            if "\udcfc" in folder:  # what JSON cannot keep
                self.refused(2, *sharded, says=["must be UTF-8"], errors="surrogateescape")
            else:
                self.done(*sharded)
                self.done("merge", folder + "/job")


class Texts(Case):
    """JSON that was saved by editors of other systems."""

    def saved(self, document, encoding, name="scene.json", ends="\r\n", mark=b""):
        text = json.dumps(document, indent=1, ensure_ascii=False).replace("\n", ends)
        with open(self.path(name), "wb") as out:
            out.write(mark + text.encode(encoding))
        return self.path(name)

    def setUp(self):
        super().setUp()
        with open(SOURCE + "/data/scenes/demo.json") as file:
            self.scene = json.load(file)
        with open(SOURCE + "/data/controllers/tuned_by_hand.json") as file:
            self.controller = json.load(file)

    def test_utf_8_with_a_mark_and_any_line_ends_is_read(self):
        def forces(**how):  # without the line that has the file's SHA-1
            text = self.done("forces", "--scene", self.saved(self.scene, "utf-8", **how)).stdout
            return [line for line in text.splitlines() if "SHA-1" not in line]

        plain = forces(ends="\n")
        for mark in (b"", b"\xef\xbb\xbf"):
            for ends in ("\r\n", "\r", "\n"):
                self.assertEqual(forces(mark=mark, ends=ends), plain)
                law = self.saved(self.controller, "utf-8", "law.json", mark=mark, ends=ends)
                self.done("evaluate", law, "--trials", 1, "--scene", "demo", "--other-scaling")
        wrong = {**self.scene, "ferrrule": {}}
        self.refused(2, "forces", "--scene", self.saved(wrong, "utf-8", mark=b"\xef\xbb\xbf"), says=["line", "ferrrule"])

    def test_another_encoding_is_named(self):
        for encoding in ("utf-16", "utf-16-le", "utf-16-be", "utf-32"):
            file = self.saved(self.scene, encoding)
            self.refused(2, "forces", "--scene", file, says=["UTF-16", "save it as UTF-8"])
            law = self.saved(self.controller, encoding, "law.json")
            self.refused(2, "evaluate", law, says=["UTF-16", "save it as UTF-8"])
            self.refused(2, "report", law, says=["UTF-16"])
        self.scene["name"] = "gr\u00f6\u00dfe"
        self.refused(2, "forces", "--scene", self.saved(self.scene, "latin-1"), says=["line 2: is not UTF-8"])

    def test_excel_sees_what_is_not_ascii(self):
        table = self.path("trials.csv")
        for name, mark in (("law.json", False), ("M\u00fcller.json", True)):
            shutil.copy(SOURCE + "/data/controllers/tuned_by_hand.json", self.path(name))
            self.done("evaluate", name, "--trials", 2, "--scene", "bench", "--trials-out", table, cwd=self.folder)
            with open(table, "rb") as file:
                self.assertEqual(file.read().startswith(b"\xef\xbb\xbf"), mark)
            with open(table, encoding="utf-8-sig", newline="") as file:
                self.assertEqual([row["controller"] for row in csv.DictReader(file)], [name] * 2)
            out = self.done("evaluate", name, "--trials", 2, "--scene", "bench", "--csv", cwd=self.folder).stdout
            self.assertTrue(out.startswith("controller"), out[:40])


class Controllers(Case):
    """A controller has one name in every verb."""

    NAMES = ("constant-velocity", "spiral", "searching-operator", "search", "tuned_by_hand")

    def test_every_verb_takes_every_name(self):
        self.done("record", "--scene", "bench", "--episodes", 3, "--out", self.path("episodes"))
        quick = ("--scene", "bench", "--trials", 2)
        for name in self.NAMES:
            found = json.loads(self.done("evaluate", name, *quick, "--json").stdout)
            self.assertEqual(found["controller"], name)
            swept = json.loads(self.done("sweep", name, "limits.force_uN=60", *quick, "--json").stdout)
            again = json.loads(self.done("evaluate", name, *quick, "--set", "limits.force_uN=60", "--json").stdout)
            self.assertEqual(swept["rows"][0]["outcomes"], again["rows"][0]["outcomes"])
            self.done("view", name, "--trial", 0, "--scene", "bench", "--export", self.path("page.html"))
            self.done("view", "search", "--trial", 0, "--against", name, "--scene", "bench", "--export", self.path("page.html"))
            folder = self.path("by " + name)
            self.done("record", "--operator", name, "--scene", "bench", "--episodes", 1, "--out", folder)
            with h5py.File(folder + "/episode_0001.h5") as file:
                self.assertIn({"searching-operator": "searching"}.get(name, name), file.attrs["operator"].decode())
        compared = json.loads(self.done("compare", self.path("episodes"), *self.NAMES, "--learners", "linear", "--trials", 2,
                                        "--json").stdout)
        self.assertTrue(set(self.NAMES) <= {row["controller"] for row in compared["rows"]})
        straight = [row["outcomes"] for row in compared["rows"] if row["controller"] in ("constant velocity", self.NAMES[0])]
        self.assertEqual(straight[0], straight[1])

    def test_what_has_no_numbers_is_refused_in_words(self):
        for name in ("constant-velocity", "spiral", "searching-operator", "policy.pt"):
            self.refused(2, "improve", name, "--scene", "bench", "--out", self.path("x.json"), says=[name, "no gains"])
            self.refused(2, "export", name, "--header", self.path("x.h"), says=[name])

    def test_the_nearest_name_is_told(self):
        for command in (("evaluate", "constant_velocity"), ("sweep", "constant_velocity", "limits.force_uN=60"),
                        ("record", "--operator", "constant_velocity", "--out", self.path("x")),
                        ("view", "--trial", 0, "--against", "constant_velocity", "--export", self.path("x"))):
            self.refused(3, *command, says=["did you mean constant-velocity?"])

    def test_a_file_of_that_name_is_the_controller(self):
        shutil.copy(SOURCE + "/data/controllers/tuned_by_hand.json", self.path("spiral"))
        found = [json.loads(self.done("evaluate", name, "--scene", "bench", "--trials", 2, "--json", cwd=self.folder).stdout)
                 ["peak_force_uN"] for name in ("spiral", "tuned_by_hand")]
        self.assertEqual(*found)


class Plots(Case):
    """A drawing is XML, and says every name as it is."""

    NAMES = ("a]]>b", "]]>" * 33, "<b>&amp;</b> & \"quotes\" 'and' `others`", "x" * 100,
             "gr\u00f6\u00dfe \u4e2d \U0001f600", "%d $0 {/Bold x}_2^3 \\n \\", "no \uffff character")

    def texts(self, file):
        return ["".join(text.itertext()) for text in ElementTree.parse(file).iter("{http://www.w3.org/2000/svg}text")]

    def test_a_scene_may_have_any_name(self):
        with open(SOURCE + "/data/scenes/paper.json") as file:
            scene = json.load(file)
        for name in self.NAMES:
            scene["name"] = name
            with open(self.path("scene.json"), "w") as file:
                json.dump(scene, file)
            self.done("forces", "--scene", self.path("scene.json"), "--gap-nm", "1:9:9", "--plot", self.path("plot.svg"))
            shown = name.replace("\uffff", "\\xef\\xbf\\xbf")
            self.assertTrue([text for text in self.texts(self.path("plot.svg")) if shown in text], name[:40])

    def test_a_controller_may_have_any_name(self):
        self.done("record", "--scene", "demo", *QUICK, "--episodes", 3, "--out", self.path("episodes"))
        for name in ("a]]>b", "<b>&amp; ", "'\"`\n\u4e2d", "x" * 200):
            shutil.copy(SOURCE + "/data/controllers/tuned_by_hand.json", self.path(name))
            self.done("compare", self.path("episodes"), "./" + name, "--learners", "linear", "--trials", 2, "--plot",
                      "plots", cwd=self.folder)
            for plot in glob.glob(self.path("plots/*.svg")):
                self.texts(plot)


main()

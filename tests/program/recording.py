import glob
import json
import os
import pty
import re
import signal
import subprocess
import time
import unittest

import h5py
import numpy

from case import PROGRAM, QUICK, SOURCE, Case, ferrule, main, sanitized


class Recording(Case):
    # What is recorded is what the holder did, so it is replayed without making the errors again.
    def test_errors_of_the_hand_are_drawn_and_replayed(self):
        out = self.path("hand")
        files = self.record(out, "--set", "hand.gain=0.59..1.41", "--set", "hand.delay_ms=0..50", "--set",
                            "hand.smoothing_ms=20", episodes=2)
        gains = []
        for file in files:
            self.done("replay", file, "--verify")
            with h5py.File(file) as f:
                hand = json.loads(f.attrs["scene"])["hand"]
            gains.append(hand["gain"])
            self.assertTrue(0.59 <= hand["gain"] <= 1.41 and 0 <= hand["delay_ms"] <= 50)
        self.assertNotEqual(*gains)

        def time_of(*settings):
            return json.loads(self.done(
                "evaluate", "--baseline", "constant-velocity", "--scene", "bench", *QUICK, *settings, "--trials",
                2, "--json").stdout)["time_s"]["median"]
        plain = time_of()
        self.assertAlmostEqual(time_of("--set", "hand.gain=2"), plain / 2, delta=0.05 * plain)
        self.assertAlmostEqual(time_of("--set", "hand.delay_ms=300"), plain + 0.3, delta=0.01)
        for setting in ("hand.gain=0", "hand.gain=0..1", "hand.delay_ms=-1"):
            self.refused(2, "evaluate", "--baseline", "constant-velocity", "--set", setting,
                         says=[setting.split("=")[0]])

    def test_who_searches_by_touch_is_recorded_with_the_phase_of_each_row(self):
        out = self.path("searched")
        done = self.done("record", "--scene", "by_hand/face", "--operator", "searching", "--skill", 0.9, "--episodes", 1,
                         "--out", out, "--json")
        (episode,) = json.loads(done.stdout)["episodes"]
        self.assertEqual(episode["outcome"], "inserted")
        self.done("replay", out, "--verify")
        self.refused(2, "record", "--operator", "searching", "--supervise", "--out", self.path("other"),
                     says=["--supervise"])
        with h5py.File(episode["file"]) as f:
            self.assertEqual(f.attrs["operator"], b"searching, skill 0.9")
            demo = f["data/demo_0/rows"]
            begins, names = zip(*json.loads(f.attrs["phases"]))
            rows = demo["time"].shape[0]
            phase = numpy.repeat(names, numpy.diff(begins + (rows,)))
            force, lateral = demo["holder_wrench"][:, 0], demo["command"][:, 1:3]
        self.assertEqual(begins[0], 0)
        self.assertEqual(len(phase), rows)
        self.assertEqual((names[0], names[-1]), ("approach", "insert"))
        self.assertTrue({"touch", "release", "lift", "move", "lower"} <= set(names))
        self.assertGreater(names.count("touch"), 5)
        # He presses where he touches, and goes sideways where he moves.
        self.assertGreater(abs(force[phase == "touch"]).mean(), 5 * abs(force[phase == "approach"]).mean())
        sideways = numpy.linalg.norm(lateral, axis=1)
        self.assertGreater(sideways[phase == "move"].mean(), 2 * sideways[phase == "touch"].mean())

    def test_an_episode_is_read_by_h5py_as_documented(self):
        files = self.record(self.path("out"))
        self.assertEqual(len(files), 3)
        with h5py.File(files[1]) as f:
            self.assertEqual(f.attrs["format"], b"ferrule episode")
            self.assertEqual(f.attrs["outcome"], b"inserted")
            self.assertEqual(json.loads(f.attrs["scene"])["name"], "paper")
            self.assertEqual(f.attrs["trial"], 2)
            self.assertAlmostEqual(f.attrs["alpha_x"], 250)
            demo = f["data/demo_0"]
            n = demo.attrs["num_samples"]
            self.assertEqual(f["data"].attrs["total"], n)
            arguments = json.loads(f["data"].attrs["env_args"])
            self.assertTrue({"env_name", "type", "env_type", "env_version", "env_kwargs"}
                            <= set(arguments))
            for name in ("actions", "states"):
                self.assertEqual(demo[name].shape[0], n)
                self.assertEqual(demo[name].compression, "gzip")
            self.assertEqual(demo["rewards"].shape, (n,))
            self.assertEqual(demo["dones"][-1], 1)
            self.assertEqual(demo["rewards"][-1], 1)
            self.assertLessEqual(abs(demo["actions"][:]).max(), 1)
            for key in demo["obs"]:
                now, later = demo["obs"][key][:], demo["next_obs"][key][:]
                self.assertTrue((now[1:] == later[:-1]).all())
            # Unscaled actions are the commands, and commands move the hand.
            scale = demo["actions"].attrs["scale_m_s"]
            command = demo["rows/command"][:]
            numpy.testing.assert_allclose(demo["actions"][:, 0] * scale, command[:, 0], rtol=1e-12)
            pose = demo["rows/hand_pose"][:]
            numpy.testing.assert_allclose(numpy.diff(pose, axis=0) / 1e-3, command[:-1], atol=1e-11)
            # The hand's world is the tip's, scaled: the hand in the state is the hand's pose.
            numpy.testing.assert_allclose(demo["states"][:, 5:8] * 250, pose[:, :3], rtol=1e-12)
            wrench = demo["rows/holder_wrench"][:, :3]
            numpy.testing.assert_allclose(demo["obs/wrench_N"][:, :3], wrench * 8.46e5, rtol=1e-5,
                                          atol=1e-6)
            # In equilibrium the holder carries the sum of all other forces.
            total = demo["rows/forces"][:].reshape(n, 11, 3).sum(axis=1)
            numpy.testing.assert_allclose(total, wrench, atol=5e-11)

            def units(name, item):
                if isinstance(item, h5py.Dataset) and not h5py.h5ds.is_scale(item.id):
                    self.assertIn("unit", item.attrs, name)
                    self.assertIn("columns", item.attrs, name)

            demo.visititems(units)

    def test_the_readme_lists_the_columns_of_an_episode(self):
        (file,) = self.record(self.path("listed"), episodes=1)
        with open(os.path.join(SOURCE, "capture/README.md"), encoding="utf-8") as page:
            readme = page.read()
        listed = re.findall(r"^  ((?:rows/|obs/)?\w+) +\(N(?:, (\d+))?\)", readme, re.MULTILINE)
        self.assertGreater(len(listed), 10)
        with h5py.File(file) as f:
            demo = f["data/demo_0"]
            for name, width in listed:
                self.assertEqual(demo[name].shape[1:], (int(width),) if width else (), name)
            for name in ("rows/forces", "states"):
                self.assertIn(demo[name].attrs["about"].decode(), " ".join(readme.split()))
            numbers = sum(demo[name].size for name in [*("rows/" + key for key in demo["rows"]), "states"])
            self.assertIn(f"{8 * numbers // len(demo['time'])} bytes each", readme)

    def test_dimensions_have_scales_and_columns_names(self):
        self.done("record", "--scene", "paper", "--set", "start.lateral_sd_um=0", "--seed", "5",
                  "--out", self.path("scales"))
        file = self.path("scales/episode_0001.h5")
        with h5py.File(file) as f:
            demo = f["data/demo_0"]
            for name in ("rows/forces", "states", "actions", "obs/wrench_N", "next_obs/depth_mm"):
                rows, columns = demo[name].dims
                self.assertEqual(rows[0], demo["time"])
                self.assertEqual(columns[0].shape, demo[name].shape[1:])
                self.assertEqual(len(demo[name].attrs["columns"]), demo[name].shape[1])
            self.assertEqual([c.decode() for c in demo["states"].attrs["columns"][30:35]],
                             ["tip_before_" + c for c in ("x", "y", "z", "tilt_y", "tilt_z")])
            self.assertEqual(demo["rows/forces"].attrs["units"], b"N")
            self.assertNotIn("units", demo["rows/hand_pose"].attrs)
            self.assertTrue((demo["time"][:] == demo["rows/time"][:]).all())

    def test_files_of_format_1_are_read_and_verified(self):
        self.done("record", "--scene", "paper", "--set", "start.lateral_sd_um=0", "--seed", "5",
                  "--out", self.path("before"))
        file = self.path("before/episode_0001.h5")
        terms = json.loads(self.done("forces", file, "--json").stdout)["terms"]
        with h5py.File(file, "r+") as f:  # as it was: columns in one text, no scales, no flow and air
            demo, tables = f["data/demo_0"], []
            demo.visititems(lambda name, item: tables.append(name)
                            if isinstance(item, h5py.Dataset) else None)
            scales = [name for name in tables if h5py.h5ds.is_scale(demo[name].id)]
            for name in set(tables) - set(scales):
                table = demo[name]
                for dimension in table.dims:
                    for scale in list(dimension.values()):
                        dimension.detach_scale(scale)
                about = table.attrs["about"]
                for key in ("about", "columns", "units"):
                    table.attrs.pop(key, None)
                table.attrs["columns"] = about
            for name in scales:
                del demo[name]
            for name, width, last in (("rows/forces", 27, " flow particle"),
                                      ("states", 41, "; air")):
                values, attributes = demo[name][:, :width], dict(demo[name].attrs)
                del demo[name]
                demo[name] = values
                for key, value in attributes.items():
                    demo[name].attrs[key] = value.replace(last.encode(), b"") if (
                        key == "columns") else value
            f.attrs["format_version"] = numpy.int64(1)
            del f.attrs["inputs_sha1"]
        self.assertIn("every bit", self.done("replay", file, "--verify").stdout)
        self.assertEqual(json.loads(self.done("forces", file, "--json").stdout)["terms"], terms)

    def test_files_of_formats_3_and_4_are_read_and_verified(self):
        for version, extra in ((3, {"linearization": 28}), (4, {"linearization": 28, "tangent": 140})):
            folder = self.path(f"format{version}")
            self.done("record", "--scene", "paper", "--set", "start.lateral_sd_um=0", "--seed", "5",
                      "--out", folder)
            file = folder + "/episode_0001.h5"
            with h5py.File(file, "r+") as f:  # as it was: with the warm start of the next step
                demo = f["data/demo_0"]
                for name, width in extra.items():
                    table = demo.create_dataset("rows/" + name, data=numpy.ones((len(demo["time"]), width)))
                    table.attrs["unit"] = "1"
                    scale = demo.create_dataset(name, data=numpy.arange(width))
                    scale.make_scale(name)
                    table.dims[0].attach_scale(demo["time"])
                    table.dims[1].attach_scale(scale)
                f.attrs["format_version"] = numpy.int64(version)
                del f.attrs["inputs_sha1"]
            self.assertIn("every bit", self.done("replay", file, "--verify").stdout)

    def test_files_of_format_2_are_read_and_verified(self):
        self.done("record", "--scene", "paper", "--set", "start.lateral_sd_um=0", "--seed", "5",
                  "--out", self.path("second"))
        file = self.path("second/episode_0001.h5")
        terms = json.loads(self.done("forces", file, "--json").stdout)["terms"]
        with h5py.File(file, "r+") as f:  # as it was: no particle among the forces
            demo, forces = f["data/demo_0"], f["data/demo_0/rows/forces"]
            scales = [list(dimension.values()) for dimension in forces.dims]
            names = [c for c in scales[1][0][:] if not c.startswith(b"particle")]
            attributes = dict(forces.attrs)
            values = forces[:, :30]
            scale = scales[1][0].name
            for dimension, of in zip(forces.dims, scales):
                dimension.detach_scale(of[0])
            del demo["rows/forces"], f[scale]
            f[scale] = numpy.array(names)
            f[scale].make_scale("force")
            demo["rows/forces"] = values
            for key in ("unit", "units"):
                demo["rows/forces"].attrs[key] = attributes[key]
            demo["rows/forces"].attrs["columns"] = numpy.array(names)
            demo["rows/forces"].attrs["about"] = attributes["about"].replace(b" particle", b"")
            demo["rows/forces"].dims[0].attach_scale(scales[0][0])
            demo["rows/forces"].dims[1].attach_scale(f[scale])
            f.attrs["format_version"] = numpy.int64(2)
            del f.attrs["inputs_sha1"]
        self.assertIn("every bit", self.done("replay", file, "--verify").stdout)
        self.assertEqual(json.loads(self.done("forces", file, "--json").stdout)["terms"], terms)

    def test_texts_may_be_of_variable_length(self):
        self.done("record", "--scene", "paper", "--set", "start.lateral_sd_um=0", "--seed", "5",
                  "--out", self.path("texts"))
        file = self.path("texts/episode_0001.h5")
        with h5py.File(file, "r+") as f:
            for key in ("operator", "scene", "outcome", "format"):
                f.attrs[key] = f.attrs[key].decode()
            self.assertTrue(h5py.check_string_dtype(f.attrs.get_id("scene").dtype).length is None)
        self.assertIn("every bit", self.done("replay", file, "--verify").stdout)

    def test_same_seed_same_rows_other_seed_other_rows(self):
        a = self.record(self.path("a"), "--seed", 5, episodes=1)[0]
        b = self.record(self.path("b"), "--seed", 5, episodes=1)[0]
        c = self.record(self.path("c"), "--seed", 6, episodes=1)[0]
        states = [h5py.File(f)["data/demo_0/states"][:] for f in (a, b, c)]
        self.assertTrue((states[0] == states[1]).all())
        self.assertFalse(states[0].shape == states[2].shape and (states[0] == states[2]).all())

    def test_a_folder_with_episodes_is_only_added_to_when_asked(self):
        out = self.path("out")
        self.record(out, episodes=1)
        self.refused(2, "record", "--out", out, says=["--append"])
        self.assertEqual(len(self.record(out, "--append", episodes=2)), 3)
        self.refused(2, "record", "--out", out, "--append", "--set", "scaling.tip_range_um=200",
                     says=["episode_0003.h5", "another scaling"])
        self.assertEqual(len(glob.glob(out + "/*")), 3)

    def test_kill_loses_no_finished_episode_and_recover_brings_back_the_running_one(self):
        for delay in (0.3, 0.8, 1.3):
            out = self.path(f"out{delay}")
            process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000",
                                        "--out", out], stdout=subprocess.PIPE, text=True)
            self.assertTrue(process.stdout.readline().startswith("scene paper"))
            first = process.stdout.readline()
            self.assertIn("episode_0001.h5", first)
            time.sleep(delay)
            process.kill()
            told = [first] + process.stdout.read().splitlines()
            process.wait()
            process.stdout.close()
            whole = glob.glob(out + "/*.h5")
            self.assertGreaterEqual(len(whole), len([t for t in told if ".h5" in t]))
            parts = glob.glob(out + "/*.part")
            # Between two episodes there may be none; one that had no rows yet stays.
            result = json.loads(self.done("recover", out, "--json").stdout)["recovered"]
            self.assertEqual(len(result), len(parts))
            for each in result:
                if each["file"]:
                    with h5py.File(each["file"]) as f:
                        self.assertEqual(f["data/demo_0/states"].shape[0], each["rows"])
                        self.assertEqual(f.attrs["outcome"].decode(), each["outcome"])
                        self.assertIn(each["outcome"], ("inserted", "interrupted"))
            for file in sorted(glob.glob(out + "/*.h5"))[-3:]:
                self.done("replay", file, "--verify")
            self.assertEqual(glob.glob(out + "/*.tmp"), [])

    def test_ctrl_c_ends_the_episode_cleanly_and_says_so(self):
        out = self.path("out")
        process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000",
                                    "--out", out], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True)
        process.stdout.readline()  # the scene
        process.stdout.readline()
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertIn("stopped by Ctrl-C", errors)
        self.assertEqual(glob.glob(out + "/*.part"), [])
        for file in sorted(glob.glob(out + "/*.h5"))[-3:]:
            self.done("replay", file, "--verify")

    def test_a_closed_terminal_ends_the_episode_of_a_device_cleanly(self):
        for which in (signal.SIGHUP, signal.SIGTERM, signal.SIGQUIT):
            out = self.path(which.name)
            process = subprocess.Popen(
                [PROGRAM, "record", "--device", "fake:pid", "--episodes", "1", "--out", out],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                text=True, preexec_fn=lambda: signal.signal(which, signal.SIG_DFL))
            while not glob.glob(out + "/*.part"):
                time.sleep(0.05)
            time.sleep(1)
            process.send_signal(which)
            process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130)
            self.assertEqual(glob.glob(out + "/*.part"), [])
            with h5py.File(out + "/episode_0001.h5") as f:
                self.assertEqual(f.attrs["outcome"], b"interrupted")

    def test_parts_that_never_fit_leave_no_journal(self):
        scene = {"name": "never", "extends": "bench", "fibre": {"diameter_um": 126.9},
                 "ferrule": {"bore_diameter_um": 127}, "tolerance": {"bore_diameter_um": [126, 126.1]}}
        with open(self.path("never.json"), "w") as file:
            json.dump(scene, file)
        out = self.path("out")
        self.refused(2, "record", "--scene", self.path("never.json"), "--out", out,
                     says=["not one has parts that fit"])
        self.assertEqual(os.listdir(out), [])

    def test_a_full_disk_is_one_line_and_keeps_what_was_flushed(self):
        out = self.path("out")

        def small_files():
            import resource
            resource.setrlimit(resource.RLIMIT_FSIZE, (6_000_000, 6_000_000))

        # The journal fits and the episode does not, or neither does.
        whole = self.path("whole")
        self.record(whole, episodes=1)
        for limit in (os.path.getsize(glob.glob(whole + "/*.h5")[0]) // 2, 100):
            def tight():
                import resource
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            run = ferrule("record", "--scene", "paper", *QUICK, "--episodes", 1, "--out",
                          self.path(f"tight{limit}"), preexec_fn=tight)
            self.assertEqual(run.returncode, 3, run.stderr)
        run = ferrule("record", "--scene", "paper", "--episodes", 1, "--out", out,
                      preexec_fn=small_files)
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertEqual(glob.glob(out + "/*.h5") + glob.glob(out + "/*.tmp"), [])
        recovered = json.loads(self.done("recover", out, "--json").stdout)["recovered"]
        self.assertGreater(recovered[0]["rows"], 2500)
        self.done("replay", recovered[0]["file"], "--verify")

    def test_two_recorders_share_a_folder(self):
        out = self.path("out")
        first = subprocess.Popen([PROGRAM, "record", "--scene", "paper", *QUICK, "--episodes", "6",
                                  "--seed", "1", "--out", out], stdout=subprocess.PIPE, text=True)
        first.stdout.readline()  # the scene
        first.stdout.readline()
        second = self.done("record", "--scene", "paper", *QUICK, "--episodes", 6, "--seed", 99,
                           "--out", out, "--append").stdout
        told = first.communicate()[0] + second
        self.assertEqual(first.returncode, 0)
        files = sorted(glob.glob(out + "/*.h5"))
        self.assertEqual(len(files), 12)
        seeds = [int(h5py.File(file).attrs["seed"]) for file in files]
        self.assertEqual((seeds.count(1), seeds.count(99)), (6, 6))
        for file in files[1:]:
            self.assertEqual(told.count(file), 1)

    def test_a_recorder_that_waits_for_its_start_keeps_its_number(self):
        out = self.path("out")
        terminal, other_end = pty.openpty()
        first = subprocess.Popen([PROGRAM, "record", "--device", "fake:spacemouse", *QUICK,
                                  "--episodes", "1", "--out", out],
                                 stdin=other_end, stdout=subprocess.PIPE, stderr=other_end)
        os.close(other_end)
        told = b""
        while b"space starts it" not in told:
            told += os.read(terminal, 1000)
        self.assertIn("still being recorded", self.done("recover", out).stdout)
        self.record(out, "--append", episodes=1)
        self.assertEqual(sorted(os.listdir(out)), ["episode_0001.part", "episode_0002.h5"])
        os.write(terminal, b" ")
        while b"rates it" not in told:
            told += os.read(terminal, 1000)
        os.write(terminal, b"4")
        with self.assertRaises(OSError):  # what it says until it has ended
            while True:
                os.read(terminal, 1000)
        first.communicate(timeout=60)
        os.close(terminal)
        self.assertEqual(first.returncode, 0)
        self.assertEqual(sorted(os.listdir(out)), ["episode_0001.h5", "episode_0002.h5"])

    # 4 minutes and more at 1 kHz are 190 MB of rows.
    @unittest.skipIf(sanitized(), "sanitizers take memory")
    def test_a_long_recording_takes_no_more_memory_than_a_short_one(self):
        def within_memory(*words):
            process = subprocess.Popen([PROGRAM, *words], stdout=subprocess.DEVNULL)
            _, status, used = os.wait4(process.pid, 0)
            self.assertEqual(status, 0, words)
            self.assertLess(used.ru_maxrss / 1024, 175, words)
        slow = ("--scene", "bench", "--set", "limits.speed_um_s=0.4", "--set", "limits.time_s=3600")
        record = ("record", *slow, "--episodes", "1", "--out")
        within_memory(*record, self.path("long"))
        within_memory("replay", self.path("long"), "--verify")
        within_memory("score", self.path("long"))
        journal = self.path("killed") + "/episode_0001.part"
        killed = subprocess.Popen([PROGRAM, *record, self.path("killed")], stdout=subprocess.DEVNULL)
        while not (os.path.exists(journal) and os.path.getsize(journal) > 130e6):
            self.assertIsNone(killed.poll())
            time.sleep(0.02)
        killed.kill()
        killed.wait()
        within_memory("recover", self.path("killed"))
        with h5py.File(journal.replace(".part", ".h5")) as f:
            self.assertGreater(f["data/demo_0"].attrs["num_samples"], 160000)

    def test_recover_keeps_a_journal_whose_episode_cannot_be_read(self):
        out = self.path("out")
        process = subprocess.Popen([PROGRAM, "record", "--scene", "paper", "--episodes", "1000",
                                    "--out", out], stdout=subprocess.PIPE)
        process.stdout.readline()  # the scene
        process.stdout.readline()
        time.sleep(0.05)
        process.kill()
        process.communicate()
        parts = glob.glob(out + "/*.part")  # one that is recorded, and one that is written
        for part in parts:
            with open(part.replace(".part", ".h5"), "w") as junk:
                junk.write("junk")
        self.assertEqual(ferrule("recover", out).returncode, 3 if parts else 0)
        for part in parts:
            self.assertTrue(os.path.exists(part))
        os.mkdir(out + "/episode_0900.part")
        ferrule("recover", out)

    def test_what_cannot_be_recovered_is_kept_and_said_on_stderr(self):
        out = self.path("out")
        os.mkdir(out)
        journals = {"episode_0001.part": b"", "episode_0002.part": b"no end " * 1000,
                    "episode_0003.part": b"no journal\nat all"}
        for name, data in journals.items():
            with open(os.path.join(out, name), "wb") as journal:
                journal.write(data)
        for output in ([], ["--json"], ["--csv"]):
            run = ferrule("recover", out, *output)
            self.assertEqual(run.returncode, 3)
            self.assertEqual(run.stderr.count("\n"), 2, run.stderr)
            for name in ("episode_0002.part", "episode_0003.part"):
                self.assertIn(f"{name} was left as it is: ", run.stderr)
                with open(os.path.join(out, name), "rb") as journal:
                    self.assertEqual(journal.read(), journals[name])
            if not output:
                self.assertIn("episode_0001.part is empty: removed", run.stdout)
        self.assertEqual(len(os.listdir(out)), 2)

    def test_the_longest_trial_ends_an_operator_that_never_finishes(self):
        out, controller = self.path("out"), self.path("controller.json")
        self.record(out, episodes=6)
        self.done("fit", out, "--out", controller)
        law = json.load(open(controller))
        law["gains"]["end_depth"]["value"] = 8.3e-6 * 250
        json.dump(law, open(controller, "w"))
        run = self.done("record", "--operator", controller, "--scene", "paper", *QUICK, "--set",
                        "limits.time_s=9", "--episodes", 1, "--out", self.path("by_law"), "--json")
        self.assertLessEqual(json.loads(run.stdout)["episodes"][0]["time_s"], 9.001)

    def test_numbers_out_of_range(self):
        for option, value in (("--skill", "nan"), ("--skill", "1.1"), ("--seed", "-1"),
                              ("--seed", "9" * 20), ("--seed", "1.5"), ("--episodes", "0")):
            self.refused(2, "record", option, value, "--out", self.path("x"), says=[option])
        self.assertFalse(os.path.exists(self.path("x")))

    def test_a_folder_that_cannot_be_made(self):
        self.refused(3, "record", "--out", "/proc/nothing/here", says=["/proc/nothing/here"])


if __name__ == "__main__":
    main()

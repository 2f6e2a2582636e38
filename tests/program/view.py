import glob
import hashlib
import json
import os
import shutil
import signal
import subprocess
import threading
import time
import urllib.request

import h5py
import numpy

from case import PROGRAM, SOURCE, Case, ferrule, main
from websocket import Window

SHORT = ["--scene", "demo", "--set", "start.distance_um=15", "--set", "success.depth_um=12",
         "--set", "start.lateral_sd_um=3"]


ELEMENT = '<script type="application/json" id="recorded">'


class View(Case):
    def setUp(self):
        super().setUp()
        # As installed, with a page of its own: this needs no Node.
        self.program = self.path("bin/ferrule")
        os.mkdir(self.path("bin"))
        shutil.copy(PROGRAM, self.program)
        shutil.copytree(SOURCE + "/data", self.path("share/ferrule"))
        with open(self.path("share/ferrule/page.html"), "w") as page:
            page.write(f"<!doctype html><title>a page</title>{ELEMENT}</script>")
        self.out = self.path("out")

    def view(self, *arguments):
        process = subprocess.Popen([self.program, "view", "--no-open", "--out", self.out,
                                    *map(str, arguments)],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        for line in process.stdout:
            if line.startswith("http://127.0.0.1:"):
                return process, line.strip()
        self.fail(process.stderr.read())

    def end(self, process, code=130):
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(20), code)
        self.assertNotIn("terminate", process.stderr.read())

    # Inserts as a hand would: pushes, and yields to the force, until the try ends. Returns the
    # history that was shown, and what was said at the end.
    def insert(self, window, while_it_runs=lambda window, row: window, ready=True):
        if ready:
            window.hear_of("state_of_session", running=False)
        window.say(type="start")
        window.hear_of("state_of_session", running=True)
        at = window.columns
        history, sequence, echo = [], 0, 0
        while True:
            heard = window.hear()
            if isinstance(heard, dict):
                if heard["type"] == "ended":
                    return history, heard
                continue
            kind, reserved, rows = heard
            if kind == 2:
                history += rows
                continue
            echo = max(echo, reserved)
            row = rows[-1]
            yields = [row[at[f"force_{axis}_uN"]] for axis in "yz"]
            sequence += 1
            window.say(type="hand", v=[-0.4, *yields], buttons=0, seq=sequence)
            window = while_it_runs(window, row)

    def test_what_a_page_inserts_is_recorded_scored_fitted_and_inserted_again(self):
        process, address = self.view(*SHORT, "--trainee", "Ada", "--seed", 5)
        page = urllib.request.urlopen(address).read().decode()
        self.assertIn("a page", page)
        # It comes with what is to be drawn first.
        first, window = json.loads(page.split(ELEMENT)[1].split("</script>")[0]), Window(address)
        self.assertEqual(first["hello"], window.hear_of("hello"))
        self.assertFalse(first["state"]["running"])
        heard = window.hear()
        while isinstance(heard, dict) or heard[0] != 1:
            heard = window.hear()
        for shown, said in zip(first["frame"], heard[2][0], strict=True):
            self.assertEqual(None if shown is None else numpy.float32(shown),
                             numpy.float32(said) if numpy.isfinite(said) else None)
        window.close()
        window = Window(address)
        for number in range(1, 4):
            history, ended = self.insert(window)
            self.assertEqual(ended["outcome"], "inserted")
            self.assertEqual(ended["file"], f"episode_{number:04}.h5")
            self.assertGreater(ended["score"]["total"], 50)
            with h5py.File(os.path.join(self.out, ended["file"])) as file:
                times = file["data/demo_0/rows/time"][:]
                self.assertEqual(file.attrs["trainee"].decode(), "Ada")
                self.assertEqual(file.attrs["operator"].decode(), "Ada, browser")
                shown = numpy.array(history)
                numpy.testing.assert_allclose(shown[:, window.columns["t_s"]], times, rtol=1e-6)
                tip = 1e6 * file["data/demo_0/states"][:, 0]
                numpy.testing.assert_allclose(shown[:, window.columns["tip_x_um"]], tip, rtol=1e-5,
                                              atol=1e-5)
            if number == 1:
                window.say(type="rate", stars=4)
                window.hear_of("episodes")
        window.say(type="fit")
        fitted = window.hear_of("fit", state="running")
        while fitted["state"] == "running":
            fitted = window.hear_of("fit")
        self.assertEqual(fitted["state"], "done", fitted)
        window.say(type="insert")
        window.hear_of("state_of_session", running=True, what="insert", trial=3)
        ended = window.hear_of("ended", what="insert")
        self.assertNotIn("file", ended)
        self.end(process)
        self.assertEqual(len(glob.glob(self.out + "/*.h5")), 3)
        self.assertEqual(glob.glob(self.out + "/*.part"), [])
        verified = self.done("replay", self.out, "--verify").stdout
        self.assertIn("identical", verified)
        with h5py.File(self.out + "/episode_0001.h5") as file:
            self.assertEqual(file.attrs["rating"], 4)
        scores = json.loads(self.done("score", self.out, "--json").stdout)
        self.assertEqual([g["operator"] for g in scores["groups"]], ["Ada"])
        self.done("fit", self.out, "--out", self.path("controller.json"))

    def test_a_try_ends_at_the_goal_or_goes_on_and_is_inserted_all_the_same(self):
        def stop(window, row):
            if row[window.columns["depth_um"]] > 13:
                window.say(type="stop")
            return window

        def press_sideways(window, row):
            if row[window.columns["depth_um"]] > 12.2:
                window.say(type="hand", v=[0, 1, 0], buttons=0, seq=0)
                time.sleep(0.01)
            return window

        for options, then, deepest, why in (([], stop, (12, 12.1), ""),
                                            (["--go-on-after-goal"], stop, (13, 15), ""),
                                            (["--go-on-after-goal"], press_sideways, (12.2, 15),
                                             "past the success depth: ")):
            process, address = self.view(*SHORT, *options)
            history, ended = self.insert(window := Window(address), then)
            self.assertEqual(ended["outcome"], "inserted")
            self.assertTrue(ended["why"].startswith(why) and bool(ended["why"]) == bool(why))
            if why:
                self.assertIn(ended["hint"], "you pressed on after the goal: stop there")
            depth = max(row[window.columns["depth_um"]] for row in history)
            self.assertTrue(deepest[0] <= depth < deepest[1], depth)
            self.end(process)
            self.done("replay", os.path.join(self.out, ended["file"]), "--verify")

    # What the page without a program saves of a try (view/input_log.hpp), from an episode of the window.
    def log_of(self, file):
        with h5py.File(file) as episode:
            demo, about = episode["data/demo_0"], episode.attrs
            blocks = [demo["rows"][name][:] for name in
                      ("time", "hand_pose", "hand_velocity", "command", "holder_wrench", "forces", "status")]
            blocks.append(demo["states"][:])
            rows = numpy.hstack([block.reshape(len(block), -1) for block in blocks]).astype("<f8")
            counts = demo["raw/counts"][:, :3]
            log = {key: about[key].decode() for key in ("operator", "trainee", "date", "session", "outcome", "build")}
            log |= {"format": "ferrule input log", "format_version": 1, "why": "", "seed": int(about["seed"]),
                    "trial": int(about["trial"]), "scene": json.loads(about["scene"]),
                    "ferrule_version": about["ferrule_version"].decode(),
                    "rows_sha1": hashlib.sha1(rows.tobytes()).hexdigest()}
        begins = [0, *(1 + numpy.flatnonzero((numpy.diff(counts, axis=0) != 0).any(axis=1))), len(counts)]
        log["counts"] = [[int(b - a), *map(int, counts[a])] for a, b in zip(begins, begins[1:])]
        return log

    def test_from_what_the_hand_did_the_episode_is_made_again(self):
        process, address = self.view(*SHORT, "--trainee", "Ada", "--seed", 5)
        _, ended = self.insert(Window(address))
        self.end(process)
        episode, saved, imported = f"{self.out}/{ended['file']}", self.path("try.json"), self.path("imported")
        log = self.log_of(episode)
        self.assertGreater(len(log["counts"]), 10)

        def importing(log):
            with open(saved, "w") as file:
                file.write(log if isinstance(log, str) else json.dumps(log))
            return ferrule("import", saved, "--out", imported, "--json")

        done = importing(log)
        self.assertEqual(done.returncode, 0, done.stderr)
        [made] = json.loads(done.stdout)["imported"]
        self.assertEqual(made["outcome"], "inserted")
        self.assertEqual(self.log_of(made["file"]), log)
        self.done("replay", made["file"], "--verify")
        self.done("score", imported)

        first = [[log["counts"][0][0] + 1, *log["counts"][0][1:]], *log["counts"][1:]]
        for changed in ({"rows_sha1": "0" * 40}, {"counts": first}, {"outcome": "jam"}):
            refused = importing(log | changed)
            self.assertEqual((refused.returncode, refused.stdout), (3, ""), changed)
            self.assertRegex(refused.stderr, r"^ferrule: .*try.json: .*not those that were recorded.*\n$")
        for changed, key in (({"counts": [[1, 2, 3]]}, "counts"), ({"scene": {}}, "scene"), ({"format": "x"}, "format"),
                             ({"outcome": "won"}, "outcome"), ({"surplus": 1}, "surplus")):
            refused = importing(log | changed)
            self.assertEqual((refused.returncode, refused.stdout), (2, ""), changed)
            self.assertRegex(refused.stderr, rf"^ferrule: .*try.json.*{key}.*\n$")
        self.assertEqual(importing(json.dumps(log)[:-20]).returncode, 2)
        self.assertEqual(importing("").returncode, 2)
        self.assertEqual(os.listdir(imported), ["episode_0001.h5"])

    def test_another_trainee_takes_over_between_tries(self):
        process, address = self.view(*SHORT, "--trainee", "Ada")
        window = Window(address)
        self.assertEqual(window.hear_of("state_of_session", running=False)["trainee"], "Ada")
        for name in ("Ada", "Ben \u0141ukasz"):
            window.say(type="trainee", name=name)
            window.hear_of("state_of_session", trainee=name)
            _, ended = self.insert(window, ready=False)
            with h5py.File(os.path.join(self.out, ended["file"])) as file:
                self.assertEqual(file.attrs["trainee"].decode(), name)
                self.assertEqual(file.attrs["operator"].decode(), name + ", browser")
            episodes = window.hear_of("episodes")["list"]
            self.assertEqual(episodes[-1]["trainee"], name)
            window.hear_of("state_of_session", running=False, trainee=name)
        window.say(type="trainee", name="two\nlines")
        self.assertIn("one line", window.hear_of("error")["text"])
        window.say(type="start")
        window.hear_of("state_of_session", running=True)
        window.say(type="trainee", name="Cid")
        self.assertIn("stop", window.hear_of("error")["text"])
        window.say(type="stop")
        self.assertEqual(window.hear_of("state_of_session", running=False)["trainee"], name)
        self.end(process)
        scores = json.loads(self.done("score", self.out, "--json").stdout)
        self.assertEqual([g["operator"] for g in scores["groups"]], ["Ada", name])

    def test_a_page_that_is_loaded_again_loses_no_row(self):
        process, address = self.view(*SHORT)
        pages = []

        def again(window, row):
            if row[window.columns["t_s"]] < 0.3 + 0.3 * len(pages) or len(pages) > 3:
                return window
            window.close()
            pages.append(Window(address))
            pages[-1].hear_of("hello")
            return pages[-1]

        _, ended = self.insert(Window(address), again)
        self.assertGreater(len(pages), 1)
        self.end(process)
        self.done("replay", os.path.join(self.out, ended["file"]), "--verify")

    def test_a_silent_page_stops_the_hand(self):
        process, address = self.view(*SHORT)
        window = Window(address)
        window.hear_of("state_of_session")
        window.say(type="start")
        window.hear_of("state_of_session", running=True)
        begin = time.monotonic()
        while time.monotonic() < begin + 0.3:
            window.say(type="hand", v=[0, 1, 0], buttons=0, seq=1)
            time.sleep(0.01)
        time.sleep(0.8)
        window.say(type="stop")
        ended = window.hear_of("ended")
        self.end(process)
        with h5py.File(os.path.join(self.out, ended["file"])) as file:
            command = numpy.abs(file["data/demo_0/rows/command"][:, 1])
        moving = numpy.flatnonzero(command > 0)
        self.assertGreater(len(moving), 200)
        self.assertGreater(len(command) - moving[-1], 300)

    def test_discarded_tries_are_gone_and_taken_again(self):
        process, address = self.view(*SHORT)
        window = Window(address)
        start = window.hear_of("state_of_session", running=False)
        window.say(type="start")
        window.hear_of("state_of_session", running=True)
        window.say(type="discard")
        again = window.hear_of("state_of_session", running=False)
        self.assertEqual((again["episode"], again["trial"]), (start["episode"], start["trial"]))
        self.insert(window, ready=False)
        window.hear_of("state_of_session", running=False)
        window.say(type="discard")  # after the end
        window.hear_of("episodes", list=[])
        window.say(type="rate", stars=1)
        self.assertIn("no try", window.hear_of("error")["text"])
        self.end(process)
        self.assertEqual(os.listdir(self.out), [])

    # In one run: half the try without, half with a flood of everything.
    def test_a_flood_disturbs_neither_loop_nor_recording(self):
        process, address = self.view(*SHORT, "--set", "limits.time_s=6")
        over = threading.Event()

        def flood(payload):
            while not over.is_set():
                try:
                    other = Window(address, 2)
                    while not over.is_set():
                        other.write(payload)
                except OSError:
                    time.sleep(0.02)
                except EOFError:
                    pass

        payloads = [Window.frame(b'{"type":"hand","v":[1,1,1],"buttons":1,"seq":9}') * 200,
                    Window.frame(b"[" * 4000), b"\xff" * 65536, Window.frame(b"x" * 6000)]
        threads = [threading.Thread(target=flood, args=[p]) for p in payloads]
        window = Window(address)
        window.hear_of("state_of_session", running=False)
        window.say(type="start")
        window.hear_of("state_of_session", running=True)
        at = window.columns
        rows = []
        while True:
            heard = window.hear()
            if isinstance(heard, dict):
                if heard["type"] == "ended":
                    break
                continue
            if heard[0] != 2:
                continue
            rows += heard[2]
            window.say(type="hand", v=[0, 0, 0], buttons=0, seq=1)
            if rows[-1][at["t_s"]] > 3 and not threads[0].is_alive():
                for thread in threads:
                    thread.start()
        over.set()
        for thread in threads:
            thread.join()
        times = numpy.array([row[at["t_s"]] for row in rows])
        numpy.testing.assert_allclose(times, 1e-3 * numpy.arange(len(times)), atol=1e-5)
        self.assertGreater(times[-1], 5.9)
        for what, half in (("without", times < 3), ("with", times > 3.2)):
            steps = numpy.diff(numpy.array([row[at["missed"]] for row in rows])[half])
            periods = numpy.array([row[at["period_us"]] for row in rows])[half]
            print(f"{what} a flood: p50 {numpy.quantile(periods, 0.5):.0f}, p99.9 "
                  f"{numpy.quantile(periods, 0.999):.0f} us, {steps.sum():.0f} deadlines missed")
        self.end(process)
        self.done("replay", os.path.join(self.out, heard["file"]), "--verify")

    def test_ctrl_c_keeps_the_try_and_a_killed_window_is_recovered(self):
        process, address = self.view(*SHORT)
        window = Window(address)
        window.hear_of("state_of_session")
        window.say(type="start")
        window.hear_of("state_of_session", running=True)
        time.sleep(0.5)
        self.end(process)
        texts, code = window.hear_the_end()
        self.assertEqual(code, 1001)  # in order, after all that there was to say
        ended = [text for text in texts if text["type"] == "ended"]
        self.assertEqual([text["file"] for text in ended], ["episode_0001.h5"])
        with h5py.File(self.out + "/episode_0001.h5") as file:
            self.assertEqual(file.attrs["outcome"].decode(), "interrupted")
        process, address = self.view(*SHORT)
        window = Window(address)
        self.assertEqual(window.hear_of("state_of_session", running=False)["episode"], 2)
        window.say(type="start")
        window.hear_of("state_of_session", running=True)
        time.sleep(0.5)
        process.kill()
        process.wait()
        self.assertIsNone(window.hear_the_end()[1])
        self.done("recover", self.out)
        self.assertIn("identical", self.done("replay", self.out, "--verify").stdout)

    # Other users of the machine see the command lines of all programs.
    def test_the_browser_gets_the_address_in_a_file_of_the_user(self):
        self.done("record", "--episodes", 1, *SHORT, "--out", self.path("episodes"))
        with open(self.path("bin/xdg-open"), "w") as opener:
            opener.write(f'#!/bin/sh\nprintf "%s\\n" "$@" > {self.path("arguments.part")}\n'
                         f'mv {self.path("arguments.part")} {self.path("arguments")}\n')
        os.chmod(opener.name, 0o755)
        os.mkdir(self.path("tmp"))
        environment = {**os.environ, "PATH": self.path("bin") + ":" + os.environ["PATH"], "TMPDIR": self.path("tmp")}
        for what, asked in ((["--out", self.out], True), ([self.path("episodes")], True), (["--out", self.out], False)):
            process = subprocess.Popen([self.program, "view", *what], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                       text=True, env=environment, umask=0)
            self.addCleanup(process.communicate)
            self.addCleanup(process.kill)
            address = next(line.strip() for line in process.stdout if line.startswith("http://"))
            while not os.path.exists(self.path("arguments")):
                time.sleep(0.01)
            with open(self.path("arguments")) as arguments:
                [file] = arguments.read().splitlines()
            os.remove(self.path("arguments"))
            token = address.split("/")[3]
            for process_file in glob.glob("/proc/[0-9]*/cmdline"):
                try:
                    with open(process_file) as words:
                        self.assertNotIn(token, words.read())
                except (OSError, UnicodeDecodeError):
                    pass
            self.assertEqual(os.stat(file).st_mode & 0o777, 0o600)
            self.assertEqual(os.stat(os.path.dirname(file)).st_mode & 0o777, 0o700)
            with open(file) as page:
                self.assertIn(f'url={address}"', page.read())
            if asked:  # and then it is of no use
                with urllib.request.urlopen(address) as page:
                    self.assertEqual(page.status, 200)
                self.assertFalse(os.path.exists(file))
            self.end(process)
            self.assertEqual(os.listdir(self.path("tmp")), [])

    def test_with_a_device_the_page_shows(self):
        process, address = self.view(*SHORT, "--device", "fake:spacemouse")
        window = Window(address)
        self.assertIn("spacemouse", window.hear_of("hello")["device"])
        window.hear_of("state_of_session", running=False)
        window.say(type="start")
        ended = window.hear_of("ended")
        self.assertEqual(ended["outcome"], "inserted")
        self.end(process)
        self.done("replay", os.path.join(self.out, ended["file"]), "--verify")

    def test_what_cannot_be_shown(self):
        os.remove(self.path("share/ferrule/page.html"))
        self.refused(2, "view", "--port", 99999)
        self.refused(2, "view", "--no-open", "--out", self.out, "--coupled")
        built = os.path.join(os.path.dirname(os.path.dirname(PROGRAM)), "view/page.html")
        if os.path.exists(built):
            return
        run = subprocess.run([self.program, "view", "--no-open"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 2)
        self.assertIn("nodejs", run.stderr)


if __name__ == "__main__":
    main()

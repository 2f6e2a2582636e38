"""Recording, fitting and comparing against the verbs of the program."""

import json
import os
import signal
import threading
import time
from pathlib import Path

import pytest

import ferrule
from conftest import run


def test_recorded_episodes_are_those_of_the_verb_byte_for_byte(episodes, tmp_path):
    files = ferrule.record("bench", tmp_path / "again", episodes=2, skill=0.8, seed=1)
    assert [Path(file).name for file in files] == ["episode_0001.h5", "episode_0002.h5"]
    for file in files:
        assert Path(file).read_bytes() == (episodes / Path(file).name).read_bytes()
    with pytest.raises(ferrule.BadInput, match="already holds episodes"):
        ferrule.record("bench", tmp_path / "again")
    for wrong in [dict(episodes=0), dict(skill=1.5), dict(skill=float("nan"))]:
        with pytest.raises(ferrule.BadInput, match=next(iter(wrong))):
            ferrule.record("bench", tmp_path / "nothing", **wrong)
    assert not (tmp_path / "nothing").exists()
    [slow] = ferrule.record("bench", tmp_path / "slow", episodes=1, skill="0.8,slowing_force=1", seed=1)
    assert Path(slow).read_bytes() != Path(files[0]).read_bytes()


def test_pairs_that_do_not_fit_are_passed_over_in_recording_too(tmp_path):
    run("record", "--scene", "tolerance", "--episodes", 2, "--seed", 4, "--out", tmp_path / "a")
    files = ferrule.record("tolerance", tmp_path / "b", episodes=2, seed=4)
    trials = [ferrule.Episode(file).trial for file in files]
    assert trials == [ferrule.Episode(file).trial for file in sorted((tmp_path / "a").glob("*.h5"))]


def test_a_fit_is_that_of_the_verb(episodes, law, tmp_path):
    controller = ferrule.fit(episodes)
    controller.save(tmp_path / "here.json")
    assert (tmp_path / "here.json").read_bytes() == Path(law).read_bytes()
    loaded = ferrule.load(tmp_path / "here.json")
    assert loaded.gains == controller.gains and loaded.report == "" and loaded.warnings == []
    gain = controller.gains["yield_y"]
    assert gain["low"] < gain["value"] < gain["high"] and gain["unit"] == "m/(s N)"
    assert 0 < controller.residual < 0.01 and loaded.held_out_residual == controller.held_out_residual
    inside = ferrule.evaluate(controller, trials=4)
    assert (inside.peak_force_N == ferrule.evaluate(law, trials=4).peak_force_N).all()


def test_so_is_one_of_another_law_and_of_some_files(episodes, tmp_path):
    files = sorted(episodes.glob("*.h5"))[:3]
    options = ["--law", "linear", "--seed", 2, "--out", tmp_path / "verb.json"]
    said = run("fit", *files, *options).stdout
    controller = ferrule.fit(files, law="linear", seed=2)
    controller.save(tmp_path / "here.json")
    assert (tmp_path / "here.json").read_bytes() == (tmp_path / "verb.json").read_bytes()
    assert controller.report and controller.report in said
    assert controller.warnings == [
        line.removeprefix("warning: ") for line in said.splitlines() if line.startswith("warning: ")
    ]


def test_a_search_is_fitted_to_who_searches(tmp_path):
    out = tmp_path / "searched"
    run("record", "--operator", "searching", "--scene", "by_hand/sharp", "--episodes", 4, "--out", out)
    said = run("fit", out, "--method", "search", "--out", tmp_path / "verb.json").stdout
    controller = ferrule.fit(out, "search")
    controller.save(tmp_path / "here.json")
    assert (tmp_path / "here.json").read_bytes() == (tmp_path / "verb.json").read_bytes()
    assert controller.report and controller.report in said
    assert ferrule.evaluate(controller, trials=4).success_rate == 1


def test_what_cannot_be_fitted_is_refused(episodes, law, tmp_path):
    few = sorted(episodes.glob("*.h5"))[:2]
    said = run("fit", *few, "--out", tmp_path / "c.json", code=2).stderr
    with pytest.raises(ferrule.BadInput) as raised:
        ferrule.fit(few)
    assert said == f"ferrule: {raised.value}\n"
    with pytest.raises(ferrule.FileTrouble, match="nowhere"):
        ferrule.fit(tmp_path / "nowhere")
    with pytest.raises(ferrule.BadInput, match="there is no cubic; there are auto, .*linear"):
        ferrule.fit(episodes, law="cubic")
    with pytest.raises(ferrule.BadInput, match="ferrule fit --method torch.*libtorch-dev.*run everywhere"):
        ferrule.fit(episodes, "torch")
    with pytest.raises(ferrule.FileTrouble, match="cannot be written"):
        ferrule.load(law).save(tmp_path / "no folder" / "c.json")


def test_a_comparison_has_the_rows_of_the_verb(episodes, law):
    settings = ["--set", "limits.time_s=40", "--set", "limits.force_uN=50"]
    options = ["--scene", "bench", *settings, "--trials", 3, "--learners", "linear", "--json"]
    expected = json.loads(run("compare", episodes, law, *options).stdout)
    found = ferrule.compare(
        episodes, ferrule.load_scene("bench", {"limits.time_s": 40}), 3, learners=["linear"],
        controllers=[law], overrides={"limits.force_uN": 50},
    )
    for table in (expected, found):
        for row in table["rows"]:
            assert row.pop("ns_per_action") > 0
            row.pop("fit_s")
        table.pop("provenance")
    assert found == expected
    assert {"simulated operator", "ceres, linear", law} < {row["controller"] for row in found["rows"]}


def test_what_cannot_be_compared_is_refused(episodes, tmp_path):
    with pytest.raises(ferrule.BadInput, match="--learners: cubic not in"):
        ferrule.compare(episodes, learners=["cubic"])
    with pytest.raises(ferrule.FileTrouble, match="nowhere: cannot be read"):
        ferrule.compare(tmp_path / "nowhere")
    with pytest.raises(ferrule.BadInput, match="demo scales the hand otherwise"):
        ferrule.compare(episodes, "demo")


@pytest.mark.parametrize("what", ["record", "fit"])
def test_ctrl_c_ends_it(episodes, tmp_path, what):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def interrupt():
        while what == "record" and not any((tmp_path / "many").glob("*")):
            time.sleep(0.01)
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

    # An episode of "record" lasts for seconds: there is always one to interrupt.
    slow = {"limits.speed_um_s": 0.1, "limits.time_s": 3600}
    threading.Thread(target=interrupt, daemon=True).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            if what == "record":
                ferrule.record("bench", tmp_path / "many", episodes=10**6, overrides=slow)
            else:
                ferrule.fit(episodes, law="auto")
    finally:
        signal.signal(signal.SIGINT, before)
    kept = sorted((tmp_path / "many").glob("*"))
    assert what == "fit" or ferrule.Episode(kept[-1]).outcome == "interrupted"
    assert not any(file.suffix == ".part" for file in kept)

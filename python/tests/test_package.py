"""The package against the program: the same messages, trials, bits."""

import copy
import importlib.metadata
import json
import multiprocessing
import os
import pickle
import resource
import shutil
import signal
import subprocess
import sys
import threading
import types

import h5py
import numpy as np
import pytest

import ferrule
from conftest import ROOT, run


def test_a_scene_is_refused_with_the_texts_of_the_program():
    for scene, override in [
        ("demo", "ferrule.bore_diameter_um=-1"),
        ("demo", "laws.friction.burgers_nm=true"),
        ("bench", "success.depth_um=1e9"),
    ]:
        said = run("scene", "--scene", scene, "--set", override, code=2).stderr
        with pytest.raises(ferrule.BadInput) as raised:
            ferrule.validate(scene, [override])
        # But for the folder that the scene is in.
        text = str(raised.value)
        assert text[text.index(" with --set") :] in said
    with pytest.raises(ferrule.FileTrouble, match="no such scene file"):
        ferrule.load_scene("nowhere")


def test_overrides_and_documents_give_the_scene_of_the_program():
    changed = ferrule.load_scene("bench", {"ferrule.bore_diameter_um": 125.5, "laws.drag": None})
    again = ferrule.load_scene(json.loads(changed.json))
    assert changed.bore_radius == again.bore_radius == 125.5e-6 / 2
    assert again.json == changed.json


def test_an_evaluation_has_the_statistics_of_the_verb(law):
    said = json.loads(run("evaluate", law, "--trials", 12, "--seed", 3, "--json").stdout)
    inside = ferrule.evaluate(law, trials=12, seed=3)
    controller = ferrule.load(law)

    class Policy:
        def reset(self):
            controller.reset()

        def __call__(self, observation):
            return controller(observation)

    outside = ferrule.evaluate(Policy(), "bench", trials=12, seed=3)
    for key, value in inside.statistics.items():
        assert said[key] == value == outside.statistics[key]
    assert (inside.time_s == outside.time_s).all()
    said = json.loads(
        run("evaluate", law, "--trials", 6, "--supervise", "--scene", "tight", "--json").stdout
    )
    there = ferrule.evaluate(controller, "tight", trials=6, supervise=True).statistics
    assert there == {key: said[key] for key in there}


def test_another_scaling_is_refused_as_the_program_does(law):
    said = run("evaluate", law, "--scene", "demo", "--trials", 1, code=2).stderr
    controller, simulator = ferrule.load(law), ferrule.Simulator("demo")
    observation = simulator.reset()

    def answers(observation):  # a policy of one's own that asks it
        return 0.5 * controller(observation)

    for drive in [
        lambda: controller(observation),
        lambda: controller(simulator.observation),
        lambda: ferrule.evaluate(law, "demo", trials=1),
        lambda: ferrule.evaluate(answers, "demo", trials=1),
    ]:
        with pytest.raises(ferrule.BadInput, match="other_scaling = True") as raised:
            drive()
        assert str(raised.value).split("; ")[0] in said
    assert controller(ferrule.Observation([0] * 5, 0, 0)).shape == (5,)  # of no scene
    controller.other_scaling = True
    assert simulator.step(controller(observation)).time > 0
    assert len(ferrule.evaluate(answers, "demo", trials=1).outcome) == 1
    assert len(ferrule.evaluate(controller, "demo", trials=1).outcome) == 1


# Trial after trial in a simulator of `bench`, period by period.
def expect_the_same_stepped(controller, evaluation, seed):
    simulator = ferrule.Simulator("bench")
    for trial in range(len(evaluation.outcome)):
        controller.reset()
        observation = simulator.reset(seed=seed, trial=trial)
        while not simulator.ended:
            observation = simulator.step(controller(observation))
        assert simulator.ended == evaluation.outcome[trial]
        assert simulator.summary["peak_force_N"] == evaluation.peak_force_N[trial]


def test_a_stepped_trial_is_the_trial_of_the_campaign(law):
    expect_the_same_stepped(ferrule.load(law), ferrule.evaluate(law, trials=3, seed=5), seed=5)


def test_so_it_is_where_parts_and_the_entrance_are_drawn(law):
    overrides = {"sensor.entrance_sd_um": 5, "fibre.curl_radius_m": 2}
    evaluation = ferrule.evaluate(law, "bench", trials=3, seed=5, overrides=overrides)
    controller, simulator = ferrule.load(law), ferrule.Simulator("bench", overrides)
    for trial in range(3):
        controller.reset()
        observation = simulator.reset(seed=5, trial=trial)
        while not simulator.ended:
            observation = simulator.step(controller(observation))
        assert simulator.summary["time_s"] == evaluation.time_s[trial]
        assert simulator.summary["peak_force_N"] == evaluation.peak_force_N[trial]


def test_an_observation_knows_how_far_the_hand_has_gone():
    simulator = ferrule.Simulator("bench")
    start = simulator.reset(seed=1, trial=0)
    assert (start.displacement == 0).all() and start.height > 0
    seen = simulator.step([-0.004, 0.001, 0, 0, 2e-3], periods=50)
    np.testing.assert_allclose(seen.displacement, [-2e-4, 5e-5, 0, 0, 1e-4], rtol=1e-9)
    np.testing.assert_allclose(seen.height, start.height - 2e-4, rtol=1e-9)


def test_a_shipped_search_inserts_where_no_lead_in_guides_the_fibre():
    evaluation = ferrule.evaluate(ferrule.load("search"), "ladder/d", trials=4, seed=5)
    assert evaluation.statistics["successes"] == 4
    controller, simulator = ferrule.load("search"), ferrule.Simulator("ladder/d")
    observation = simulator.reset(seed=5, trial=0)
    while not simulator.ended:
        observation = simulator.step(controller(observation))
    assert simulator.summary["time_s"] == evaluation.time_s[0]


def test_the_forces_add_up_to_the_wrench_at_the_holder():
    simulator = ferrule.Simulator("bench")
    simulator.reset(seed=1, trial=0)
    for _ in range(400):
        simulator.step([-0.02, 0.001, 0, 0, 0], periods=20)
        if simulator.ended:
            break
    total = sum(simulator.forces.values())
    assert np.abs(simulator.holder_wrench[0]) > 1e-7
    # An extrapolated step may be off by 1e-5 of the force limit of 60 uN.
    np.testing.assert_allclose(total, simulator.holder_wrench[:3], rtol=0, atol=6e-10)
    assert (simulator.state[:5] == simulator.tip).all()


def test_a_scene_goes_to_other_processes():
    scene = ferrule.load_scene("bench", {"ferrule.bore_diameter_um": 125.8})
    again = pickle.loads(pickle.dumps(scene))
    assert again.json == scene.json and again.name == scene.name


AGAIN = [copy.copy, copy.deepcopy, lambda of: pickle.loads(pickle.dumps(of))]


@pytest.mark.parametrize("again", AGAIN)
def test_a_simulator_goes_the_same_way_elsewhere(again):
    assert again(ferrule.Simulator("bench", period=2e-3)).period == 2e-3
    generator = np.random.default_rng(2)
    simulator = ferrule.Simulator("tolerance")
    simulator.reset(seed=3, trial=4, feasible=True)
    for _ in range(300):
        simulator.step(generator.uniform([-4e-3, -1e-3, -1e-3, 0, 0], [0, 1e-3, 1e-3, 0, 0]), 3)
    other = again(simulator)
    assert other.trial == simulator.trial and other.summary == simulator.summary
    for s in (simulator, other):
        s.step([-2e-3, 0, 0, 0, 0])
    assert (other.state == simulator.state).all()
    assert (other.observation.values == simulator.observation.values).all()
    simulator.step([np.nan] * 5)
    assert again(simulator).ended == "invalid_output" and other.ended is None
    seen = again(simulator.observation)
    assert (seen.displacement == simulator.observation.displacement).all()
    assert seen.height == simulator.observation.height
    assert (ferrule.load("constant-velocity")(seen) == ferrule.load("constant-velocity")(simulator.observation)).all()


@pytest.mark.parametrize("again", AGAIN)
def test_episodes_and_controllers_go_to_other_processes(again, episodes, law, monkeypatch):
    file = sorted(episodes.glob("*.h5"))[0]
    monkeypatch.chdir(episodes)
    episode = ferrule.Episode(file.name)
    monkeypatch.chdir("/")
    other = again(episode)
    assert (other.wrench == episode.wrench).all() and other.seed == episode.seed
    simulator = ferrule.Simulator("bench")
    for name in (law, "search", "tuned_by_hand", "spiral", ferrule.fit(episodes)):
        controller = ferrule.load(name) if isinstance(name, str) else name
        controller.other_scaling = True
        other = again(controller)
        assert other.gains == controller.gains and other.scene_json == controller.scene_json
        assert other.other_scaling and other.report == controller.report
        assert other.residual == controller.residual or np.isnan(controller.residual)
        for c in (controller, other):
            seen = simulator.reset(seed=7, trial=0)
            for _ in range(500):
                seen = simulator.step(c(seen))
            if c is controller:
                state = simulator.state
        assert (simulator.state == state).all()


@pytest.mark.parametrize("name", ["constant-velocity", "spiral", "searching-operator", "search"])
def test_controllers_without_a_file_are_those_of_the_program(name):
    found = json.loads(run("evaluate", name, "--scene", "bench", "--trials", 3, "--json").stdout)
    statistics = ferrule.evaluate(name, "bench", trials=3).statistics
    assert statistics["outcomes"] == found["outcomes"]
    controller = ferrule.load(name)
    results = ferrule.evaluate(controller, "bench", trials=3)
    assert results.statistics == statistics
    expect_the_same_stepped(controller, results, seed=7)
    if name != "search":
        assert controller.gains == {} and controller.scene_json is None and np.isnan(controller.residual)
        with pytest.raises(ferrule.BadInput, match="no file"):
            controller.save("nowhere.json")
        with pytest.raises(ferrule.BadInput, match="Simulator"):
            ferrule.load(name)(ferrule.Observation([0] * 5, 0, 0))


def test_a_controller_that_is_not_there_is_named():
    with pytest.raises(ferrule.FileTrouble, match="did you mean constant-velocity"):
        ferrule.load("constant_velocity")
    with pytest.raises(ferrule.BadInput, match="TorchScript"):
        ferrule.load("policy.pt")


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.float16, np.int64, np.uint16, int])
def test_numbers_of_numpy_are_numbers(kind):
    wide = kind(127)
    expected = ferrule.load_scene("bench", {"ferrule.bore_diameter_um": 127})
    assert ferrule.load_scene("bench", {"ferrule.bore_diameter_um": wide}).bore_radius == expected.bore_radius
    drawn = {"fibre.diameter_um": {"uniform": np.array([124, 125], dtype=kind)}}
    ferrule.load_scene("bench", drawn)
    document = json.loads(expected.json)
    document["ferrule"]["bore_diameter_um"] = wide
    assert ferrule.load_scene(types.MappingProxyType(document)).bore_radius == expected.bore_radius
    simulator = ferrule.Simulator("bench", period=kind(1))
    for velocity in (np.zeros(5, dtype=kind), [kind(0)] * 5, np.zeros(10, dtype=kind)[::2]):
        simulator.reset()
        simulator.step(velocity)
    assert ferrule.forces("bench", gap_nm=kind(10), tilt_mrad=kind(0), speed_um_s=kind(5))["gravity"].shape == ()
    if not issubclass(kind, np.floating):
        simulator.step(velocity, periods=kind(2))
        assert len(ferrule.evaluate("search", "bench", trials=kind(2), seed=kind(3), threads=kind(1)).outcome) == 2


def test_whole_numbers_are_expected_where_they_are():
    for wrong in (1.5, "3", None, -1, 2**64, np.float64(2)):
        with pytest.raises(ferrule.BadInput, match="trials.*whole number"):
            ferrule.evaluate("search", "bench", trials=wrong)
        with pytest.raises(ferrule.BadInput, match="seed.*whole number"):
            ferrule.Simulator("bench").reset(seed=wrong)
        with pytest.raises(ferrule.BadInput, match="episodes.*whole number"):
            ferrule.record("bench", "nowhere", episodes=wrong)
    with pytest.raises(ferrule.BadInput, match="JSON"):
        ferrule.load_scene("bench", {"ferrule.bore_diameter_um": object()})


def test_names_that_are_no_utf_8_are_names(tmp_path, episodes, law):
    odd = os.fsdecode(os.fsencode(tmp_path) + b"/of M\xfcller")
    shutil.copytree(episodes, odd)
    file = os.path.join(odd, "episode_0001.h5")
    assert len(ferrule.Episode(file)) and pickle.loads(pickle.dumps(ferrule.Episode(file))).seed == 1
    shutil.copy(law, os.path.join(odd, "law.json"))
    assert ferrule.evaluate(os.path.join(odd, "law.json"), trials=1).outcome
    assert ferrule.fit(odd).gains
    with open(os.path.join(odd, "scene.json"), "w") as scene:
        scene.write(ferrule.load_scene("bench").json)
    assert ferrule.load_scene(os.path.join(odd, "scene.json")).name == "bench"
    with pytest.raises(ferrule.FileTrouble, match="M.ller/none.h5"):
        ferrule.Episode(os.path.join(odd, "none.h5"))


def test_a_file_of_bytes_is_refused_in_words(tmp_path):
    (tmp_path / "scene.json").write_bytes(b"\x89HDF\xff\x1b[2J")
    for read in (ferrule.load_scene, ferrule.load):
        with pytest.raises(ferrule.BadInput, match="not valid JSON"):
            read(str(tmp_path / "scene.json"))


def test_force_curves_are_those_of_the_verb():
    gaps = [1.0, 5.0, 50.0]
    rows = json.loads(run("forces", "--scene", "paper", "--gap-nm", "1:50:2", "--json").stdout)[
        "rows"
    ]
    found = ferrule.forces("paper", gap_nm=[1.0, 50.0])
    for name in ferrule.terms:
        assert list(1e6 * found[name]) == [row[name + "_uN"] for row in rows]
    assert ferrule.forces("paper", gap_nm=np.ones((2, 1)), length_um=gaps)["gravity"].shape == (2, 3)
    with pytest.raises(ferrule.BadInput, match="the smallest gap is at most the clearance"):
        ferrule.forces("bench", gap_nm=1e6)
    with pytest.raises(ferrule.BadInput, match="must be numbers"):
        ferrule.forces("bench", gap_nm=float("nan"))


def test_episodes_are_views_of_what_the_file_holds(episodes):
    file = sorted(episodes.glob("*.h5"))[0]
    episode = ferrule.Episode(file)
    with h5py.File(file) as f:
        demo = f["data/demo_0"]
        for name in ["time", "hand_pose", "hand_velocity", "command", "holder_wrench", "forces"]:
            assert (demo["rows"][name][:] == getattr(episode, name)).all()
        assert (demo["states"][:] == episode.states).all()
        assert (demo["obs/wrench_N"][:] == episode.wrench.astype(np.float32)).all()
    assert not episode.command.flags.owndata and not episode.command.flags.writeable
    assert np.shares_memory(episode.forces, episode.force("wall"))
    assert (episode.relative_wrench[0] == 0).all()
    command = episode.command
    del episode
    assert np.isfinite(command).all()  # the rows live as long as a view of them
    with pytest.raises(ferrule.FileTrouble, match="no such file"):
        ferrule.Episode("nowhere.h5")
    with pytest.raises(ferrule.FileTrouble, match="not a readable HDF5 file"):
        ferrule.Episode(__file__)


def test_what_a_step_is_given_is_checked():
    simulator = ferrule.Simulator("bench")
    with pytest.raises(RuntimeError, match="reset it first"):
        simulator.step([0] * 5)
    simulator.reset()
    for wrong in [[0] * 4, np.zeros((5, 1)), np.zeros(6), "fast", None]:
        with pytest.raises(ValueError, match="expected 5 numbers"):
            simulator.step(wrong)
    simulator.step([np.nan, 0, 0, 0, 0])
    assert simulator.ended == "invalid_output"
    with pytest.raises(RuntimeError, match="has ended"):
        simulator.step([0] * 5)


def test_what_a_policy_raises_ends_the_evaluation():
    with pytest.raises(ZeroDivisionError):
        ferrule.evaluate(lambda observation: 1 / 0, trials=3)
    with pytest.raises(ValueError, match="expected 5 numbers, got 2"):
        ferrule.evaluate(lambda observation: [1, 2], trials=3)
    with pytest.raises(TypeError, match="a callable"):
        ferrule.evaluate(3)
    nothing = ferrule.evaluate(lambda observation: [np.nan] * 5, trials=3)
    assert nothing.outcome == ["invalid_output"] * 3


def test_ctrl_c_ends_an_evaluation(law):
    # What is started in the background of a script ignores it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            ferrule.evaluate(law, trials=10**6)
    finally:
        signal.signal(signal.SIGINT, before)


def test_python_runs_while_the_evaluation_does(law):
    ticks, over = [], threading.Event()

    def tick():
        while not over.wait(0.001):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    ferrule.evaluate(law, trials=40)
    over.set()
    thread.join()
    assert len(ticks) > 10


def _rate(law):
    return ferrule.evaluate(law, trials=4).success_rate


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
@pytest.mark.parametrize("how", ["fork", "spawn"])
def test_processes_that_are_forked_or_spawned_evaluate_too(law, how):
    here = _rate(law)  # oneTBB has its threads before the fork
    with multiprocessing.get_context(how).Pool(2) as pool:
        assert pool.map(_rate, [law, law]) == [here, here]


def test_resets_leak_nothing():
    simulator = ferrule.Simulator("bench")

    def resets(count):
        for trial in range(count):
            simulator.reset(seed=1, trial=trial)
            simulator.step([0.0] * 5)
            simulator.forces, simulator.observation.values
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = resets(2000)
    assert resets(100_000) - before < 2000  # kB: 20 bytes a reset


def test_everything_public_is_in_all():
    assert ferrule.__all__ == sorted(ferrule.__all__)
    here = {
        name for name, value in vars(ferrule).items()
        if not name.startswith("_") and str(getattr(value, "__module__", "")).startswith("ferrule")
    }
    assert here <= set(ferrule.__all__) <= set(dir(ferrule))


def test_the_metadata_are_those_of_the_citation():
    cited = (ROOT / "CITATION.cff").read_text()
    stated = importlib.metadata.metadata("ferrule")
    assert f'- name: "{stated["Author"]}"' in cited and f"version: {stated['Version']}\n" in cited
    keywords = stated["Keywords"].split(",")
    assert keywords and all(f"  - {keyword}\n" in cited for keyword in keywords)
    assert set(stated.get_all("Provides-Extra")) == {"gym", "data", "plot"}


def test_importing_needs_neither_numpy_nor_gymnasium():
    code = (
        "import sys, ferrule; assert not {'numpy', 'gymnasium'} & set(sys.modules);"
        "import gymnasium; gymnasium.spec('ferrule/Insertion-v0')"
    )
    subprocess.run([sys.executable, "-c", code], check=True)

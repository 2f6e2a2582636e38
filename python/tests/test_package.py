"""The package against the program: the same messages, trials, bits."""

import importlib.metadata
import json
import multiprocessing
import os
import pickle
import resource
import signal
import subprocess
import sys
import threading

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


def test_a_stepped_trial_is_the_trial_of_the_campaign(law):
    evaluation = ferrule.evaluate(law, trials=3, seed=5)
    controller, simulator = ferrule.load(law), ferrule.Simulator("bench")
    for trial in range(3):
        controller.reset()
        observation = simulator.reset(seed=5, trial=trial)
        while not simulator.ended:
            observation = simulator.step(controller(observation))
        assert simulator.ended == evaluation.outcome[trial]
        assert simulator.summary["peak_force_N"] == evaluation.peak_force_N[trial]


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

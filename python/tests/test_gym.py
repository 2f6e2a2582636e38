"""The Gymnasium environments."""

import copy
import csv
import http.client
import importlib.metadata
import itertools
import os
import pickle
import sys
import time
import zlib
from urllib.parse import urlsplit

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.utils.env_checker import check_env

import ferrule
from conftest import run
from ferrule.insertion_env import InsertionEnv


def make(**arguments):
    return gymnasium.make("ferrule/Insertion-v0", scene="bench", **arguments).unwrapped


def straight(speed=1.0):
    return np.array([-speed, 0, 0, 0, 0], dtype=np.float32)


def test_gymnasium_has_no_complaint():
    check_env(make(control_hz=50, render_mode="rgb_array"))


def test_the_space_is_what_the_scene_lets_happen():
    for scene, relative in [("bench", True), ("demo", False), ("dry", True)]:
        env = gymnasium.make(
            "ferrule/Insertion-v0", scene=scene, control_hz=200, relative=relative
        ).unwrapped
        most = np.zeros(7)
        generator = np.random.default_rng(3)
        for trial in range(8):
            env.reset(seed=7, options={"trial": trial})
            for step in itertools.count():
                if step % 100 == 0:
                    action = generator.uniform([-1, -0.4, -0.4, -1, -1], [-0.4, 0.4, 0.4, 1, 1])
                _, _, terminated, truncated, _ = env.step(action)
                if terminated or truncated:
                    break
                raw = env.simulator.observation.values  # as it is, not cut
                raw[:5] = raw[:5] if relative else env.simulator.wrench
                most = np.maximum(most, np.abs(raw * [1, 1, 1, 1, 1, 1e3, 1]))
        share = most / env.observation_space.high
        assert (share <= 1).all(), (scene, share)
        assert share[:3].max() > 0.25 and share[5] > 0.5 and share[6] > 0.05, (scene, share)
        assert (env.observation_space.low[:5] == -env.observation_space.high[:5]).all()


@pytest.mark.filterwarnings("ignore:.*different from the unwrapped version")
def test_a_wrapper_that_normalises_finds_its_bounds():
    env = gymnasium.make("ferrule/Insertion-v0", scene="bench", control_hz=50)
    scaled = gymnasium.wrappers.RescaleObservation(env, np.float32(-1), np.float32(1))
    check_env(scaled, skip_render_check=True)
    many = gymnasium.make_vec("ferrule/Insertion-v0", num_envs=4, scene="bench", control_hz=50)
    low, high = many.single_observation_space.low, many.single_observation_space.high
    assert np.isfinite([low, high]).all()
    assert (low == env.observation_space.low).all() and (high == env.observation_space.high).all()
    many = gymnasium.wrappers.vector.RescaleObservation(many, np.float32(-1), np.float32(1))
    seen = [many.reset(seed=7)[0]]
    ended = np.zeros(4, dtype=bool)
    while not ended.all():
        observation, _, terminated, truncated, _ = many.step(np.tile(straight(), (4, 1)))
        seen.append(observation)
        ended |= terminated | truncated
    assert np.abs(seen).max() <= 1 + 1e-6
    assert np.abs(seen)[..., 0].max() > 0.5  # pushed to the force limit


def test_straight_in_is_the_baseline_of_the_program():
    env, baseline = make(control_hz=1000), ferrule.evaluate("constant-velocity", "bench", 5, seed=7)
    observation, info = env.reset(seed=7)
    for trial in range(5):
        assert info["trial"] == trial
        total, over = 0.0, False
        while not over:
            observation, reward, terminated, truncated, info = env.step(straight())
            assert env.observation_space.contains(observation)
            total, over = total + reward, terminated or truncated
        assert info["outcome"] == baseline.outcome[trial]
        assert info["peak_force_N"] == baseline.peak_force_N[trial]
        assert terminated and not truncated
        # The way into the bore adds up to 1, success to 2.
        assert (total > 1.99) if info["is_success"] else (total < 0.9)
        observation, info = env.reset()


def test_time_that_runs_out_truncates():
    env = make(overrides={"limits.time_s": 0.1})
    env.reset(seed=1)
    over = False
    while not over:
        _, reward, terminated, truncated, info = env.step(np.zeros(5, dtype=np.float32))
        over = terminated or truncated
    assert truncated and not terminated and info["outcome"] == "timeout" and abs(reward) < 0.1


def test_seeds_and_options_choose_the_trial():
    env = make()
    tips = [env.reset(seed=3)[1]["tip"], env.reset()[1]["tip"]]
    again = [env.reset(seed=3)[1]["tip"], env.reset(options={"trial": 1})[1]["tip"]]
    assert (np.array(tips) == np.array(again)).all() and (tips[0] != tips[1]).any()
    simulator = ferrule.Simulator("bench")
    simulator.reset(seed=3, trial=1)
    assert (simulator.tip == tips[1]).all()
    with pytest.raises(ValueError, match="whole number"):
        env.reset(options={"trial": -1})


def test_values_of_the_scene_change_for_an_episode():
    env = make()
    env.reset(seed=3, options={"set": {"start.tilt_sd_mrad": {"uniform": [2, 3]}}})
    other = ferrule.Simulator("bench", ["start.tilt_sd_mrad=2..3"])
    other.reset(seed=3, trial=0)
    for _ in range(20):
        env.step(straight())
        other.step(env.task.velocity(straight()), env.task.periods)
    assert (env.simulator.tip == other.tip).all()
    env.reset(seed=3)
    plain = ferrule.Simulator("bench")
    plain.reset(seed=3, trial=0)
    assert (env.simulator.observation.values == plain.observation.values).all()
    for _ in range(20):
        env.step(straight())
    assert (env.simulator.tip != other.tip).any()
    with pytest.raises(ValueError, match="changes force_limit"):
        env.reset(options={"set": {"limits.force_uN": 5}})
    with pytest.raises(ferrule.BadInput, match="fibre.young_GPa"):
        env.reset(options={"set": {"fibre.young_GPa": {"uniform": [80, 60]}}})
    # Refused: the episode before goes on.
    env.step(straight())


def test_pairs_that_do_not_fit_are_passed_over():
    env = gymnasium.make("ferrule/Insertion-v0", scene="tolerance").unwrapped
    env.reset(seed=7)
    for _ in range(50):
        env.reset()
        assert not env.step(np.zeros(5, dtype=np.float32))[2]


def test_actions_are_cut_and_checked():
    env = make()
    env.reset(seed=1)
    env.step(straight(1.0))
    once = env.simulator.tip
    env.reset(seed=1)
    env.step(straight(100.0))
    assert (env.simulator.tip == once).all()
    with pytest.raises(ValueError, match=r"expected shape \(5,\)"):
        env.step(np.zeros(4))
    _, reward, terminated, _, info = env.step(np.full(5, np.nan))
    assert terminated and info["outcome"] == "invalid_output" and reward == -1
    with pytest.raises(ResetNeeded):
        env.step(straight())
    env.close()
    with pytest.raises(ClosedEnvironmentError):
        env.reset()
    for wrong in [dict(control_hz=300), dict(control_hz=0), dict(action_scale=[1, 1])]:
        with pytest.raises(ValueError, match=next(iter(wrong))):
            make(**wrong)
    with pytest.raises(ValueError, match="render_mode 'ansi'"):
        InsertionEnv("bench", render_mode="ansi")


def test_its_own_motion_is_that_of_the_holder():
    env = make(overrides={"hand.gain": 1.25}, action_scale=[1e-5] * 3 + [2e-3] * 2, motion=True)
    check_env(make(motion=True), skip_render_check=True)
    observation, _ = env.reset(seed=3)
    start = 1e3 * 250 * env.task.scene.start_distance
    np.testing.assert_allclose(observation[7:], [0, 0, 0, 0, 0, start], atol=1e-12)
    for _ in range(10):
        observation = env.step(np.array([-1, 0.5, 0, 1, -0.25]))[0]
    moved = 1.25 * 0.2 * np.array([-2.5, 1.25, 0, 2, -0.5])  # [mm, mrad]
    np.testing.assert_allclose(observation[7:12], moved, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(observation[12], start + moved[0], rtol=1e-6)
    assert env.observation_space.contains(observation) and observation.shape == (13,)


def test_many_at_once_are_one_after_another():
    task = {"control_hz": 20, "motion": True}
    many = gymnasium.make_vec("ferrule/Insertion-v0", num_envs=3, scene="bench", **task)
    one = make(**task)
    generator = np.random.default_rng(1)
    observations, info = many.reset(seed=5)
    rows = [[o] for o in observations]
    actions = [[] for _ in range(3)]
    ends = [None] * 3
    while None in ends:
        action = generator.uniform(-1, 0.2, (3, 5)).astype(np.float32)
        observations, rewards, terminated, truncated, info = many.step(action)
        for i in range(3):
            if ends[i] is None:
                rows[i].append(observations[i])
                actions[i].append((action[i], rewards[i]))
                if terminated[i] or truncated[i]:
                    ends[i] = info["outcome"][i]
    for i in range(3):
        observation, _ = one.reset(seed=5, options={"trial": i})
        assert (observation == rows[i][0]).all()
        for (action, reward), expected in zip(actions[i], rows[i][1:]):
            observation, found, _, _, info = one.step(action)
            assert (observation == expected).all() and found == reward
        assert info["outcome"] == ends[i]


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_threads_and_forks_change_nothing():
    action = np.tile(straight(0.5), (5, 1))

    def steps(many):
        return np.concatenate([many.reset(seed=2)[0]] + [many.step(action)[0] for _ in range(30)])

    def made(threads):
        return gymnasium.make_vec("ferrule/Insertion-v0", num_envs=5, scene="bench", threads=threads)

    alone, many = steps(made(1)), made(3)
    assert (steps(many) == alone).all() and (steps(made(0)) == alone).all()
    child = os.fork()
    if child == 0:  # without the threads of its parent, and it ends nevertheless
        same = (steps(many) == alone).all() and (steps(made(3)) == alone).all()
        del many
        os._exit(0 if same else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_an_ended_one_begins_anew_in_the_next_step():
    many = gymnasium.make_vec(
        "ferrule/Insertion-v0", num_envs=2, scene="bench", overrides={"limits.time_s": 0.05}
    )
    many.reset(seed=1)
    action = np.zeros((2, 5), dtype=np.float32)
    for _ in range(10):
        _, _, _, truncated, _ = many.step(action)
        if truncated.any():
            break
    observations, rewards, terminated, truncated, info = many.step(action)
    assert (observations[:, 6] == 0).all() and (rewards == 0).all() and not truncated.any()
    assert info["trial"].tolist() == [2, 3]
    with pytest.raises(ValueError, match=r"expected shape \(2, 5\)"):
        many.step(np.zeros((3, 5)))
    many.close()
    with pytest.raises(ClosedEnvironmentError):
        many.reset()


def test_one_that_ends_as_it_begins_says_so_in_its_first_step():
    overrides = {"fibre.curl_radius_m": 1}  # it touches the ferrule's face where it starts
    one = gymnasium.make("ferrule/Insertion-v0", scene="paper", overrides=overrides).unwrapped
    many = gymnasium.make_vec("ferrule/Insertion-v0", num_envs=6, scene="paper", overrides=overrides)
    many.reset(seed=3)
    still = np.zeros((6, 5), dtype=np.float32)
    ended = many.step(still)[2]
    at_once = []
    for trial in range(6):
        _, info = one.reset(seed=3, options={"trial": trial})
        at_once.append("outcome" in info)
        assert one.step(still[0])[2] == ended[trial]
    assert any(at_once) and (ended[at_once]).all()
    _, rewards, terminated, _, _ = many.step(still)
    assert (rewards[ended] == 0).all() and not terminated[ended].any()


def test_the_picture_shows_the_fibre():
    env = make(render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    for _ in range(300):
        env.step(straight(0.5))
    later = env.render()
    assert first.shape == (360, 480, 3) and first.dtype == np.uint8
    fibre = (np.array([70, 130, 200]) == first).all(axis=2)
    assert 0.1 < fibre.mean() < 0.9 and (first != later).any()


def served(address, path="", host=None):
    url = urlsplit(address)
    connection = http.client.HTTPConnection(url.netloc, timeout=20)
    connection.request("GET", url.path + path, headers={"Host": host} if host else {})
    return connection.getresponse()


def test_the_window_shows_the_pictures_as_they_come(monkeypatch, capfd):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    env = make(render_mode="human", control_hz=50)
    drawn = make(render_mode="rgb_array", control_hz=50)
    env.reset(seed=1), drawn.reset(seed=1)
    address = capfd.readouterr().err.split()[-1]
    assert b'<img src="pictures"' in served(address).read()
    assert served(address, "elsewhere").status == 404
    assert served(address, host="elsewhere.org").status == 403
    pictures = served(address, "pictures")
    begin = time.monotonic()
    for _ in range(25):
        env.step(straight()), drawn.step(straight())
    assert time.monotonic() - begin > 0.45  # in time, not faster
    assert env.render() is None
    env.close()
    parts = pictures.read().split(b"--next\r\n")[1:-1]  # ends, for the window was closed
    assert len(parts) > 1
    head, data = parts[-1].split(b"\r\n\r\n", 1)
    assert b"image/png" in head and data[:8] == b"\x89PNG\r\n\x1a\n"
    lines = np.frombuffer(zlib.decompress(data[41 : data.index(b"IEND") - 8]), dtype=np.uint8)
    assert (lines.reshape(360, -1)[:, 1:].reshape(360, 480, 3) == drawn.render()).all()


def test_a_policy_of_the_environment_is_a_program_for_evaluate(tmp_path):
    script, table = tmp_path / "policy.py", tmp_path / "trials.csv"
    script.write_text(
        "import sys, numpy as np\n"
        "from ferrule.policy_program import answer\n"
        "def act(observation):  # yields to what it feels, not far\n"
        "    return np.array([-0.7, *(0.3 * observation[1:3] - 0.1 * observation[8:10]), 0, 0])\n"
        "answer({'scene': 'bench', 'control_hz': 20, 'relative': len(sys.argv) == 1,\n"
        "        'motion': True}, act)\n"
    )
    command = f"{sys.executable} {script}"
    run("evaluate", "--scene", "bench", "--policy", command, "--policy-hz", 20, "--trials", 4,
        "--trials-out", table)
    with open(table) as rows:
        found = list(csv.DictReader(line for line in rows if not line.startswith("#")))
    env = make(control_hz=20, motion=True)
    observation, info = env.reset(seed=7)
    for trial in range(4):
        over = False
        while not over:
            action = np.array([-0.7, *(0.3 * observation[1:3] - 0.1 * observation[8:10]), 0, 0])
            observation, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
        assert found[trial]["outcome"] == info["outcome"]
        assert float(found[trial]["peak_force_uN"]) == pytest.approx(1e6 * info["peak_force_N"], rel=1e-12)
        observation, info = env.reset()
    said = run("evaluate", "--scene", "bench", "--policy", f"{command} absolute", "--trials", 1,
               code=2)
    assert "relative = False" in said.stderr


def many_of(count=3, **arguments):
    return gymnasium.make_vec("ferrule/Insertion-v0", num_envs=count, scene="bench", **arguments)


def test_gymnasium_has_no_complaint_of_many():
    many = many_of(3)
    observations, info = many.reset(seed=3, options={})
    assert many.observation_space.contains(observations)
    assert many.metadata["autoreset_mode"] == gymnasium.vector.AutoresetMode.NEXT_STEP
    counted = gymnasium.wrappers.vector.RecordEpisodeStatistics(many)
    counted.reset(seed=3)
    counted.reset(options={"reset_mask": np.array([True, False, True])})
    assert counted.episode_lengths.tolist() == [0, 0, 0]
    each = gymnasium.wrappers.vector.DictInfoToList(many)
    each.reset(seed=3)
    ended = []
    while not ended:
        _, _, terminated, truncated, infos = each.step(np.tile(straight(), (3, 1)))
        ended = [info for info in infos if "outcome" in info]
        assert len(ended) == (terminated | truncated).sum()
    assert all(set(info) >= {"tip", "seed", "trial", "is_success"} for info in ended)


@pytest.mark.parametrize("kind", [int, np.int64, np.uint8, np.int32])
def test_seeds_and_trials_are_whole_numbers_of_anybody(kind):
    one, many = make(), many_of(2)
    expected = one.reset(seed=3, options={"trial": 5})[0]
    assert (one.reset(seed=kind(3), options={"trial": kind(5)})[0] == expected).all()
    assert (many.reset(seed=kind(3), options={"trial": kind(5)})[0][0] == expected).all()
    simulator = ferrule.Simulator("bench")
    assert (simulator.reset(seed=kind(3), trial=kind(5)).values == one.simulator.observation.values).all()


def test_each_of_many_has_its_own_seed():
    many, one = many_of(3), make()
    observations, info = many.reset(seed=[7, 3, np.int64(9)])
    assert info["seed"].tolist() == [7, 3, 9] and info["trial"].tolist() == [0, 0, 0]
    for i, seed in enumerate((7, 3, 9)):
        assert (one.reset(seed=seed)[0] == observations[i]).all()
    again, info = many.reset()  # each takes the next one of its own
    assert info["trial"].tolist() == [1, 1, 1]
    assert (one.reset()[0] == again[2]).all()
    info = many.reset(seed=[None, 4, None])[1]
    assert info["seed"].tolist() == [7, 4, 9] and info["trial"].tolist() == [2, 0, 2]
    info = many.reset(seed=5)[1]
    assert info["seed"].tolist() == [5, 5, 5] and info["trial"].tolist() == [0, 1, 2]
    for wrong in ([1, 2], [1, 2, -3], [1, 2, 3.5], "abc", 1.5, -1):
        with pytest.raises(ValueError, match="seed"):
            many.reset(seed=wrong)
    assert many_of(3).reset(seed=[1, None, 2])[1]["seed"].tolist()[::2] == [1, 2]


def test_options_choose_trials_and_values_of_many():
    many, one = many_of(3), make()
    info = many.reset(seed=3, options={"trial": 10})[1]
    assert info["trial"].tolist() == [10, 11, 12]
    assert many.reset()[1]["trial"].tolist() == [13, 14, 15]
    assert many.reset(options={"trial": [8, np.int64(2), 2**63]})[1]["trial"].tolist() == [8, 2, 2**63]
    assert many.reset(seed=[1, 2, 3], options={"trial": 4})[1]["trial"].tolist() == [4, 4, 4]
    options = {"trial": 6, "set": {"start.tilt_sd_mrad": {"uniform": [2, 3]}}}
    observations, info = many.reset(seed=3, options=options)
    for i in range(3):
        expected, its = one.reset(seed=3, options={**options, "trial": 6 + i})
        assert (observations[i] == expected).all() and (info["tip"][i] == its["tip"]).all()
    tips = many.reset(seed=3, options={"trial": 6})[1]["tip"]
    assert (tips != info["tip"]).any(axis=1).all()  # for that episode alone
    with pytest.raises(ValueError, match="changes force_limit"):
        many.reset(options={"set": {"limits.force_uN": 5}})


def test_a_mask_resets_some_and_leaves_the_others_where_they_are():
    many, other = many_of(4), many_of(4)
    action = np.tile(straight(0.5), (4, 1))
    for envs in (many, other):
        envs.reset(seed=3)
        for _ in range(5):
            seen = envs.step(action)[0]
    mask = np.array([False, True, False, True])
    options = {"reset_mask": mask, "trial": 20}
    observations, info = many.reset(seed=8, options=options)
    assert set(options) == {"reset_mask", "trial"}
    assert (observations[~mask] == seen[~mask]).all()
    assert info["trial"].tolist() == [0, 21, 2, 23] and info["seed"].tolist() == [3, 8, 3, 8]
    assert info["_trial"].tolist() == info["_tip"].tolist() == mask.tolist()
    fresh = make()
    assert (fresh.reset(seed=8, options={"trial": 23})[0] == observations[3]).all()
    for _ in range(5):
        ours, theirs = many.step(action)[0], other.step(action)[0]
    assert (ours[~mask] == theirs[~mask]).all() and (ours[mask] != theirs[mask]).any()
    for wrong in ([True], np.ones(4), np.zeros(4, dtype=bool), "all"):
        with pytest.raises(ValueError, match="reset_mask"):
            many.reset(options={"reset_mask": wrong})
    with pytest.raises(ResetNeeded, match="reset_mask"):
        many_of(4).reset(options={"reset_mask": mask})


def test_a_mask_takes_the_place_of_the_next_step():
    many = many_of(3, overrides={"limits.time_s": 0.1}, control_hz=50)
    still = np.zeros((3, 5), dtype=np.float32)
    many.reset(seed=3)
    while not many.step(still)[3].all():
        pass
    info = many.reset(options={"reset_mask": np.array([True, False, False])})[1]
    assert info["trial"].tolist() == [3, 1, 2] and "outcome" not in info
    observations, rewards, _, truncated, info = many.step(still)
    assert info["trial"].tolist() == [3, 4, 5]
    assert observations[:, 6].tolist() == pytest.approx([0.02, 0, 0]) and not truncated.any()


def test_unknown_options_are_refused():
    for env in (make(), many_of(2)):
        for options, says in (({"trail": 3}, "did you mean 'trial'"), ({"sets": {}}, "did you mean 'set'"),
                              ({"seed": 3}, "unknown"), ([3], "dictionary"), ({"trial": -1}, "whole number"),
                              ({"trial": 1.5}, "whole number"), ({"trial": 2**64}, "whole number")):
            with pytest.raises(ValueError, match=says):
                env.reset(seed=1, options=options)
    with pytest.raises(ValueError, match="reset_mask.*unknown"):
        make().reset(options={"reset_mask": np.array([True])})


def test_threads_are_as_many_as_there_can_be():
    for threads in (4096, 7):
        many_of(8, threads=threads).reset(seed=1)
        assert ferrule.evaluate("constant-velocity", "bench", 4, threads=threads).outcome
    for threads in (2**31 - 1, 2**31, 2**70, -1, 1.5, None):
        with pytest.raises(ValueError, match="threads"):
            ferrule.evaluate("constant-velocity", "bench", 2, threads=threads)
        with pytest.raises(ValueError, match="threads"):
            many_of(2, threads=threads)
    for count in (0, -1, 2**40):
        with pytest.raises(ValueError, match="num_envs"):
            many_of(count)


AGAIN = [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))]


@pytest.mark.parametrize("again", AGAIN)
def test_a_copy_goes_the_same_way_and_its_own(again):
    generator = np.random.default_rng(4)
    actions = generator.uniform(-1, 0.2, (40, 5)).astype(np.float32)
    env = gymnasium.make("ferrule/Insertion-v0", scene="bench", motion=True, render_mode="rgb_array")
    other = again(env)
    env.reset(seed=3, options={"set": {"start.tilt_sd_mrad": 2}})
    other.reset(seed=5)
    for action in actions[:20]:
        env.step(action)
    other = again(env.unwrapped)
    for action in actions[20:]:
        expected, found = env.step(action), other.step(action)
        assert (expected[0] == found[0]).all() and expected[1:4] == found[1:4]
        assert (expected[4]["tip"] == found[4]["tip"]).all()
    assert (env.render() == other.render()).all()
    assert (env.reset()[0] == other.reset()[0]).all()
    other.step(actions[0])
    assert env.unwrapped.simulator.observation.time == 0  # each its own
    assert other.action_space is not env.unwrapped.action_space


@pytest.mark.parametrize("again", AGAIN)
def test_a_copy_of_many_goes_the_same_way(again):
    generator = np.random.default_rng(4)
    many = many_of(3, control_hz=10, overrides={"limits.time_s": 2})
    again(many).reset(seed=1)
    many.reset(seed=[3, 4, 5])
    for n in range(60):  # past ends
        action = generator.uniform(-1, 0.2, (3, 5)).astype(np.float32)
        if n == 30:
            many.reset(seed=1, options={"reset_mask": np.array([False, True, False]),
                                        "set": {"start.lateral_sd_um": 3}})
        if n in (5, 21, 30, 40):
            other = again(many)
        expected = many.step(action)
        if n < 5:
            continue
        found = other.step(action)
        for a, b in zip(expected[:4], found[:4]):
            assert (a == b).all()
        assert expected[4].keys() == found[4].keys() and (expected[4]["tip"] == found[4]["tip"]).all()
    many.close()
    with pytest.raises(ClosedEnvironmentError):
        again(many).reset()


def test_gymnasium_before_1_0_finds_it_by_its_entry_point():
    [found] = [e for e in importlib.metadata.entry_points(group="gymnasium.envs") if e.dist.name == "ferrule"]
    gymnasium.registry.pop("ferrule/Insertion-v0")
    found.load()()
    assert "ferrule/Insertion-v0" in gymnasium.registry and make().reset(seed=1)

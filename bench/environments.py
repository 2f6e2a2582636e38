"""What a simulated second costs: a campaign of the program, the Gymnasium environments, and a peg in a hole of MuJoCo.

    ./ferrule test --long    makes build/learners-env
    build/learners-env/bin/python bench/environments.py [--seconds 300]

All in turns in one process, constant velocity in the scene bench, three rounds; the least time of each counts.
"""

import argparse
import time

import gymnasium
import numpy as np

import ferrule

HZ = 50
STRAIGHT = np.array([-1, 0, 0, 0, 0], dtype=np.float32)


def campaign(seconds: float, threads: int) -> float:
    """Simulated seconds of so many trials; each takes some 5 s."""
    trials = max(4, round(seconds / 5))
    return float(ferrule.evaluate("constant-velocity", "bench", trials, threads=threads).time_s.sum())


def one(seconds: float) -> float:
    env = gymnasium.make("ferrule/Insertion-v0", scene="bench", control_hz=HZ)
    env.reset(seed=7)
    for _ in range(round(HZ * seconds)):
        _, _, terminated, truncated, _ = env.step(STRAIGHT)
        if terminated or truncated:
            env.reset()
    return seconds


def many(seconds: float, threads: int, count: int = 16) -> float:
    """Until so many insertions have ended as in the campaign, twice as many as there are environments at least."""
    envs = gymnasium.make_vec(
        "ferrule/Insertion-v0", num_envs=count, scene="bench", control_hz=HZ, threads=threads
    )
    envs.reset(seed=7)
    actions = np.tile(STRAIGHT, (count, 1))
    steps = ended = 0
    while ended < max(2 * count, round(seconds / 5)):
        _, _, terminated, truncated, _ = envs.step(actions)
        over = int(np.sum(terminated | truncated))
        ended += over
        steps += count - over  # these are reset in the next step
    envs.close()
    return steps / HZ


def peg_of_mujoco(seconds: float) -> float:
    env = gymnasium.make(
        "Meta-World/MT1", env_name="peg-insert-side-v3", seed=1, disable_env_checker=True
    )
    env.reset()
    action = env.action_space.sample()
    dt = env.unwrapped.dt
    for _ in range(round(seconds / dt)):
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    tried = {
        "campaign, one thread": lambda s: campaign(s, 1),
        "campaign, all threads": lambda s: campaign(2 * s, 0),
        f"ferrule/Insertion-v0 at {HZ} Hz": one,
        "16 of them in C++, one thread": lambda s: many(s, 1),
        "16 of them in C++, all threads": lambda s: many(2 * s, 0),
    }
    try:
        import metaworld  # noqa: F401

        tried["Meta-World peg-insert-side (MuJoCo)"] = lambda s: peg_of_mujoco(s / 20)
    except ImportError:
        print("Meta-World is not installed: its row is left out")
    cost = dict.fromkeys(tried, np.inf)
    for _ in range(arguments.rounds):
        for name, run in tried.items():
            begin = time.perf_counter()
            simulated = run(arguments.seconds)
            cost[name] = min(cost[name], (time.perf_counter() - begin) / simulated)
    for name, seconds in cost.items():
        print(f"{name:40} {1e3 * seconds:8.2f} ms for a simulated second")


if __name__ == "__main__":
    main()

"""PPO of Stable-Baselines3, unmodified, on ferrule/Insertion-v0: learns in minutes on two cores.

    python sb3_ppo.py [--steps N] [--seed N]

prints the success of constant velocity and of what was learned on the same trials.
"""

import argparse
import time

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecNormalize

import ferrule

# Sideways slower than inwards, as a hand is, and hardly any tilt: what is drawn to explore breaks no fibre then.
TASK = {"scene": "bench", "control_hz": 10, "action_scale": [3e-5, 1e-5, 1e-5, 1e-6, 1e-6]}


def make(**arguments) -> gymnasium.Env:
    """Failure costs what is not earned any more, and nothing else: or it is safest to wait at the entrance."""
    env = gymnasium.make("ferrule/Insertion-v0", **arguments)
    return gymnasium.wrappers.TransformReward(env, lambda reward: max(reward, -0.1))


def success(env: gymnasium.Env, act, trials: int, seed: int) -> float:
    inserted = 0
    observation, info = env.reset(seed=seed)
    for _ in range(trials):
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(act(observation))
            over = terminated or truncated
        inserted += info["is_success"]
        observation, info = env.reset()
    return inserted / trials


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=60_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--trials", type=int, default=100)
    arguments = parser.parse_args()

    torch.set_num_threads(1)  # more only wait for one another: the networks are small
    envs = VecNormalize(
        make_vec_env(make, n_envs=8, seed=arguments.seed, env_kwargs=TASK), norm_reward=False
    )
    model = PPO(
        "MlpPolicy", envs, n_steps=256, batch_size=256, n_epochs=10, gamma=0.995, learning_rate=1e-3,
        policy_kwargs={"net_arch": [32, 32], "log_std_init": -1.0}, seed=arguments.seed, device="cpu",
    )
    begin = time.monotonic()
    model.learn(arguments.steps)
    took = time.monotonic() - begin
    envs.training = False

    def learned(observation: np.ndarray) -> np.ndarray:
        return model.predict(envs.normalize_obs(observation), deterministic=True)[0]

    env = gymnasium.make("ferrule/Insertion-v0", **TASK)
    straight = np.array([-1, 0, 0, 0, 0], dtype=np.float32)
    before = success(env, lambda observation: straight, arguments.trials, 7)
    after = success(env, learned, arguments.trials, 7)
    print(f"trained {arguments.steps} steps in {took:.0f} s")
    print(f"inserted of {arguments.trials} trials: constant velocity {before:.0%}, learned {after:.0%}")
    if after <= before:
        raise SystemExit("it learned nothing")


if __name__ == "__main__":
    main()

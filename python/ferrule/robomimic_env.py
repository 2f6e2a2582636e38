"""ferrule/Insertion-v0 for robomimic, which speaks the Gym of before 0.26: gym.make imports this."""

from __future__ import annotations

from typing import Any

import gym
import numpy as np

from .insertion_env import InsertionEnv


class RobomimicInsertion(gym.Env):
    """step gives four values, reset the observation alone; further arguments as of InsertionEnv.

    ``seed``: rollouts take the trials under it, from 0 on.
    """

    metadata = {"render_modes": ["rgb_array"], "render.modes": ["rgb_array"]}

    def __init__(self, seed: int = 0, **arguments: Any) -> None:
        self.inner = InsertionEnv(render_mode="rgb_array", **arguments)
        box, actions = self.inner.observation_space, self.inner.action_space
        self.observation_space = gym.spaces.Box(box.low, box.high, dtype=box.dtype)
        self.action_space = gym.spaces.Box(actions.low, actions.high, dtype=actions.dtype)
        self._seed: int | None = seed
        self._inserted = False

    def reset(self, **ignored: Any) -> np.ndarray:
        observation, _ = self.inner.reset(seed=self._seed)
        self._seed, self._inserted = None, False
        return observation

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, dict[str, Any]]:
        observation, reward, terminated, truncated, info = self.inner.step(action)
        self._inserted = info.get("is_success", False)
        return observation, reward, terminated or truncated, info

    def render(self, mode: str = "rgb_array", **ignored: Any) -> np.ndarray | None:
        return self.inner.render()

    def close(self) -> None:
        self.inner.close()

    def _check_success(self) -> dict[str, bool]:
        return {"task": self._inserted}


gym.register(
    id="Insertion-v0",
    entry_point="ferrule.robomimic_env:RobomimicInsertion",
    disable_env_checker=True,
)

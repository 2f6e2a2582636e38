"""Many fibres at once: gymnasium.make_vec("ferrule/Insertion-v0", num_envs=N)."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ClosedEnvironmentError, ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import SceneLike, _core, outcomes
from .task import TIMEOUT, Task

_COLUMN = {name: i for i, name in enumerate(_core._trial_columns)}


class InsertionVectorEnv(VectorEnv):
    """N environments as InsertionEnv, stepped in C++ on all cores.

    Further arguments: ``num_envs``; ``threads``, 0 for all cores. Under one seed, environment i
    begins with trial i and goes on with trial i + N, i + 2 N ...: all of them together take the
    trials that one environment takes after one another. An environment whose episode has ended
    begins the next one in the step after that, whatever its action (AutoresetMode.NEXT_STEP).
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        scene: SceneLike = "bench",
        *,
        render_mode: str | None = None,
        threads: int = 0,
        **task: Any,
    ) -> None:
        if render_mode is not None:
            raise ValueError("render_mode: many fibres are not drawn; make one environment")
        self.num_envs = num_envs
        self.render_mode = None
        self.task = Task(scene, **task)
        self.single_observation_space = self.task.observation_space
        self.single_action_space = self.task.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._trials = _core._Trials(self.task.scene, num_envs, self.task.periods, threads)
        self._seed: int | None = None
        self._ended: np.ndarray | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        self._expect_open("reset")
        if seed is not None or self._seed is None:
            self._np_random, drawn = gymnasium.utils.seeding.np_random(seed)
            self._seed = int(self._np_random.integers(2**31)) if seed is None else int(seed)
            first = np.arange(self.num_envs)
        else:
            first = self._trial.astype(np.int64) + self.num_envs
        rows = self._trials.reset(self._seed, first.tolist())
        return self._take(rows, np.ones(self.num_envs, dtype=bool)), self._info(rows)

    def step(
        self, actions: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        self._expect_open("step")
        if self._ended is None:
            raise ResetNeeded("step: call reset first")
        velocity = self.task.velocity(actions)
        if velocity.shape != (self.num_envs, 5):
            raise ValueError(
                f"actions: expected shape ({self.num_envs}, 5), got {velocity.shape}"
            )
        again, before = self._ended, self._tip
        rows = self._trials.step(np.ascontiguousarray(velocity), again)
        observation = self._take(rows, again)
        reward = self.task.reward(before, self._tip, self._outcome)
        reward[again] = 0.0
        truncated = self._outcome == TIMEOUT
        terminated = self._ended != truncated
        return observation, reward, terminated, truncated, self._info(rows)

    def close_extras(self, **kwargs: Any) -> None:
        self._trials = None

    def _expect_open(self, what: str) -> None:
        if self.closed or self._trials is None:
            raise ClosedEnvironmentError(f"{what}: the environment was closed")

    def _take(self, rows: np.ndarray, begun: np.ndarray) -> np.ndarray:
        self._tip = rows[:, _COLUMN["tip_x"]]
        self._outcome = rows[:, _COLUMN["outcome"]].astype(np.int64)
        self._outcome[begun] = -1  # one that ends as it begins says so in its first step
        self._ended = self._outcome >= 0
        self._trial = rows[:, _COLUMN["trial"]]
        motion = rows[:, _COLUMN["displacement_x"] : _COLUMN["height"] + 1]
        return self.task.observation(rows[:, :7], rows[:, 7:12], motion)

    def _info(self, rows: np.ndarray) -> dict[str, Any]:
        info: dict[str, Any] = {
            "inserted_length_m": np.maximum(0.0, -self._tip),
            "peak_force_N": rows[:, _COLUMN["peak_force"]],
            "trial": self._trial.astype(np.int64),
        }
        if self._ended.any():
            info["outcome"] = np.array(
                [outcomes[o] if o >= 0 else None for o in self._outcome], dtype=object
            )
            info["_outcome"] = self._ended.copy()
        return info

"""The Gymnasium environment ferrule/Insertion-v0."""

from __future__ import annotations

import time
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ClosedEnvironmentError, ResetNeeded

from . import SceneLike, Simulator, _whole, outcomes
from .picture import picture
from .task import PERIOD, TIMEOUT, Task, checked_options, trial_number
from .window import Window


class InsertionEnv(gymnasium.Env):
    """A fibre is inserted into a bore by the velocity of the hand that holds it.

    Arguments: ``scene`` and ``overrides`` as of ferrule.load_scene; ``control_hz``, how often it is
    acted, of which 1000 is a whole multiple; ``action_scale``, the velocity at the tip for actions
    of 1: x, y, z [m/s], tilts [rad/s], unless given the scene's speed limit and 1 mrad/s;
    ``relative``, whether the observed wrench is relative to that at rest, as a controller's is;
    ``motion``, whether the holder's own motion is observed too, as a stage's encoders tell it.

    Observation (7,), float32, what a controller gets to know, in the hand's world: wrench at the
    holder as the force sensor reads it, Fx Fy Fz [N], My Mz [N m]; depth of the hand past the
    entrance [mm]; time [s]. Its space has the scene's limits (Scene.observation_limits): the force
    limit, the depth at success, the longest trial. What exceeds them is cut to them: the last
    observation of an episode that a limit ended, or a rare error of the sensor. With ``motion``
    six more, (13,): the holder's displacement since the start, x, y, z [mm], tilts [mrad], and its
    height before the entrance [mm], < 0 past it; within the whole way and 20 mrad.
    Action (5,) within [-1, 1], times ``action_scale``; more is cut, and a translation faster than
    the scene's speed limit is slowed to it. One that is not a number ends the episode.
    Reward: the tip's way into the bore, as part of all of it (which adds up to 1); 1 more where it
    is inserted; -1 where the insertion fails.
    ``render_mode``: "rgb_array", pictures; "human", the same in a page of the browser, in time.
    Terminated by success and by failures (force limit, jam, missed, buckled, broken, an action that
    is no number), truncated where the scene's time runs out.
    ``info``: what no controller knows: tip (5,) [m, rad], inserted_length_m, peak_force_N, trial,
    seed, and "outcome" (and "is_success") at the end.

    ``reset(seed=N)`` begins with trial 0 of the trials that ``ferrule evaluate --seed N`` runs, and
    every further reset takes the next one; ``options={"trial": K}`` takes trial K. Parts that do
    not fit are passed over. Without any seed it is drawn. ``options={"set": {"fibre.diameter_um":
    125.3}}`` changes values of the scene for this episode; they may be drawn, as in a scene:
    ``{"uniform": [124.7, 125.3]}``.
    """

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 50}

    def __init__(
        self, scene: SceneLike = "bench", *, render_mode: str | None = None, **task: Any
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode {render_mode!r}: expected None, 'rgb_array' or 'human'")
        self.render_mode = render_mode
        self.task = Task(scene, **task)
        self.observation_space = self.task.observation_space
        self.action_space = self.task.action_space
        self.metadata = {**self.metadata, "render_fps": round(1 / (self.task.periods * PERIOD))}
        self._scene = self.task.scene
        self.simulator: Simulator | None = Simulator(self._scene)
        self._seed: int | None = None
        self._next = 0
        self._running = False
        self._window: Window | None = None
        self._shown = 0.0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        options = checked_options(options, ("set", "trial"))
        trial = trial_number(options["trial"]) if options.get("trial") is not None else None
        seed = None if seed is None else _whole("seed", seed)
        super().reset(seed=seed)
        simulator = self._open("reset")
        if seed is not None or self._seed is None:
            self._seed = int(self.np_random.integers(2**31)) if seed is None else seed
            self._next = 0
        if trial is None:
            trial = self._next
        settings = options.get("set")
        if settings or self._scene is not self.task.scene:
            self._scene = self.task.changed(settings) if settings else self.task.scene
            simulator = self.simulator = Simulator(self._scene)
        simulator.reset(seed=self._seed, trial=trial, feasible=True)
        self._next = trial + 1
        self._running = True
        self._tip = simulator.tip
        self._show()
        return self._observation(), self._info()

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        simulator = self._open("step")
        if not self._running:
            raise ResetNeeded("step: the episode has ended, or none has begun: call reset first")
        action = np.asarray(action)
        if action.shape != (5,):
            raise ValueError(f"action: expected shape (5,), got {action.shape}")
        if not simulator.ended:  # as a fibre may have that does not hang free at the start
            simulator.step(self.task.velocity(action), self.task.periods)
        before, self._tip = self._tip[0], simulator.tip
        outcome = outcomes.index(simulator.ended) if simulator.ended else -1
        self._running = outcome < 0
        reward = float(self.task.reward(before, self._tip[0], outcome))
        truncated = outcome == TIMEOUT
        terminated = outcome >= 0 and not truncated
        self._show()
        return self._observation(), reward, terminated, truncated, self._info()

    def render(self) -> np.ndarray | None:
        simulator = self._open("render")
        if self.render_mode is None:
            gymnasium.logger.warn("render: the environment was made without render_mode")
            return None
        if self.render_mode == "human":
            return None  # step and reset have shown it
        return picture(self._scene, simulator.tip, simulator.observation)

    def _show(self) -> None:
        """In the window, in time: a second of it takes a second."""
        if self.render_mode != "human":
            return
        simulator = self._open("show")
        if self._window is None:
            self._window = Window()
        self._window.show(picture(self._scene, simulator.tip, simulator.observation))
        due = self._shown + self.task.periods * PERIOD
        self._shown = max(due, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))

    def close(self) -> None:
        self.simulator = None
        if self._window is not None:
            self._window.close()
            self._window = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_window": None}  # a copy opens its own

    def _open(self, what: str) -> Simulator:
        if self.simulator is None:
            raise ClosedEnvironmentError(f"{what}: the environment was closed")
        return self.simulator

    def _observation(self) -> np.ndarray:
        simulator = self._open("observe")
        seen = simulator.observation
        motion = np.append(seen.displacement, seen.height) if self.task.motion else None
        return self.task.observation(seen.values, simulator.wrench, motion)

    def _info(self) -> dict[str, Any]:
        simulator = self._open("info")
        summary = simulator.summary
        info: dict[str, Any] = {
            "tip": self._tip,
            "inserted_length_m": max(0.0, -float(self._tip[0])),
            "peak_force_N": summary["peak_force_N"],
            "trial": simulator.trial,
            "seed": self._seed,
        }
        if simulator.ended:
            info["outcome"] = simulator.ended
            info["is_success"] = simulator.ended == "inserted"
        return info

"""What the single and the vector environment share: the spaces, the scale of actions, rewards."""

from __future__ import annotations

import difflib
from typing import Any, Mapping, Sequence

import numpy as np
from gymnasium import spaces

from . import Scene, SceneLike, Overrides, _whole, load_scene, outcomes

#: What an observation is, in units of order one; all in the hand's world.
OBSERVATION = ("Fx [N]", "Fy [N]", "Fz [N]", "My [N m]", "Mz [N m]", "depth [mm]", "time [s]")
#: In SI units to those.
OBSERVATION_UNITS = np.array([1, 1, 1, 1, 1, 1e3, 1.0])
#: And where it knows its own motion: of the holder since the start, and before the entrance.
MOTION = ("x [mm]", "y [mm]", "z [mm]", "tilt about y [mrad]", "tilt about z [mrad]", "height [mm]")
MOTION_UNIT = 1e3
_MOST_TILT = 20.0  # of the space [mrad]
INSERTED = outcomes.index("inserted")
TIMEOUT = outcomes.index("timeout")
PERIOD = 1e-3  # of the simulation [s]
# What an outcome adds to the reward; the last is that of none.
_OF_THE_END = np.array([{INSERTED: 1.0, TIMEOUT: 0.0}.get(o, -1.0) for o in range(len(outcomes))] + [0.0])


def checked_options(options: Any, known: Sequence[str]) -> Mapping[str, Any]:
    """Those of a reset. Raises ValueError where one is not ``known``."""
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise ValueError(f"options = {options!r}: expected a dictionary")
    for key in options:
        if key not in known:
            meant = difflib.get_close_matches(str(key), known, 1)
            near = f": did you mean {meant[0]!r}?" if meant else ""
            raise ValueError(f"options[{key!r}] is unknown; known here: {', '.join(known)}{near}")
    return options


def trial_number(trial: Any) -> int:
    return _whole("options['trial']", trial)


class Task:
    """A scene as a task: see InsertionEnv for its arguments."""

    def __init__(
        self,
        scene: SceneLike = "bench",
        overrides: Overrides = None,
        control_hz: float = 50,
        action_scale: Sequence[float] | None = None,
        relative: bool = True,
        motion: bool = False,
    ) -> None:
        self.scene: Scene = load_scene(scene, overrides)
        periods = 1 / (control_hz * PERIOD) if control_hz > 0 else 0
        if abs(periods - round(periods)) > 1e-9 * max(periods, 1) or round(periods) < 1:
            raise ValueError(f"control_hz = {control_hz}: 1000 must be a whole multiple of it")
        self.periods = round(periods)
        self.relative = bool(relative)
        self.motion = bool(motion)
        if action_scale is None:
            action_scale = [self.scene.speed_limit] * 3 + [1e-3] * 2
        scale = np.asarray(action_scale, dtype=float)
        if scale.shape != (5,) or not np.all(np.isfinite(scale) & (scale > 0)):
            raise ValueError("action_scale: expected 5 numbers above 0 (3 [m/s], 2 [rad/s])")
        self.action_scale = scale
        # Velocities of the hand for actions of 1.
        self.hand_scale = scale * np.array([self.scene.motion_scale] * 3 + [1.0] * 2)
        self.way = self.scene.start_distance + self.scene.success_depth
        self._most = self.scene.observation_limits * OBSERVATION_UNITS
        self._least = np.where(np.arange(7) < 5, -self._most, 0.0)
        if motion:
            way = MOTION_UNIT * self.scene.motion_scale * self.way
            most = np.array([way, way, way, _MOST_TILT, _MOST_TILT, way])
            self._most, self._least = np.append(self._most, most), np.append(self._least, -most)
        self.observation_space = spaces.Box(
            self._least.astype(np.float32), self._most.astype(np.float32), dtype=np.float32
        )
        self.action_space = spaces.Box(-1.0, 1.0, (5,), np.float32)

    def changed(self, overrides: Overrides) -> Scene:
        """The scene with other values, for one episode."""
        scene = load_scene(self.scene, overrides)
        for name in ("speed_limit", "force_limit", "time_limit", "motion_scale", "force_scale",
                     "start_distance", "success_depth"):
            if getattr(scene, name) != getattr(self.scene, name):
                raise ValueError(
                    f"options['set'] changes {name}, of which spaces and rewards are made: make "
                    "another environment with overrides"
                )
        return scene

    def velocity(self, action: Any) -> np.ndarray:
        """Of the hand [m/s, rad/s]; what is not a number stays none."""
        return np.minimum(np.maximum(np.asarray(action, dtype=float), -1), 1) * self.hand_scale

    def observation(
        self, values: np.ndarray, wrench: np.ndarray, motion: np.ndarray | None = None
    ) -> np.ndarray:
        """Of (..., 7) in SI units, the wrench that is not relative to rest (..., 5), and the
        displacement and the height of the holder (..., 6).

        Cut to the space: what ends an episode may exceed the limits.
        """
        observed = values * OBSERVATION_UNITS
        if not self.relative:
            observed[..., :5] = wrench
        if self.motion:
            assert motion is not None
            observed = np.concatenate([observed, motion * MOTION_UNIT], axis=-1)
        np.minimum(observed, self._most, out=observed)
        return np.maximum(observed, self._least, out=observed).astype(np.float32)

    def reward(self, before: Any, after: Any, outcome: Any) -> Any:
        """Of tips at x [m] before and after, and of outcomes by their number, -1 where none."""
        return (before - after) / self.way + _OF_THE_END[outcome]

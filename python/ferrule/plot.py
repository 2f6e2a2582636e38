"""Plots by matplotlib, which ``pip install "ferrule[plot]"`` brings: each returns its figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from . import Episode, Evaluation, SceneLike

__all__ = ["episode", "evaluation", "forces"]


def _panels(rows: int, columns: int, size: tuple[float, float], **more: Any) -> tuple[Figure, Any]:
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError('ferrule.plot needs matplotlib: pip install "ferrule[plot]"') from error
    return pyplot.subplots(rows, columns, figsize=size, layout="constrained", **more)


def episode(episode: Episode) -> Figure:
    """A recorded insertion over time: the tip's depth, what the hand feels, the forces at the tip."""
    import numpy as np

    from . import load_scene, terms

    figure, (depth, felt, acting) = _panels(3, 1, (8, 8), sharex=True)
    scene = load_scene(episode.scene)
    depth.plot(episode.time, -1e6 * episode.states[:, 0])
    depth.axhline(1e6 * scene.success_depth, color="grey", linestyle="--", label="success")
    depth.set(ylabel="tip past the entrance [µm]", title=f"{scene.name}: {episode.outcome}")
    for axis, force in zip("xyz", episode.relative_wrench.T):
        felt.plot(episode.time, force, label=f"$F_{axis}$", linewidth=0.8)
    felt.set(ylabel="force on the hand [N]")
    for term in terms:
        size = 1e6 * np.linalg.norm(episode.force(term), axis=1)
        if size.max() > 0:
            acting.plot(episode.time, size, label=term.replace("_", " "), linewidth=0.8)
    acting.set(xlabel="time [s]", ylabel="force at the tip [µN]")
    for axes in (depth, felt, acting):
        axes.legend(loc="upper left", fontsize="small")
    return figure


def evaluation(result: Evaluation) -> Figure:
    """How the trials ended, and how long and how hard those of each outcome were."""
    import numpy as np

    s = result.statistics
    figure, (ends, each) = _panels(1, 2, (10, 4))
    for name in sorted(set(result.outcome), key=lambda name: (name != "inserted", name)):
        ended = np.array(result.outcome) == name
        ends.bar_label(ends.bar(name.replace("_", " "), ended.sum()))
        each.scatter(result.time_s[ended], 1e6 * result.peak_force_N[ended], s=8,
                     label=name.replace("_", " "))
    ends.margins(y=0.1)
    ends.set(ylabel="trials", title=f"{s['successes']} of {s['feasible']} inserted "
             f"(95 %: {100 * s['wilson_low']:.1f} to {100 * s['wilson_high']:.1f} %)")
    each.set(xlabel="time [s]", ylabel="largest force [µN]")
    each.legend(fontsize="small")
    return figure


def forces(scene: SceneLike = "demo", gap_nm: Any = None, **more: Any) -> Figure:
    """The size of each force over the gap, as ferrule.forces has them; ``more`` are its arguments.

    ``gap_nm``: None takes 1 nm to the clearance of the scene.
    """
    import numpy as np

    from . import forces as forces_at
    from . import load_scene

    if gap_nm is None:
        loaded = load_scene(scene, more.get("overrides"))
        clearance = 1e9 * (loaded.bore_radius - loaded.fibre_radius)
        gap_nm = np.geomspace(1, clearance, 200)
    figure, axes = _panels(1, 1, (8, 5))
    for name, force in forces_at(scene, gap_nm, **more).items():
        if np.any(force):
            axes.loglog(gap_nm, 1e6 * np.abs(force), label=name.replace("_", " "))
    axes.set(xlabel="smallest gap [nm]", ylabel="size of the force [µN]")
    axes.legend(fontsize="small", ncols=2)
    return figure

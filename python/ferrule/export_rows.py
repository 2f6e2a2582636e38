"""Episodes row by row: as CSV, and as MCAP for Foxglove."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Iterator

import numpy as np

from . import BadInput, Episode, terms
from .demonstrations import episode_files

_POSE = ("x", "y", "z", "tilt_y", "tilt_z")
_WRENCH = ("Fx_N", "Fy_N", "Fz_N", "My_Nm", "Mz_Nm")


def _units(length: str, angle: str) -> list[str]:
    return [f"{name}_{angle if name.startswith('tilt') else length}" for name in _POSE]


def groups(episode: Episode) -> dict[str, dict[str, np.ndarray]]:
    """The columns of an episode, each (N,), in groups; all but tip and forces in the hand's world."""

    def columns(names: list[str] | tuple[str, ...], values: np.ndarray) -> dict[str, np.ndarray]:
        return {name: values[:, i] for i, name in enumerate(names)}

    force = [f"{term}_{axis}_N" for term in terms for axis in "xyz"]
    return {
        "hand": columns(_units("m", "rad"), episode.hand_pose),
        "command": columns(_units("m_s", "rad_s"), episode.command),
        "wrench": columns(_WRENCH, episode.wrench),
        "relative_wrench": columns(_WRENCH, episode.relative_wrench),
        "displacement": columns(_units("m", "rad"), episode.displacement),
        "depth": {"m": episode.depth},
        "height": {"m": episode.height},
        "tip": columns(_units("m", "rad"), episode.states[:, :5]),
        "force": columns(force, episode.forces),
    }


def _chosen(episode: Episode, file: Path, rate: float) -> slice:
    periods = 1 / (rate * episode.period) if rate > 0 else 0
    if round(periods) < 1 or abs(periods - round(periods)) > 1e-6 * periods:
        raise BadInput(
            f"--rate {rate:g}: {1 / episode.period:g} rows a second, as {file} has, must be a whole "
            "multiple of it"
        )
    return slice(None, None, round(periods))


def _each(source: str, rate: float | None) -> Iterator[tuple[str, Episode, slice]]:
    for file in episode_files(source):
        episode = Episode(file)
        yield file.stem, episode, _chosen(episode, file, rate or 1 / episode.period)


def _field(text: str) -> str:
    """As a field of CSV; one that a spreadsheet would compute is marked as a text."""
    if text.startswith(("=", "+", "-", "@", "\t", "\r")):
        text = "'" + text
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"\r\n') else text


def write_csv(folder: str, source: str, rate: float | None) -> int:
    """One file of each episode, whatever its outcome; returns how many."""
    count = 0
    for name, episode, rows in _each(source, rate):
        table = {"time_s": episode.time}
        for group, columns in groups(episode).items():
            table.update({f"{group}_{column}": v for column, v in columns.items()})
        values = np.column_stack([v[rows] for v in table.values()])
        phases = {phase: _field(phase) for _, phase in episode.phases}
        # The mark by which spreadsheets know UTF-8, where there is more than ASCII.
        encoding = "utf-8" if "".join(phases).isascii() else "utf-8-sig"
        with open(Path(folder) / f"{name}.csv", "x", encoding=encoding, newline="") as out:
            out.write(",".join([*table, "phase"]) + "\n")
            for row, phase in zip(values, episode.phase[rows].tolist()):
                out.write(",".join(map(repr, row.tolist())) + f",{phases.get(phase, '')}\n")
        count += 1
    return count


def write_mcap(folder: str, source: str, rate: float | None) -> int:
    """One file of each episode, a topic of each group in JSON; returns how many."""
    from mcap.writer import Writer

    count = 0
    for name, episode, rows in _each(source, rate):
        with open(Path(folder) / f"{name}.mcap", "xb") as stream:
            writer = Writer(stream)
            writer.start(profile="", library="ferrule")
            writer.add_metadata(
                "episode",
                {"scene": episode.scene_json, "operator": episode.operator,
                 "outcome": episode.outcome, "seed": str(episode.seed), "trial": str(episode.trial)},
            )
            _add_messages(writer, episode, rows)
            writer.finish()
        count += 1
    return count


def _add_messages(writer: object, episode: Episode, rows: slice) -> None:
    time = np.round(1e9 * episode.time[rows]).astype(np.int64).tolist()
    channels = []
    for group, columns in {**groups(episode), "phase": {"name": episode.phase}}.items():
        kind = "string" if group == "phase" else "number"
        schema = {
            "type": "object",
            "title": group,
            "properties": {column: {"type": kind} for column in columns},
        }
        schema_id = writer.register_schema(
            name=f"ferrule.{group}", encoding="jsonschema", data=json.dumps(schema).encode()
        )
        channel = writer.register_channel(
            topic=f"/{group}", message_encoding="json", schema_id=schema_id
        )
        values = np.column_stack([v[rows] for v in columns.values()]).tolist()
        channels.append((channel, list(columns), values))
    for n, at in enumerate(time):
        for channel, names, values in channels:
            writer.add_message(
                channel_id=channel,
                log_time=at,
                publish_time=at,
                sequence=n,
                data=json.dumps(dict(zip(names, values[n]))).encode(),
            )

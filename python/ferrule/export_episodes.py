"""``ferrule export-episodes``: recorded episodes in the formats of others."""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import sys
from pathlib import Path
from typing import Any, Callable

from . import BadInput, FileTrouble, __version__, export_lerobot, export_robomimic, export_rows
from .demonstrations import Demonstrations, load_demonstrations, printable


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="ferrule export-episodes", allow_abbrev=False)
    parser.add_argument("folder", metavar="DIR")
    for option in ("robomimic", "lerobot", "csv", "mcap"):
        parser.add_argument(f"--{option}", default="")
    parser.add_argument("--rate", type=float, default=None)
    parser.add_argument("--relative", action="store_true")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _runs(process: str) -> bool:
    try:
        os.kill(int(process), 0)
    except ProcessLookupError:
        return False
    except (OverflowError, PermissionError):
        pass
    return True


def _remove_left(target: Path) -> None:
    """What exports of ``target`` that were killed left beside it."""
    ours = re.compile(re.escape(f".{target.name}.") + r"([1-9][0-9]*)")
    for path in target.parent.iterdir():
        found = ours.fullmatch(path.name)
        if found and not path.is_symlink() and not _runs(found[1]):
            _remove(path)


def _whole(place: str, write: Callable[[str], Any]) -> Any:
    """What ``write`` makes beside ``place``, which gets its name when it is whole."""
    target = Path(place)
    _remove_left(target)
    beside = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        made = write(str(beside))
        os.replace(beside, target)
        return made
    except OSError as error:
        if isinstance(error, FileTrouble):
            raise
        raise FileTrouble(f"{place}: cannot be written: {error.strerror or error}") from error
    finally:
        _remove(beside)


def _expect_no_episode(place: str, folder: str) -> None:
    for episode in Path(folder).glob("*.h5"):
        if Path(place).exists() and episode.exists() and episode.samefile(place):
            raise BadInput(f"{place}: would replace {episode}, which is read; choose another name")


def _expect_places(a: argparse.Namespace) -> None:
    if not (a.robomimic or a.lerobot or a.csv or a.mcap):
        raise BadInput(
            "export-episodes: give --robomimic FILE.h5, --lerobot DIR, --csv DIR or --mcap DIR"
        )
    for place in filter(None, (a.robomimic, a.lerobot, a.csv, a.mcap)):
        parent = Path(place).absolute().parent
        if not parent.is_dir():
            raise FileTrouble(f"{place}: there is no folder {parent}")
        if place == a.robomimic:
            _expect_no_episode(place, a.folder)
            continue
        if not Path(place).exists():
            continue
        if not Path(place).is_dir():
            raise FileTrouble(f"{place}: is there, and no folder")
        if there := next(Path(place).iterdir(), None):
            raise FileTrouble(f"{place}: is there, and not empty ({there.name})")


def _into_folder(write: Callable[..., int], source: str, rate: float | None) -> Callable[[str], int]:
    def make(folder: str) -> int:
        Path(folder).mkdir()
        return write(folder, source, rate)

    return make


def _facts(found: Demonstrations) -> dict[str, Any]:
    return {
        "demonstrations": len(found.demonstrations),
        "rows": sum(len(d.action) for d in found.demonstrations),
        "rate_hz": found.rate,
        "left_out": found.left_out,
        "action_scale": found.environment["action_scale"],
    }


def _export(a: argparse.Namespace) -> dict[str, Any]:
    _expect_places(a)
    result: dict[str, Any] = {"folder": a.folder, "written": []}
    if a.robomimic or a.lerobot:
        found = load_demonstrations(a.folder, 20 if a.rate is None else a.rate, a.relative, _tell)
        result.update(_facts(found))
        if a.robomimic:
            _whole(a.robomimic, lambda place: export_robomimic.write(place, found))
            result["written"].append(a.robomimic)
        if a.lerobot:
            _whole(a.lerobot, lambda place: export_lerobot.write(place, found))
            result["written"].append(a.lerobot)
    for place, write in ((a.csv, export_rows.write_csv), (a.mcap, export_rows.write_mcap)):
        if place:
            result["episodes"] = _whole(place, _into_folder(write, a.folder, a.rate))
            result["written"].append(place)
    return result


def _tell(done: int, of: int) -> None:
    if sys.stderr.isatty():
        print(f"\rreading {done} of {of}", end="\n" if done == of else "", file=sys.stderr)


def _stop(number: int, frame: object) -> None:
    raise KeyboardInterrupt("Ctrl-C" if number == signal.SIGINT else signal.Signals(number).name)


def main() -> int:
    for ending in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(ending) != signal.SIG_IGN:
            signal.signal(ending, _stop)
    a = _arguments()
    try:
        result = _export(a)
    except BadInput as error:
        print(f"ferrule: {printable(error)}", file=sys.stderr)
        return 2
    except (FileTrouble, ImportError) as error:
        print(f"ferrule: {printable(error)}", file=sys.stderr)
        return 3
    except KeyboardInterrupt as stopped:
        print(f"ferrule: stopped by {stopped}; nothing of it is kept", file=sys.stderr)
        return 130
    if a.json:
        print(json.dumps({**result, "provenance": {"version": __version__}}))
        return 0
    if "rows" in result:
        print(
            f"{result['demonstrations']} demonstrations, {result['rows']} rows at "
            f"{result['rate_hz']:g} Hz; {result['left_out']} episodes that were not inserted left "
            f"out\nactions of 1: {result['action_scale']} (m/s, rad/s at the tip)"
        )
    for place in result["written"]:
        print(f"wrote {printable(place)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

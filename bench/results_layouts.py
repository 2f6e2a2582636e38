"""How each table of docs/results.md lays out what its commands give."""

import json
import re
from pathlib import Path
from statistics import median
from typing import Any, Callable

ROOT = Path(__file__).resolve().parent.parent
SCENES = ROOT / "data/scenes"

Result = Any  # what a command gives: its JSON, or its text where it has none


class NotMade(Exception):
    """A table that cannot be made, and why."""


def markdown(columns: list[str], rows: list[list[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("|" + "|".join(f" {c} " if c and c != "---" else c or " " for c in line) + "|" for line in lines)


def columns(header: str) -> list[str]:
    return header.split(" | ")


def digits(x: float | None, count: int = 3, unit: str = "") -> str:
    """So many significant digits; large numbers without an exponent."""
    if x is None:
        return "-"
    return (f"{x:.0f}" if abs(x) >= 10**count else f"{x:.{count}g}") + unit


def fixed(x: float | None, places: int, unit: str = "") -> str:
    return "-" if x is None else f"{x:.{places}f}{unit}"


def interval(s: Result) -> str:
    return f"{100 * s['wilson_low']:.1f} to {100 * s['wilson_high']:.1f} %"


def inserted(s: Result) -> str:
    return f"{s['successes']} of {s['feasible']}"


def time(s: Result) -> str:
    return fixed(s["time_s"]["median"], 1, " s")


def peaks(s: Result) -> str:
    peak = s["peak_force_uN"]
    return f"{peak['median']:.1f}, {peak['p95']:.1f} uN"


def force(s: Result) -> str:
    peak = s["peak_force_uN"]["median"]
    return "-" if peak is None else f"{peak:#.3g}".rstrip(".") + " uN"


def loss(s: Result) -> str:
    return fixed(s["loss_dB"]["median"], 3, " dB")


def seconds(x: float) -> str:
    return digits(x, 1 if x < 1 else 2, " s")


def step(s: float) -> str:
    return digits(1e3 * s, 3, " ms") if s > 9e-5 else digits(1e6 * s, 3, " us")


def as_printed(scene: str) -> bool:
    """Does the scene have force laws as the paper prints them?"""
    file = SCENES / f"{scene}.json"
    return file.exists() and '"printed"' in file.read_text()


def corrected_first(rows: list[Result]) -> list[Result]:
    return sorted(rows, key=lambda r: (r["scene"] == "random", as_printed(r["scene"]), r["scene"]))


def label(scene: str) -> str:
    return scene if scene == "random" else f"`{scene}`" + (" (printed)" if as_printed(scene) else "")


def by_scene(rows: list[Result], cell: Callable[[Result], str], column: str) -> str:
    """A line for each scene, a column for each value of `column`; rows with the same of both share a cell."""
    across = list(dict.fromkeys(r[column] for r in rows))
    lines = []
    for scene in dict.fromkeys(r["scene"] for r in rows):
        cells = [[cell(r) for r in rows if (r["scene"], r[column]) == (scene, value)] for value in across]
        lines.append([f"`{scene}`", *(", ".join(c) for c in cells)])
    return markdown(["scene", *across], lines)


def demo(result: Result) -> str:
    pairs = (("fitted law", result), ("constant velocity", result["baseline"]))
    return markdown(columns("controller | inserted | 95 % interval | time | peak force | joint loss, median"),
                    [[name, inserted(s), interval(s), time(s), force(s), loss(s)] for name, s in pairs])


def worst_and_median(rows: list[Result]) -> tuple[Result, Result]:
    """Of the rows of several recordings, by success and then by time."""
    ordered = sorted(rows, key=lambda r: (r["success_rate"], -(r["time_s"]["median"] or 0)))
    return ordered[0], ordered[(len(ordered) - 1) // 2]


def by_controller(rows: list[Result]) -> dict[str, list[Result]]:
    """The rows of each, in the order of their first."""
    found: dict[str, list[Result]] = {}
    for row in rows:
        found.setdefault(row["controller"], []).append(row)
    return found


def counts(rows: list[Result]) -> str:
    """Of several recordings the worst and the median, of one it."""
    worst, median = worst_and_median(rows)
    return inserted(worst) if len(rows) == 1 else f"{worst['successes']}, {inserted(median)}"


def ways(_: Result, compared: Result) -> str:
    def against(row: Result, what: str) -> str:
        if "against_operator" not in row:
            return ""
        d = row["against_operator"][what]
        return "-" if d["low"] is None else f"{d['median']:+.2f} ({d['low']:+.2f} to {d['high']:+.2f})"

    recordings = by_controller(compared["by_seeds"])
    lines = []
    for row in compared["rows"]:
        rows = recordings.get(row["controller"], [row])
        worst, r = worst_and_median(rows)
        lines.append([row["controller"], counts(rows), interval(worst), time(r), against(r, "time_difference_s"),
                      force(r), against(r, "peak_force_difference_uN")])
    return markdown(columns("controller | inserted: worst, median | 95 % interval of the worst | time"
                            " | against the operator | peak force | against the operator"), lines)


def learned(_: Result, compared: Result) -> str:
    recordings = by_controller(compared["by_seeds"])

    def error(name: str) -> str:
        errors = [r["held_out_mm_s"] for r in recordings[name] if r["held_out_mm_s"] is not None]
        return f"{max(errors):.2f}, {median(errors):.2f} mm/s" if errors else "-"

    return markdown(columns("controller | fitted numbers | time to fit, median | held-out error: worst, median"),
                    [[r["controller"], str(r["parameters"]),
                      seconds(median(each["fit_s"] for each in recordings[r["controller"]])),
                      error(r["controller"])] for r in compared["rows"] if r["controller"] in recordings])


def traits(*results: Result) -> str:
    rows = []
    for r in results:
        inserted = [e["time_s"] for e in r["episodes"] if e["outcome"] == "inserted"]
        rows.append([r["operator"].split("skill ")[1], f"{len(inserted)} of {len(r['episodes'])}",
                     fixed(median(inserted) if inserted else None, 1, " s"),
                     fixed(median(e["peak_force_uN"] for e in r["episodes"]), 1, " uN")])
    return markdown(columns("skill | inserted | time | peak force"), rows)


def demonstrations_text(r: Result) -> str:
    rollouts = r["labelled_rollouts"]
    return f"{r['demonstrations']}, and {rollouts} labelled rollouts" if rollouts else str(r["demonstrations"])


def seeds(_: Result, from_20: Result, __: Result, from_5: Result) -> str:
    rows = []
    for compared in (from_20, from_5):
        for name in dict.fromkeys(r["controller"] for r in compared["by_seeds"]):
            of_it = [r for r in compared["by_seeds"] if r["controller"] == name]
            of_it.sort(key=lambda r: r["success_rate"])
            median = of_it[len(of_it) // 2]
            rates = [100 * r["success_rate"] for r in of_it]
            times = [r["time_s"]["median"] for r in of_it if r["time_s"]["median"] is not None]
            rows.append([name, demonstrations_text(median), f"{100 * median['success_rate']:.1f} %",
                         interval(median), f"{rates[0]:.1f} to {rates[-1]:.1f} %",
                         f"{min(times):.1f} to {max(times):.1f} s" if times else "-"])
    return markdown(columns("learner | demonstrations | inserted, median of the seeds | interval over trials"
                            " | over seeds | time over seeds"), rows)


def elsewhere(*results: Result) -> str:
    (_, compared, _, rnn_training, act_training, rnn, act, with_rnn, with_act) = results

    def theirs(name: str, said: str, s: Result, compared: Result) -> list[str]:
        trained = re.search(r"trained in (\d+) s", said)
        if not trained:
            raise NotMade(f"the training of {name} does not say how long it took")
        return [name, inserted(s), interval(s), time(s), force(s), loss(s),
                f"{trained[1]} s", digits(1e-6 * compared["rows"][-1]["ns_per_action"], 2, " ms"), "20"]

    def ours(r: Result) -> list[str]:
        return [f"ours: {r['controller']}", inserted(r), interval(r), time(r), force(r),
                loss(r), seconds(r["fit_s"]),
                digits(1e-3 * r["ns_per_action"], 2, " us"), "1000"]

    return markdown(
        columns("controller | inserted | 95 % interval | time | peak force | joint loss"
                " | training, one processor | an action | actions a second"),
        [theirs("BC-RNN of robomimic, 2 x 64, with rollouts", rnn_training, rnn, with_rnn),
         theirs("ACT of LeRobot, width 64", act_training, act, with_act),
         *(ours(r) for r in compared["rows"] if r["controller"] in ("torch", "ceres, insertion"))])


def by_demonstrations(_: Result, compared: Result) -> str:
    rows = compared["by_demonstrations"]

    def cell(r: Result) -> str:
        share = f" ({interval(r)})" if r["successes"] < r["feasible"] else ""
        return f"{r['successes']}{share}, {time(r)}, {force(r)}"

    names = list(dict.fromkeys(r["controller"] for r in rows))
    return markdown(["demonstrations", *names],
                    [[str(n), *(cell(r) for r in rows if r["demonstrations"] == n)]
                     for n in dict.fromkeys(r["demonstrations"] for r in rows)])


def scenes(_: Result, from_20: Result, __: Result, from_5: Result) -> str:
    def cell(s: Result) -> str:
        return f"{inserted(s)} ({interval(s)}), {time(s)}, {force(s)}"

    rows = []
    for compared in (from_20, from_5):
        here = [r | {"scene": compared["scene"]} for r in compared["rows"] if r["parameters"]]
        learners = [r["controller"] for r in here]
        there = [r for r in compared["transfer"] if r["controller"] in learners]
        rows += [[f"`{r['scene']}`", r["controller"], str(compared["demonstrations"]), cell(r),
                  cell(r["supervised"])] for r in here + there]
    return markdown(columns("scene | learner | demonstrations | alone | under the supervisor"), rows)


METHODS = {"quasi_static": "quasi-static", "backward_euler": "backward Euler", "explicit_euler": "explicit Euler",
           "bdf2": "BDF2"}


def fails_most(r: Result) -> str:
    """Where the trials that did not choose the worst tenth show that it is worse than all."""
    tenth = r["worst_tenth_of"]
    if tenth["wilson_high"] >= r["success_rate"]:
        return "-"
    return (f"{round(r['worst_tenth'] * tenth['trials'])} of {tenth['trials']}, {tenth['key']} of"
            f" {tenth['low']:.4g} to {tenth['high']:.4g}")


def ladder(*results: Result) -> str:
    rows = []
    for searched, tuned in zip(results[::2], results[1::2]):
        name = searched["scene"]
        about = json.loads((SCENES / f"{name}.json").read_text())["about"]
        what = re.sub(r"^Rung \w+: (.*)\.$", r"\1", about)
        rows.append([f"`{name}`", what, inserted(searched["baseline"]), inserted(tuned["baseline"]),
                     inserted(tuned),
                     f"{inserted(searched)} ({interval(searched)})", time(searched), peaks(searched),
                     fails_most(searched)])
    return markdown(columns("rung | what | constant velocity | blind spiral | tuned by hand | search"
                            " | its time | its peak force, median and 95 % | where it fails most"), rows)


def by_rung(compared: Result) -> dict[str, dict[str, list[Any]]]:
    """The rows of each controller on each rung: one, or one a seed."""
    rungs: dict[str, dict[str, list[Any]]] = {}
    for row in compared["ladder"]:
        rungs.setdefault(row["rung"], {}).setdefault(row["controller"], []).append(row)
    return rungs


def mean_and_worst(rows: list[Any]) -> str:
    rates = [100 * r["success_rate"] for r in rows]
    return f"{sum(rates) / len(rates):.1f} ({min(rates):.1f}) %"


def climbers(_: Result, compared: Result) -> str:
    rows, names = [], dict.fromkeys(r["controller"] for r in compared["ladder"] if r["training_seed"] is not None)
    for rung, of in by_rung(compared).items():
        (operator,), (search,), (spiral,) = of["simulated operator"], of["search"], of["blind spiral"]
        rows.append([f"`{rung}`", digits(100 * operator["success_rate"], 3, " %"),
                     *(mean_and_worst(of[name]) for name in names),
                     digits(100 * search["success_rate"], 3, " %"), digits(search["search_s"], 2, " s"),
                     digits(spiral["search_s"], 2, " s")])
    return markdown(columns(f"rung | operator | {' | '.join(names)} | search | its search"
                            " | that of a spiral"), rows)


def supervised(_: Result, compared: Result) -> str:
    def both(alone: float | None, kept: float | None, unit: str) -> str:
        return f"{fixed(alone, 1)}, {fixed(kept, 1)}{unit}"

    who = ("constant velocity", "tuned by hand", "torch", "search")
    lines = []
    for rung, of in by_rung(compared).items():
        rows = [of[name][0] for name in who]
        search, kept = rows[-1], rows[-1]["supervised"]
        lines.append([f"`{rung}`",
                      *(both(100 * r["success_rate"], 100 * r["supervised"]["success_rate"], " %") for r in rows),
                      both(search["time_s"], kept["time_s"]["median"], " s"),
                      str(kept["interventions"]["retreat"]["count"]), str(kept["outcomes"]["force_limit"])])
    return markdown(columns(f"rung | {' | '.join(who)} | time of the search | its retreats | over the force limit"),
                    lines)


def ablations(_: Result, compared: Result) -> str:
    less = dict.fromkeys(r["controller"] for r in compared["ladder"] if r["without"])
    names = sorted({name.partition(", no ")[0] for name in less} | set(less))
    rows = [[f"`{rung}`", *(digits(100 * of[name][0]["success_rate"], 3, " %") for name in names)]
            for rung, of in by_rung(compared).items()]
    return markdown(columns(f"rung | {' | '.join(names)}"), rows)


def followers(_: Result, compared: Result) -> str:
    def mean(rows: list[Any], key: str) -> float | None:
        known = [r[key] for r in rows if r[key] is not None]
        return sum(known) / len(known) if known else None

    lines = []
    for rung, of in by_rung(compared).items():
        learned, (search,) = of["ceres, search"], of["search"]
        lines.append([f"`{rung}`", mean_and_worst(learned), digits(100 * search["success_rate"], 3, " %"),
                      *(", ".join(fixed(mean(rows, key), 1) for rows in (learned, [search]))
                        for key in ("time_s", "search_s", "peak_force_uN"))])
    return markdown(columns("rung | learned | search | time [s], of both | its search [s] | peak force [uN]"), lines)


def improved(_recorded: Result, _fitted: Result, _improved: Result, *results: Result) -> str:
    return reached(*results)


def reached(*results: Result) -> str:
    return markdown(columns("rung | inserted | 95 % interval | time, median | its peak force, median and 95 %"),
                    [[f"`{r['scene']}`", inserted(r), interval(r), time(r), peaks(r)] for r in results])


def stepping(result: Result) -> str:
    def error(x: float | None, rounding: float, unit: str) -> str:
        return "diverges" if x is None else "exact" if x < rounding else digits(x, 3, unit)

    return markdown(columns("method | case | step | time per step | tip error | force error"
                            " | Newton iterations per step"),
                    [[METHODS[r["method"]], r["case"], step(r["step_s"]), f"{r['ns_per_step']:.0f} ns",
                      error(r["tip_error_nm"], 1e-6, " nm"), error(r["force_error_relative"], 1e-12, ""),
                      digits(r["newton_iterations"], 1)] for r in result["stepping"]])


def laws(result: Result) -> str:
    return markdown(columns("law | fidelity | time | relative error"),
                    [[r["name"].replace("_", " ").replace("waals", "Waals"), r["fidelity"], f"{r['ns']:.0f} ns",
                      digits(r["relative_error"], 2)] for r in result["laws"]])


def campaigns(result: Result) -> str:
    return markdown(columns("scene | steps | time per step | Newton iterations in contact"
                            " | evaluations per step, most | capped"),
                    [[f"`{r['scene']}`", f"{r['steps']:,}", f"{r['ns_per_step']:.0f} ns",
                      fixed(r["iterations_in_contact"], 2), f"{r['evaluations']:.2f}, {r['evaluations_max']}",
                      str(r["capped"])] for r in result["campaigns"] if r["step_s"] == 1e-3])


def peers(result: Result) -> str:
    if result["not_measured"]:
        raise NotMade(result["not_measured"][0])
    rows, before = [], ("", "")
    for r in result["rows"]:
        engine = f"{r['engine']} {r['version']}"
        rows.append([engine if engine != before[0] else "",
                     f"{r['segments']} boxes" if r["segments"] else "round", step(r["step_s"]),
                     digits(r["us_per_simulated_ms"], 2, " us"), digits(r["pose_error_um"], 2, " um"),
                     "-" if r["force_error_relative"] is None else digits(100 * r["force_error_relative"], 2, " %"),
                     digits(r["penetration_um"], 2, " um"), f"{r['let_in']} of {r['outside']}",
                     r["settings"] if (engine, r["settings"]) != before else ""])
        before = engine, r["settings"]
    return markdown(
        columns("engine | bore of | step | time per simulated ms | pose, largest error | force at the holder"
                " | penetration | let in from outside | settings"), rows)


def tail(result: Result) -> str:
    return markdown(
        columns("scene | steps | not converged | capped | evaluations, 99.99 % and most"
                " | time, 99.99 % and longest | loops that gained energy"),
        [[label(r["scene"]), f"{r['steps']:,}", f"{r['not_converged']:,}", f"{r['capped']:,}",
          f"{r['evaluations_p9999']}, {r['evaluations_max']}", f"{digits(r['p9999_us'])}, {digits(r['worst_us'])} us",
          f"{r['loops_that_gained']} of {r['loops']}"] for r in corrected_first(result["rows"])])


def events(result: Result) -> str:
    rows = corrected_first(result["rows"])

    def difference(scene: str, motion: str, step_s: float) -> str:
        [x] = [r["pose_difference_clearances"] for r in rows
               if (r["scene"], r["motion"], r["step_s"]) == (scene, motion, step_s)]
        return fixed(x, 3) if x < 1 else digits(x, 2)

    return markdown(columns("scene | insertion, 1 ms | 1/2 | 1/8 | pressed against the wall, 1 ms | 1/2 | 1/8"),
                    [[label(scene), *(difference(scene, motion, step_s) for motion in ("insertion", "press")
                                      for step_s in (1e-3, 1e-3 / 2, 1e-3 / 8))]
                     for scene in dict.fromkeys(r["scene"] for r in rows)])


def turns(result: Result) -> str:
    groups: dict[str, list[Result]] = {}
    motions = {"insertion": "insertions", "press": "against the wall"}
    for r in corrected_first(result["rows"]):
        name = label(r["scene"]) if as_printed(r["scene"]) else f"corrected, {motions[r['motion']]}"
        groups.setdefault(name, []).append(r)

    def worst(rows: list[Result], what: str) -> str:
        most = max(rows, key=lambda r: r[what])
        where = f" (`{most['scene']}`)" if len({r["scene"] for r in rows}) > 1 and most[what] > 1e-6 else ""
        return digits(most[what], 2) + where

    return markdown(columns("scenes | turned by 90 degrees | by 37 | mirrored"
                            " | starts off by more than 1e-6"),
                    [[name, *(worst(rows, what) for what in ("turned_90", "turned_37", "mirrored")),
                      f"{sum(r['off'] for r in rows)} of {sum(r['starts'] for r in rows)}"]
                     for name, rows in groups.items()])


def capture(result: Result) -> str:
    counts: dict[tuple, list[list[bool]]] = {}
    for r in result["rows"]:
        fits = r["offset_clearances"] < r["capture_clearances"]
        counts.setdefault((r["lead_in"], r["edge_um"], r["cleave_deg"]), [[], []])[fits].append(r["inserted"])
    return markdown(columns("mouth | edge rounded to | cleaved at | went in, of those that fit | of those that do not"),
                    [["lead-in" if lead_in else "sharp", digits(edge, 3, " um") if edge else "sharp",
                      f"{cleave:g} degree" + "s" * (cleave != 1) if cleave else "square",
                      *(f"{sum(went)} of {len(went)}" for went in (fit, too_far))]
                     for (lead_in, edge, cleave), (too_far, fit) in sorted(counts.items())])


def hard(result: Result) -> str:
    return markdown(columns("case | step | error | result"),
                    [[r["case"], step(r["step_s"]) if r["step_s"] else "", digits(r["error"], 2), r["result"]]
                     for r in result["rows"]])


def parts(result: Result) -> str:
    most = max(r["trials"] for r in result["rows"])
    return by_scene(result["rows"], lambda r: share(r, most), "part")


def share(r: Result, most: int) -> str:
    """How many inserted; of how many, where some pairs of parts did not fit."""
    return str(r["inserted"]) if r["trials"] == most else f"{r['inserted']} of {r['trials']}"


def sensors(result: Result) -> str:
    most = max(r["trials"] for r in result["rows"])
    named = [r | {"sensor": r["sensor"].replace("none", "none: constant velocity")} for r in result["rows"]]
    return by_scene(named, lambda r: share(r, most), "sensor")


def plans(result: Result) -> str:
    trials = max(r["trials"] for r in result["rows"])
    header = "scene | plan | bound | sampled twice, every step solved | full | as shipped | planned"
    return markdown(
        columns(header + f" | times faster than full | inserted of {trials}, full and planned"),
        [[f"`{r['scene']}`", fixed(r["planning_s"], 2, " s"), digits(r["error_bound"], 2),
          digits(r["sampled_twice"], 2),
          *(f"{r[of + '_us_per_simulated_s']:.0f}" for of in ("full", "shipped", "planned")),
          fixed(r["ratio"], 2), f"{r['full_inserted']}, {r['planned_inserted']}"] for r in result["rows"]])


def recording(result: Result) -> str:
    return markdown(columns("scene | rows | recording a row | writing it afterwards"
                            " | written per second of recording"),
                    [[f"`{r['scene']}`", f"{r['rows']:,}", digits(r["us_per_row"], 2, " us"),
                      digits(r["us_per_row_written"], 2, " us"), f"{r['kB_per_s']:.0f} kB"] for r in result["rows"]])

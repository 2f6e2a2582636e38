"""The tables of docs/results.md, and the commands that make each."""

from typing import Callable, NamedTuple

import results_layouts as layouts


class Table(NamedTuple):
    name: str  # of its markers: <!-- name --> and <!-- /name -->
    kind: str  # "counts" are the same on every machine; "timing" needs one that does nothing else
    commands: list[str]  # as the document shows them
    layout: Callable[..., str]  # takes the result of each command
    quick: list[str] | None  # with smaller counts; None: nothing makes it short


TWENTY = "./ferrule record --scene bench --episodes 20 --skill 0.8 --seed 1 --out bench-episodes"
FIVE = "./ferrule record --scene bench --episodes 5 --skill 0.8 --seed 1 --out five"
COMPARE = "./ferrule compare bench-episodes --scene bench --seeds 1..5 --plot compared"
QUICK_COMPARE = "./ferrule compare five --learners linear,torch --seeds 1..2 --trials 10"
SEEDS = "--learners insertion,torch,dagger --seeds 1..5"
QUICK_SEEDS = "./ferrule compare five --learners linear --seeds 1..2 --trials 4"
OTHERS = "--trials 200 --learners insertion,dagger --transfer tight,sticky,sloppy,epoxy --seed 8"
QUICK_TRANSFER = "./ferrule compare five --learners linear --transfer tight,epoxy --trials 4"
STEPPING = "./ferrule bench --plot plots"
EXPORT = "./ferrule export-episodes bench-episodes --robomimic all.h5 --lerobot dataset --relative"
RNN = "$python examples/learners/robomimic_bc_rnn.py"
ACT = "$python examples/learners/lerobot_act.py"


def policies(what: str) -> list[str]:
    return [f'./ferrule {what} --policy-hz 20 --policy "{policy}"'
            for policy in (f"{RNN} answer bc-rnn", f"{ACT} answer act")]


# Skill 0.2, each trait as skill 0.8 has it, skill 0.8, and gains that differ by place, force and phase.
OPERATORS = ["0.2", "0.2,delay=0.17", "0.2,peak_speed=0.94", "0.2,yield=9e-4", "0.2,slowing_force=2.7",
             "0.2,tremor=2.4e-6", "0.2,hesitation_rate=0.076", "0.8", "0.2,bore_yield=0.3", "0.2,bore_yield=3",
             "0.2,force_yield=0.3", "0.2,force_yield=3", "0.2,late_yield=0.3", "0.2,late_yield=3",
             "0.2,tilt_yield=1e-5"]


def traits(episodes: int) -> list[str]:
    return [f"./ferrule record --scene hard --episodes {episodes} --seed 1 --skill {skill}"
            f" --out by/{skill.split(',')[-1]}" for skill in OPERATORS]


START = "--set start.lateral_sd_um=20 --set start.tilt_sd_mrad=1.33"
DRAWN = ("--set start.lateral_sd_um=20 --set start.tilt_sd_mrad=4 --set ferrule.bore_diameter_um=125.0..126.7"
         """ --set 'laws.friction.burgers_nm={"choice":[0.03,0.2,0.52,1.03,3.6]}'"""
         " --set laws.adhesion.work_of_adhesion_J_m2=0.0045..0.08 --set holder.free_length_mm=4.2..18.8"
         " --set hand.gain=0.45..1.55 --set hand.delay_ms=0..67")
# The rungs, and what makes the ranges of each a third wider.
WIDER = {
    "a": START,
    "b1": "--set start.lateral_sd_um=20 --set start.tilt_sd_mrad=6.67",
    "b2": f"{START} --set laws.drag.viscosity_Pa_s=0.33..1.67",
    "b3": "--set start.lateral_sd_um=33.3 --set start.tilt_sd_mrad=2",
    "b": f"{DRAWN} --set sensor.noise_uN=0.17..2.83 --set sensor.bias_uN=0.17..2.83",
    "c": "--set start.lateral_sd_um=2.67 --set start.tilt_sd_mrad=1.33",
    "d": START,
    "d2_cleave": f"{START} --set fibre.cleave_deg=0..1.33",
    "d2_edge": f"{START} --set fibre.edge_um=0.08..3.42",
    "e": START,
    "f": f"{DRAWN} --set fibre.cleave_deg=0..1.33 --set sensor.entrance_error_um=-6.7..6.7",
}


def ladder(trials: int, *how: str) -> list[str]:
    return [f"./ferrule evaluate {each} --scene ladder/{rung} --trials {trials}"
            for rung in WIDER for each in how]


def wider(trials: int) -> list[str]:
    return [f"./ferrule evaluate search --scene ladder/{rung} {changes} --trials {trials}"
            for rung, changes in WIDER.items()]


KNOWN = ("search --baseline constant-velocity", "tuned_by_hand --baseline spiral")
CLIMB = f"search --ladder {SEEDS} --trials 200"
SEARCHED = "./ferrule record --operator searching --scene by_hand/sharp --episodes 20 --out searched"
SUPERVISE = "./ferrule compare bench-episodes search --ladder --supervise --learners torch --trials 200"
ABLATE = ("./ferrule compare bench-episodes search --ladder --ablate force,memory,tilt,variation --learners torch"
          " --trials 200")
FOLLOW = "./ferrule compare searched search --scene ladder/d --ladder --learners search --seeds 1..5 --trials 200"
IMPROVE = ("./ferrule improve searched.json --scene ladder/f --also ladder/b,ladder/b1,ladder/b3"
           " --objective success,time --trials 24000 --trials-each 40 --out improved.json")
QUICK_CLIMB = "./ferrule compare five search --ladder --learners linear --seeds 1..2 --trials 2"
COST = "compare bench-episodes --learners insertion,torch --trials 1"
TABLES = [
    Table("demo", "counts", ["./ferrule demo"], layouts.demo, ["./ferrule demo"]),
    Table("ways", "counts", [TWENTY, COMPARE], layouts.ways, [FIVE, QUICK_COMPARE]),
    Table("learned", "timing", [TWENTY, COMPARE], layouts.learned, [FIVE, QUICK_COMPARE]),
    Table("traits", "counts", traits(100), layouts.traits, traits(1)),
    Table("seeds", "counts",
          [TWENTY, f"./ferrule compare bench-episodes --trials 200 {SEEDS}",
           FIVE, f"./ferrule compare five --trials 200 {SEEDS}"], layouts.seeds,
          [FIVE, QUICK_SEEDS, FIVE, QUICK_SEEDS]),
    Table("elsewhere", "timing",
          [TWENTY, COMPARE, EXPORT, f"{RNN} train all.h5 bc-rnn", f"{ACT} train dataset act",
           *policies("evaluate --scene bench --trials 1000"), *policies(COST)],
          layouts.elsewhere,
          [TWENTY, QUICK_COMPARE.replace("five", "bench-episodes"), EXPORT,
           f"{RNN} train all.h5 bc-rnn --epochs 2 --rollouts 1", f"{ACT} train dataset act --steps 30",
           *policies("evaluate --scene bench --trials 2"), *policies(COST.replace("insertion,torch", "linear"))]),
    Table("demonstrations", "counts",
          [TWENTY.replace("20", "100").replace("bench-episodes", "hundred"),
           "./ferrule compare hundred --scene bench --trials 200 --learners insertion,torch,dagger"
           " --demonstrations 5,10,20,50,100"],
          layouts.by_demonstrations,
          [FIVE, "./ferrule compare five --trials 4 --learners linear --demonstrations 3,5"]),
    Table("scenes", "counts",
          [TWENTY, f"./ferrule compare bench-episodes {OTHERS}", FIVE, f"./ferrule compare five {OTHERS}"],
          layouts.scenes, [FIVE, QUICK_TRANSFER, FIVE, QUICK_TRANSFER]),
    Table("ladder", "counts", ladder(1000, *KNOWN), layouts.ladder, ladder(4, *KNOWN)),
    Table("wider", "counts", wider(1000), layouts.reached, wider(4)),
    Table("climbers", "counts", [TWENTY, f"./ferrule compare bench-episodes {CLIMB}"], layouts.climbers,
          [FIVE, QUICK_CLIMB]),
    Table("supervised", "counts", [TWENTY, SUPERVISE], layouts.supervised,
          [FIVE, "./ferrule compare five search --ladder --supervise --learners torch --trials 2"]),
    Table("ablations", "counts", [TWENTY, ABLATE], layouts.ablations,
          [FIVE, ABLATE.replace("bench-episodes", "five").replace("200", "2")]),
    Table("followers", "counts", [SEARCHED, FOLLOW], layouts.followers,
          [SEARCHED.replace("20", "5"), FOLLOW.replace("1..5", "1..2").replace("200", "2")]),
    Table("improved", "counts",
          [SEARCHED, "./ferrule fit searched --method search --out searched.json", IMPROVE,
           *ladder(1000, "improved.json")], layouts.improved, None),
    Table("stepping", "timing", [STEPPING], layouts.stepping, None),
    Table("laws", "timing", [STEPPING], layouts.laws, None),
    Table("campaigns", "timing", [STEPPING], layouts.campaigns, None),
    Table("peers", "timing", ["./ferrule bench peers"], layouts.peers, None),
    Table("tail", "timing", ["./ferrule bench tail --seed 1"], layouts.tail,
          ["./ferrule bench tail --seed 1 --scenes 1"]),
    Table("events", "counts", ["./ferrule bench events --seed 1"], layouts.events,
          ["./ferrule bench events --scene easy --scenes 1"]),
    Table("turns", "counts", ["./ferrule bench turns --scenes 6"], layouts.turns, ["./ferrule bench turns --scenes 1"]),
    Table("capture", "counts", ["./ferrule bench capture"], layouts.capture, ["./ferrule bench capture"]),
    Table("hard", "counts", ["./ferrule bench hard"], layouts.hard, ["./ferrule bench hard"]),
    Table("parts", "counts", ["./ferrule bench parts --trials 100"], layouts.parts,
          ["./ferrule bench parts --trials 2"]),
    Table("plans", "timing", ["./ferrule bench plans --trials 100"], layouts.plans,
          ["./ferrule bench plans --trials 1 --scene bench"]),
    Table("recording", "timing", ["./ferrule bench recording"], layouts.recording, ["./ferrule bench recording"]),
    Table("sensors", "counts", ["./ferrule bench sensors --trials 60"], layouts.sensors,
          ["./ferrule bench sensors --trials 2 --scene bench"]),
]

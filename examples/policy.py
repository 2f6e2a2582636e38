"""A policy as a program of its own: an admittance that yields sideways and brakes inwards.

    ferrule evaluate --scene bench --policy "python3 examples/policy.py" --policy-hz 50 --trials 20
"""

import json
import sys

for line in sys.stdin:
    question = json.loads(line)
    if "reset" in question:  # a new trial: nothing to forget here
        answer = {}
    else:
        fx, fy, fz, _, _ = question["wrench"]  # [N], in the hand's world
        answer = {"velocity": [-2e-3 + 4e-4 * fx, 9e-4 * fy, 9e-4 * fz, 0, 0]}  # [m/s, rad/s]
    print(json.dumps(answer), flush=True)

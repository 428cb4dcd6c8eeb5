"""Commissions the sensors of a guard: says what to do with the robot, runs the steps, prints what
the guard found, and saves it in the guard.

    python examples/python/commission.py [ADAPTER]      waits for Enter before each step
    ... --hands-free                                    waits until the robot is in its position
    ... --save                                          writes and saves the values

ADAPTER is as in bench.py. docs/sensors.md explains the steps. The robot must be disarmed. Nothing
moves by itself. Ctrl-C ends the step that runs.
"""
import argparse
import math
import sys
import time

from bench import attempt, main

GUARD = 3  # product code
REQUEST, REPORT, SAVE = 0x2110, 0x2111, 0x1010
PROGRESS, REASON, VALUE, AXES, FIRST_RESULT = 1, 2, 3, 4, 5  # sub-indices of the report
DONE, REFUSED = 100, 101
PITCH, ROLL, SYNC = 0x6010, 0x6020, 0x80
RAISED, LEVEL, STILL = 8.0, 2.0, 0.5  # degrees
STILL_FOR = 200  # SYNCs: about a second, also in a simulation that is slower than real time
STEPS = ["Put the robot on level ground.",
         "Raise the nose by 8 degrees or more, for instance onto a block. Keep the heading.",
         "Put the robot level again, then raise its left side by 8 degrees or more.",
         "Put the robot on level ground. After the start of the step, turn it once."]
REASONS = {1: "the robot is not disarmed", 2: "an earlier step is missing", 3: "the robot moved",
           4: "the accelerometer does not read 1 g", 5: "rate of the gyroscope at rest",
           6: "not raised far enough, or on the wrong side",
           7: "gyroscope and accelerometer disagree: sign of an axis of the gyroscope",
           8: "inclinometer and accelerometer disagree", 9: "too few readings of the magnetometer",
           10: "the readings of the magnetometer are no ellipse",
           11: "the field did not turn against the robot: sign of an axis of the magnetometer",
           12: "the step took too long", 13: "no such step"}
MOVED, NOT_RAISED = 3, 6
# Settings in the order of the results, with the object of each.
SETTINGS = {"mounting_x": 0x22A4, "mounting_y": 0x22A5, "mounting_z": 0x22A6,
            "rate_at_rest_x": 0x22A7, "rate_at_rest_y": 0x22A8, "rate_at_rest_z": 0x22A9,
            "level_pitch": 0x22AA, "level_roll": 0x22AB, "hard_iron_forward": 0x2261,
            "hard_iron_left": 0x2262, "hard_iron_up": 0x2263, "soft_iron_forward": 0x2264,
            "soft_iron_left": 0x2265, "soft_iron_cross": 0x2266}
SENSOR_AXES = 0x22AC


class Tilt:
    """Pitch and roll that the guard shows, degrees. Before the commissioning they are off by
    constants, so only their changes count."""

    def __init__(self, guard):
        self.guard, self.syncs, self.level = guard, 0, None
        guard.network.subscribe(SYNC, self.count)

    def count(self, *_):
        self.syncs += 1

    def read(self):
        return [self.guard.read(index, "h") * 0.01 for index in (PITCH, ROLL)]

    def wait(self, raised):
        """Waits until the robot is at rest, and raised or level."""
        seen = []
        while True:
            seen.append((self.syncs, self.read()))
            low, high = ([rank(axis) for axis in zip(*(tilt for _, tilt in seen))]
                         for rank in (min, max))
            if math.dist(low, high) > STILL:
                seen = seen[-1:]
            angle = math.dist(low, self.level or low)
            in_position = angle > RAISED if raised else angle < LEVEL
            if in_position and self.syncs - seen[0][0] >= STILL_FOR:
                return
            time.sleep(0.02)


def run(guard, step):
    """Runs a step; returns why it was refused, or None."""
    guard.write(REQUEST, "B", 0)  # a step starts when the value changes
    guard.write(REQUEST, "B", step)
    progress, started = step, False
    try:
        while progress < DONE:
            time.sleep(0.1)
            progress = guard.read(REPORT, "B", PROGRESS)
            started |= progress == step
            if started and progress not in (step, DONE, REFUSED):
                sys.exit(f"step {step} has ended: did the guard start again?")
    finally:
        if progress < DONE:
            attempt(lambda: guard.write(REQUEST, "B", 0))
    return guard.read(REPORT, "B", REASON) if progress == REFUSED else None


def commission(guard, options):
    """Runs all steps, prints the values, and saves them if that is asked for."""
    product = guard.read(0x1018, "I", 2)
    if product != GUARD:
        sys.exit(f"node {guard.id} has product code {product}, which is no guard ({GUARD})")
    tilt = Tilt(guard)
    for step, task in enumerate(STEPS, 1):
        raised = step in (2, 3)
        print(f"step {step}: {task}", flush=True)
        if options.hands_free and step == 3:
            tilt.wait(raised=False)
        while True:
            if options.hands_free:
                tilt.wait(raised)
            else:
                input("Then press Enter. ")
            print(f"step {step} starts", flush=True)
            reason = run(guard, step)
            if reason is None:
                break
            words = f"{REASONS.get(reason, reason)}, value {guard.read(REPORT, 'i', VALUE)}"
            if reason not in (MOVED, NOT_RAISED):
                sys.exit(f"step {step} is refused: {words} (docs/bus.md, 2111)")
            print(f"step {step} is refused: {words}. Once more.", flush=True)
        if step == 1:
            tilt.level = tilt.read()
    found = {name: guard.read(REPORT, "i", sub)
             for sub, name in enumerate(SETTINGS, FIRST_RESULT)}
    axes = guard.read(REPORT, "B", AXES)
    for name, value in [*found.items(), ("sensor_axes", axes)]:
        print(f"{name} = {value}")
    if options.save:
        for name, value in found.items():
            guard.write(SETTINGS[name], "i", value)
        guard.write(SENSOR_AXES, "i", axes)
        guard.sdo.download(SAVE, 1, b"save")
        print("saved; the guard uses the values after its next start")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hands-free", action="store_true",
                        help="start each step when the robot is in its position")
    parser.add_argument("--save", action="store_true", help="save the values in the guard")
    main(parser, commission, node=1)

"""Calibrates the motor of an axle or a screw in bench mode, and saves the result in the node.

    python examples/python/calibrate.py [ADAPTER] --node 2          the shaft moves little
    python examples/python/calibrate.py [ADAPTER] --node 2 --free   the shaft is free to turn
    ... --save                                                      writes and saves the values

ADAPTER is as in bench.py. docs/motor.md says what must be set before. Ctrl-C ends the calibration,
and the motor then has no current.
"""
import argparse
import struct
import sys
import time

from bench import AXLE, BENCH_MODE, CSV, ERROR, FAULT_RESET, OFF, SCREW, main, ready

REQUEST, PROGRESS, REFUSAL, VALUE, BOUND = 0x2050, 0x2051, 0x2052, 0x2053, 0x2054
STEPS = {1: "offsets", 2: "resistance", 3: "drag", 4: "inductance", 5: "back-EMF",
         6: "resistance"}
DONE, REFUSED, LIMIT_S = 100, 101, 120
SAVE = 0x1010
REASONS = {1: "supply voltage", 2: "speed at the start", 3: "zero of the current converter",
           4: "resistance", 5: "difference between the phases", 6: "travel",
           7: "turns of the rotor per turn of the current", 8: "pole pairs are no whole number",
           9: "counts per electrical turn", 10: "lag by friction", 11: "inductance", 12: "speed",
           13: "difference of the torque constants in both directions",
           14: "standard error of the resistance: more calibration_current, or less load",
           15: "back-EMF has the wrong sign: swap the leads", 16: "current",
           17: "pulses of the index: its line, or a longer calibration_travel",
           120: "a value is out of the bounds of its setting",
           121: "the motor cannot be controlled with these values", 122: "ended from outside"}
# Settings that are measured, from object 2055 on, with the object of each.
RESULTS = {"current_zero_a": 0x22C6, "current_zero_b": 0x22C7, "current_balance": 0x22C8,
           "resistance": 0x2213, "inductance": 0x2214, "inductance_q": 0x22C2,
           "pole_pairs": 0x22C1, "phase_order": 0x22C4, "electrical_offset": 0x22C3,
           "torque_constant": 0x2212}
FIRST_RESULT = 0x2055


def measure(drive, request):
    """Runs the calibration to its end; returns the last progress."""
    identifier, frame = 0x300 + drive.id, struct.pack("<HBi", OFF, CSV, 0)
    sending = drive.network.send_periodic(identifier, frame, 0.02)
    try:
        time.sleep(0.1)
        drive.write(BENCH_MODE, "B", 1)
        drive.write(REQUEST, "B", request)
        end, before, progress = time.monotonic() + LIMIT_S, None, 0
        while progress < DONE and time.monotonic() < end:
            progress = drive.read(PROGRESS, "B")
            if progress != before and progress in STEPS:
                print(f"step {progress}: {STEPS[progress]}", flush=True)
            before = progress
            time.sleep(0.1)
        return progress
    finally:
        sending.stop()  # without set-points, bench mode and calibration end


def calibrate(drive, options):
    """Calibrates, prints the values, and saves them if that is asked for."""
    ready(drive, AXLE, SCREW)
    drive.node.nmt.send_command(1)
    for word in (OFF, FAULT_RESET, OFF):
        drive.network.send_message(0x300 + drive.id, struct.pack("<HBi", word, CSV, 0))
        time.sleep(0.05)
    error = drive.read(ERROR, "H")
    if error:
        sys.exit(f"the drive has the fault {error:#06x}: see docs/faults.md")
    progress = measure(drive, 2 if options.free else 1)
    if progress != DONE:
        if progress != REFUSED:
            sys.exit(f"no end within {LIMIT_S} s")
        reason = drive.read(REFUSAL, "B")
        sys.exit(f"refused, {REASONS.get(reason, f'step {reason - 100} took too long')}: value "
                 f"{drive.read(VALUE, 'i')}, bound {drive.read(BOUND, 'i')} (docs/bus.md, 2053)")
    measured = {}
    for index, name in enumerate(RESULTS, FIRST_RESULT):
        measured[name] = drive.read(index, "i")
        print(f"{name} = {measured[name] or 'not measured'}")
    if options.save:
        for name, value in measured.items():
            if value:
                drive.write(RESULTS[name], "i", value)
        drive.sdo.download(SAVE, 1, b"save")
        print("saved; the node uses the values after its next start, too")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--free", action="store_true", help="the shaft is free to turn")
    parser.add_argument("--save", action="store_true", help="save the values in the node")
    main(parser, calibrate)

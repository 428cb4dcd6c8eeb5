"""Calibrates the motor of an axle in bench mode, and saves the result in the node.

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

from bench import BENCH_MODE, CSV, ERROR, OFF, main, ready

REQUEST, PROGRESS, REFUSAL, VALUE, BOUND = 0x2050, 0x2051, 0x2052, 0x2053, 0x2054
STEPS = {1: "offsets", 2: "resistance", 3: "drag", 4: "inductance", 5: "back-EMF",
         6: "resistance"}
DONE, REFUSED, LIMIT_S = 100, 101, 120
SAVE = 0x1010
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
    ready(drive)
    drive.node.nmt.send_command(1)
    error = drive.read(ERROR, "H")
    if error:
        sys.exit(f"the drive has the fault {error:#06x}: see docs/faults.md")
    progress = measure(drive, 2 if options.free else 1)
    if progress != DONE:
        reason = drive.read(REFUSAL, "B") if progress == REFUSED else "no end"
        sys.exit(f"refused, reason {reason}, value {drive.read(VALUE, 'i')}, "
                 f"bound {drive.read(BOUND, 'i')}: see object 2052 in docs/bus.md")
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

"""Drives the simulated B2P2 one metre forward over flat ground and prints the guard's margins.

    python examples/python/drive.py [HOST:PORT]        (127.0.0.1:3333 if absent)
"""
import itertools
import socket
import struct
import sys
import time

import can  # pip install "python-can[serial]==4.6.1"

GUARD = 1  # node id of the guard; docs/bus.md has the identifiers, payloads and numbers below
COMMAND, MOTION, STATE, MARGINS = 0x200 + GUARD, 0x180 + GUARD, 0x280 + GUARD, 0x380 + GUARD
DISARM, ARM, STOP = 0, 1, 2  # requests to the guard
READY, ARMED, HELD = 1, 6, 7  # states of the guard

address = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:3333"
wanted = [{"can_id": id, "can_mask": 0x7FF} for id in (MOTION, STATE, MARGINS)]
bus = can.Bus(interface="slcan", channel=f"socket://{address}", bitrate=1_000_000,
              can_filters=wanted)
# The run waits for a client whose buffers are full. In a large buffer a late client reads frames
# that are seconds old, and drives too far.
with socket.fromfd(bus.serialPortOrig.fileno(), socket.AF_INET, socket.SOCK_STREAM) as connection:
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
sequence = itertools.count()
guard = {"state": 0, "distance": 0.0, "margins": (0, 0, 0, 0), "fault": 0}


def command(request, done, speed=lambda: 0.0, timeout=120):
    """Sends this command 50 times a second until `done()` holds; reads what the guard publishes."""
    end, printed, since = time.monotonic() + timeout, 0.0, 0
    # Three commands in a row make a request. The guard may not have received those before `done`.
    while since < 3:
        now = time.monotonic()
        if now > end or guard["state"] == HELD:
            sys.exit(f"guard in state {guard['state']}, fault {guard['fault']:#06x}; giving up")
        since = since + 1 if done() else 0
        # Speed in mm/s, yaw rate, chassis angle, request, and a number that rises by one.
        data = struct.pack("<hhhBB", round(speed() * 1000), 0, 0, request, next(sequence) % 256)
        bus.send(can.Message(arbitration_id=COMMAND, data=data, is_extended_id=False))
        while (message := bus.recv(max(0.0, now + 0.02 - time.monotonic()))) is not None:
            if message.arbitration_id == MOTION:
                guard["distance"] = struct.unpack("<ihh", message.data)[0] * 1e-6
            elif message.arbitration_id == STATE:
                guard["state"], _, _, _, guard["fault"], _ = struct.unpack("<BBBBHh", message.data)
            else:
                guard["margins"] = struct.unpack("<hhhh", message.data)
        if guard["state"] == ARMED and now - printed > 0.5:
            printed = now
            print("{:5.2f} m driven; margins in mm: back {}, front {}, left {}, right {}".format(
                guard["distance"], *guard["margins"]))


def drive():
    """Arms, drives one metre, stops and disarms."""
    print("waiting for the guard ...")
    command(DISARM, lambda: guard["state"] == READY)
    print("arming: homing takes some seconds ...")
    command(ARM, lambda: guard["state"] == ARMED)
    goal = guard["distance"] + 1.0
    # The robot slows down before the goal: on a busy computer the distance is read late.
    command(ARM, lambda: guard["distance"] >= goal,
            lambda: min(0.2, max(0.03, 0.5 * (goal - guard["distance"]))))
    stopped = time.monotonic() + 2.0
    command(STOP, lambda: time.monotonic() > stopped)
    command(DISARM, lambda: guard["state"] == READY)


try:
    drive()
except (can.CanError, OSError) as error:
    sys.exit(f"the bus is gone, perhaps because the run has ended: {error}")
bus.shutdown()
print("done")

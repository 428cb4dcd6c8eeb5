"""Turns one motor without a guard, in bench mode, and prints what its drive measures.

    python examples/python/bench.py [ADAPTER] --node 2                  reads only
    python examples/python/bench.py [ADAPTER] --node 2 --current 1.0    motor current, A
    python examples/python/bench.py [ADAPTER] --node 2 --velocity 0.1   output shaft, rad/s

ADAPTER is HOST:PORT of a demo (127.0.0.1:3333 if absent), or the device of an SLCAN adapter, for
instance /dev/ttyACM0. The drive stops when the program ends, or is ended with Ctrl-C.
"""
import argparse
import struct
import sys
import time

import can  # pip install "python-can[serial]==4.6.1" canopen==2.4.1
import canopen

# Objects of the drive (docs/bus.md), and where its settings begin (docs/settings.md).
BENCH_MODE, ERROR, STATUS = 0x2001, 0x603F, 0x6041
POSITION, VELOCITY, CURRENT, SUPPLY, INPUTS = 0x6064, 0x606C, 0x6078, 0x6079, 0x60FD
GEAR_RATIO, TORQUE_CONSTANT, POSITION_BITS = 0x2210, 0x2212, 0x221E
CSV, CST = 9, 10  # modes: cyclic synchronous velocity and torque
SHUT_DOWN, SWITCH_ON, ENABLE, FAULT_RESET = 0x06, 0x07, 0x0F, 0x80

options = argparse.ArgumentParser(description=__doc__,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
options.add_argument("adapter", nargs="?", default="127.0.0.1:3333")
options.add_argument("--node", type=int, default=2, help="node id of the drive")
motion = options.add_mutually_exclusive_group()
motion.add_argument("--current", type=float, help="motor current, A")
motion.add_argument("--velocity", type=float, help="velocity of the output shaft, rad/s")
options.add_argument("--seconds", type=float, default=2.0, help="how long")
options = options.parse_args()
channel = options.adapter if "/" in options.adapter else f"socket://{options.adapter}"


def read(index, layout):
    return struct.unpack("<" + layout, sdo.upload(index, 0))[0]


def set_point(controlword):
    """Frame of the drive with this controlword: identifier and data."""
    if options.current is None:
        target = round((options.velocity or 0.0) * 1e6)
        return 0x300 + options.node, struct.pack("<HBi", controlword, CSV, target)
    torque = options.current * read(TORQUE_CONSTANT, "i") * 1e-6 * read(GEAR_RATIO, "i") * 1e-3
    return 0x500 + options.node, struct.pack("<HBh", controlword, CST, round(torque * 100))


def report():
    """Prints what the drive measures; returns its error code."""
    turns = read(POSITION, "i") / 2 ** read(POSITION_BITS, "i")
    switches = read(INPUTS, "I")
    closed = [name for bit, name in enumerate(["negative limit", "positive limit", "home"])
              if switches >> bit & 1]
    error = read(ERROR, "H")
    print(f"position {turns:9.5f} turns  velocity {read(VELOCITY, 'i') * 1e-6:7.3f} rad/s  "
          f"current {read(CURRENT, 'h') * 1e-3:6.2f} A  supply {read(SUPPLY, 'I') * 1e-3:5.1f} V  "
          f"switches: {', '.join(closed) or 'none'}  error {error:#06x}", flush=True)
    return error


def watch():
    """Prints readings four times a second; ends with a fault."""
    end = time.monotonic() + options.seconds
    while time.monotonic() < end:
        error = report()
        if error and drives:
            sys.exit(f"fault {error:#06x}: see docs/faults.md")
        time.sleep(0.25)


def drive():
    """Enables the drive in bench mode and holds the set-point."""
    identifier, _ = set_point(0)
    if read(ERROR, "H"):
        network.send_message(*set_point(FAULT_RESET))
        time.sleep(0.1)
    network.send_message(*set_point(0))
    sdo.download(BENCH_MODE, 0, b"\x01")
    sending = network.send_periodic(identifier, set_point(SHUT_DOWN)[1], 0.01)
    try:
        for controlword in (SHUT_DOWN, SWITCH_ON, ENABLE):
            sending.update(set_point(controlword)[1])
            time.sleep(0.1)
        if read(STATUS, "H") & 0x6F != 0x27:
            report()
            sys.exit("the drive does not enable its motor: is safe torque off closed?")
        watch()
    finally:
        sending.update(set_point(SHUT_DOWN)[1])
        time.sleep(0.1)
        sending.stop()


drives = options.current is not None or options.velocity is not None
network = canopen.Network(can.Bus(interface="slcan", channel=channel, bitrate=1_000_000))
network.connect()
try:
    node = network.add_node(options.node, canopen.ObjectDictionary())
    node.nmt.wait_for_heartbeat(60)
    sdo = node.sdo
    sdo.RESPONSE_TIMEOUT = 2
    network.nmt.send_command(1)  # start all nodes
    drive() if drives else watch()
except KeyboardInterrupt:
    pass
except (can.CanError, canopen.SdoAbortedError, canopen.SdoCommunicationError,
        canopen.nmt.NmtError, OSError) as error:
    sys.exit(f"node {options.node}: {error}")
finally:
    network.disconnect()

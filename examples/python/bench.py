"""Turns one motor without a guard, in bench mode, and prints what its drive measures.

    python examples/python/bench.py [ADAPTER] --node 2                  reads only
    python examples/python/bench.py [ADAPTER] --node 2 --current 1.0    motor current, A
    python examples/python/bench.py [ADAPTER] --node 2 --velocity 0.1   output shaft, rad/s

ADAPTER is HOST:PORT of a demo (127.0.0.1:3333 if absent), or the device of an SLCAN adapter, for
instance /dev/ttyACM0 or COM3. The motor has no current when the program ends, also after Ctrl-C
and after a fault: the drive opens its bridge instead of holding. If the computer or the adapter
dies, the drive opens it after command_timeout.
"""
import argparse
import math
import signal
import struct
import sys
import threading
import time

import can  # pip install "python-can[serial]==4.6.1" canopen==2.4.1
import canopen

# Objects of the drive (docs/bus.md), and where its settings begin (docs/settings.md).
BENCH_MODE, ERROR, CONTROL, STATUS, FAULT_REACTION = 0x2001, 0x603F, 0x6040, 0x6041, 0x605E
POSITION, VELOCITY, CURRENT, SUPPLY, INPUTS = 0x6064, 0x606C, 0x6078, 0x6079, 0x60FD
GUARD_ID, GEAR_RATIO, TORQUE_CONSTANT, POSITION_BITS = 0x2202, 0x2210, 0x2212, 0x221E
BENCH_CURRENT, BENCH_SPEED = 0x2228, 0x2229
AXLE, SCREW = 1, 2  # product codes
ROLES = {AXLE: "axle", SCREW: "screw"}
HOLD = 2  # reaction to faults
CSV, CST = 9, 10  # modes: cyclic synchronous velocity and torque
OFF, SHUT_DOWN, SWITCH_ON, ENABLE, FAULT_RESET = 0x00, 0x06, 0x07, 0x0F, 0x80
ENABLED, POWERED = 0x27, (0x07, 0x0F, 0x27)  # bits 0x6F of the statusword
ALIGNING = 0x8000  # bit of the statusword: the drive aligns the rotor before it enables operation
ALIGNMENT_S = 3.0  # an alignment takes 1.15 s
SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP")
           if hasattr(signal, name)]


def number(text):
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is no finite number")
    return value


def seconds(text):
    value = number(text)
    if not 0 < value <= 86_400:
        raise argparse.ArgumentTypeError(f"{text}: allowed above 0, to 86400")
    return value


class Drive:
    """A drive on the bus, with its objects."""

    def __init__(self, network, node):
        self.network, self.node = network, network.add_node(node, canopen.ObjectDictionary())
        self.sdo, self.id = self.node.sdo, node
        self.sdo.RESPONSE_TIMEOUT = 2

    def read(self, index, layout, sub=0):
        return struct.unpack("<" + layout, self.sdo.upload(index, sub))[0]

    def write(self, index, layout, value):
        self.sdo.download(index, 0, struct.pack("<" + layout, value))

    def enabled(self):
        return self.read(STATUS, "H") & 0x6F == ENABLED

    def wait_for_alignment(self):
        end = time.monotonic() + ALIGNMENT_S
        while self.read(STATUS, "H") & ALIGNING and time.monotonic() < end:
            time.sleep(0.05)

    def report(self):
        """Prints what the drive measures; returns its error code."""
        turns = self.read(POSITION, "i") / 2 ** self.read(POSITION_BITS, "i")
        switches = self.read(INPUTS, "I")
        closed = [name for bit, name in enumerate(["negative limit", "positive limit", "home"])
                  if switches >> bit & 1]
        error = self.read(ERROR, "H")
        print(f"position {turns:9.5f} turns  velocity {self.read(VELOCITY, 'i') * 1e-6:7.3f} rad/s"
              f"  current {self.read(CURRENT, 'h') * 1e-3:6.2f} A"
              f"  supply {self.read(SUPPLY, 'I') * 1e-3:5.1f} V"
              f"  switches: {', '.join(closed) or 'none'}  error {error:#06x}", flush=True)
        return error

    def set_point(self, options):
        """Identifier, mode and target of the motion that was asked for."""
        if options.velocity is not None:
            limit = self.read(BENCH_SPEED, "i") * 1e-3
            if abs(options.velocity) > limit:
                sys.exit(f"--velocity {options.velocity}: bench_speed allows {limit} rad/s")
            return 0x300 + self.id, "<HBi", CSV, round(options.velocity * 1e6)
        limit = self.read(BENCH_CURRENT, "i") * 1e-3
        if abs(options.current) > limit:
            sys.exit(f"--current {options.current}: bench_current allows {limit} A")
        per_ampere = self.read(TORQUE_CONSTANT, "i") * 1e-6 * self.read(GEAR_RATIO, "i") * 1e-3
        target = round(options.current * per_ampere * 100)
        if not -32_768 <= target <= 32_767:
            sys.exit(f"--current {options.current}: {target / 100} N m, allowed 327.67 N m")
        if target == 0 and options.current:
            sys.exit(f"--current {options.current}: a target counts 0.01 N m, "
                     f"so the smallest current is {0.005 / per_ampere:.4f} A")
        return 0x500 + self.id, "<HBh", CST, target


def watch(drive, duration, runs=lambda: True):
    """Prints readings four times a second, while `runs` returns true."""
    end = time.monotonic() + duration
    while time.monotonic() < end:
        error = drive.report()
        if not runs():
            sys.exit(f"the drive has switched its motor off, error {error:#06x}: "
                     "see docs/faults.md")
        time.sleep(0.25)


def move(drive, options):
    """Enables the drive in bench mode, holds the set-point, and switches the drive off."""
    identifier, layout, mode, target = drive.set_point(options)

    def frame(controlword, target=0):
        return struct.pack(layout, controlword, mode, target)

    reaction = drive.read(FAULT_REACTION, "h") or HOLD  # 0 is left from a program that was killed
    drive.write(FAULT_REACTION, "h", 0)  # a fault opens the bridge instead of holding
    drive.node.nmt.send_command(1)  # set-points count in the state "operational" alone
    if drive.read(ERROR, "H"):
        drive.network.send_message(identifier, frame(FAULT_RESET))
        time.sleep(0.1)
    drive.network.send_message(identifier, frame(OFF))
    drive.write(BENCH_MODE, "B", 1)
    sending = drive.network.send_periodic(identifier, frame(SHUT_DOWN), 0.01)
    try:
        for controlword in (SHUT_DOWN, SWITCH_ON, ENABLE):
            sending.update(frame(controlword))
            time.sleep(0.1)
        drive.wait_for_alignment()
        if not drive.enabled():
            error = drive.report()
            sys.exit(f"the drive does not enable its motor, error {error:#06x}: "
                     "see docs/faults.md; is safe torque off closed?")
        sending.update(frame(ENABLE, target))
        watch(drive, options.seconds, drive.enabled)
    finally:
        handle(signal.SIG_IGN)
        print("switching off ...", file=sys.stderr, flush=True)
        sending.update(frame(OFF))
        time.sleep(0.1)
        sending.stop()
        switch_off(drive, reaction)


def switch_off(drive, reaction):
    """Makes sure that the bridge is open, and restores the reaction to faults."""
    is_off = False
    for _ in range(3):
        # An interrupted answer may be on its way, and a guard that has started refuses writes.
        attempt(lambda: drive.write(CONTROL, "H", OFF))
        status = attempt(lambda: drive.read(STATUS, "H"))
        is_off = status is not None and status & 0x6F not in POWERED
        if is_off and attempt(lambda: drive.write(FAULT_REACTION, "h", reaction) or True):
            return
        time.sleep(0.1)
    print("object 605E could not be restored: switch the supply off and on" if is_off else
          "the motor may still have current: open the emergency stop", file=sys.stderr)


def attempt(work):
    """Result of `work`, or None if the bus fails."""
    try:
        return work()
    except (canopen.SdoAbortedError, canopen.SdoCommunicationError, can.CanError, OSError):
        return None


def ready(drive, *products):
    """Ends the program unless the drive has one of these product codes and no guard commands it."""
    product = drive.read(0x1018, "I", 2)
    if product not in products:
        accepted = " or ".join(f"{ROLES[code]} ({code})" for code in products)
        sys.exit(f"node {drive.id} has product code {product}, which is no {accepted}")
    guard, heard = drive.read(GUARD_ID, "i"), []
    drive.network.subscribe(0x700 + guard, lambda *_: heard.append(1))
    time.sleep(0.2)
    if heard:
        sys.exit(f"node {guard} is a guard and runs: disconnect it to use bench mode")


def bench(drive, options):
    if options.current is None and options.velocity is None:
        watch(drive, options.seconds)
        return
    ready(drive, AXLE)
    move(drive, options)


def interrupt(*_):
    raise KeyboardInterrupt


def handle(handler):
    """Lets `handler` handle all signals that end a program."""
    for number in SIGNALS:
        signal.signal(number, handler)


def channel(adapter):
    """What python-can calls this adapter: a device, or a TCP address."""
    return f"socket://{adapter}" if ":" in adapter and adapter[0] != "/" else adapter


def main(parser, work, node=2):
    """Adds the arguments of the bus to `parser`, connects, and calls `work` with node and
    arguments."""
    parser.add_argument("adapter", nargs="?", default="127.0.0.1:3333")
    parser.add_argument("--node", type=int, default=node, help=f"node id, {node} if absent")
    options, network = parser.parse_args(), canopen.Network()
    if not 1 <= options.node <= 127:
        parser.error(f"--node {options.node}: allowed 1 to 127")
    handle(interrupt)
    threading.excepthook = lambda _: None  # the next request says that the adapter is gone
    try:
        network.connect(interface="slcan", bitrate=1_000_000, channel=channel(options.adapter))
        drive = Drive(network, options.node)
        print(f"waiting for node {options.node} ...", file=sys.stderr, flush=True)
        drive.node.nmt.wait_for_heartbeat(60)
        work(drive, options)
    except KeyboardInterrupt:
        sys.exit(130)
    except (can.CanError, canopen.SdoAbortedError, canopen.SdoCommunicationError,
            canopen.nmt.NmtError, OSError, ValueError) as problem:
        sys.exit(f"{options.adapter}, node {options.node}: {problem}")
    finally:
        handle(signal.SIG_IGN)
        if network.bus is not None:
            network.disconnect()


if __name__ == "__main__":
    arguments = argparse.ArgumentParser(description=__doc__,
                                        formatter_class=argparse.RawDescriptionHelpFormatter)
    motion = arguments.add_mutually_exclusive_group()
    motion.add_argument("--current", type=number, help="motor current, A; --current=-1 backward")
    motion.add_argument("--velocity", type=number, help="velocity of the output shaft, rad/s")
    arguments.add_argument("--seconds", type=seconds, default=2.0, help="how long")
    main(arguments, bench)

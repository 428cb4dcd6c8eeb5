"""Records signals of a drive's PWM interrupt and prints them as a table.

    python examples/python/capture.py [ADAPTER] [--node 2] [--fault] [--csv FILE]

ADAPTER is as in bench.py. It records at once. With --fault it arms the recording, and waits for
the drive's next fault.
docs/motor.md explains the signals.
"""
import argparse
import socket
import struct
import sys
import time

import can  # pip install "python-can[serial]==4.6.1" canopen==2.4.1
import canopen

from bench import channel

SIGNALS = {"current a": 1, "current b": 2, "current d": 3, "current q": 4, "demand": 5,
           "compare a": 6, "compare b": 7, "compare c": 8, "rotor": 9, "velocity": 10}
DONE, SAMPLES, WINDOW = 3, 512, 64

options = argparse.ArgumentParser()
options.add_argument("adapter", nargs="?", default="127.0.0.1:3333")
options.add_argument("--node", type=int, default=2, help="node id of the drive")
options.add_argument("--signals", default="current q,demand,compare a,velocity")
options.add_argument("--decimation", type=int, default=4, help="PWM periods per sample")
options.add_argument("--fault", action="store_true", help="record the next fault")
options.add_argument("--csv", help="file for all samples")
options = options.parse_args()
names = options.signals.split(",")


def read(sdo, index, sub, layout):
    return struct.unpack("<" + layout, sdo.upload(index, sub))[0]


def read_window(sdo, window):
    """Reads 64 samples. A node gives a segment up after 25 ms, so a slow client tries again."""
    for _ in range(50):
        try:
            data = sdo.upload(0x2063, 0)
        except (canopen.SdoAbortedError, canopen.SdoCommunicationError):
            time.sleep(0.1)  # an answer that comes late must not meet the next request
            continue
        if data[:2] == struct.pack("<H", window):
            return data[2:]
    sys.exit(f"window {window} cannot be read: this computer is too slow for the bus")


def record(sdo):
    """Arms the recording, waits until it is done, and returns its samples."""
    codes = sum(SIGNALS[name] << 8 * channel for channel, name in enumerate(names))
    sdo.download(0x2060, 2, struct.pack("<I", codes))
    sdo.download(0x2060, 3, struct.pack("<H", options.decimation))
    sdo.download(0x2060, 4, struct.pack("<H", SAMPLES // 2))
    sdo.download(0x2060, 1, bytes([2 if options.fault else 1]))
    while read(sdo, 0x2061, 1, "B") != DONE:
        time.sleep(0.05)
    samples = []
    for window in range(SAMPLES // WINDOW):
        sdo.download(0x2062, 0, struct.pack("<H", window))
        samples += struct.iter_unpack("<4h", read_window(sdo, window))
    return samples


def scaled(sdo, samples):
    """Converts samples to amperes, parts of the supply voltage, counts and rad/s."""
    ampere = read(sdo, 0x2061, 4, "I") * 1e-3 / 32768
    period = read(sdo, 0x2061, 5, "H")
    units = {"rotor": 1, "velocity": 0.01}
    scales = [1 / period if "compare" in name else units.get(name, ampere) for name in names]
    return [[value * scale for value, scale in zip(sample, scales)] for sample in samples]


bus = can.Bus(interface="slcan", channel=channel(options.adapter), bitrate=1_000_000)
if channel(options.adapter) != options.adapter:
    # A request must not wait for more bytes: a node gives a segment up after 25 ms.
    bus.serialPortOrig._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
network = canopen.Network(bus)
network.connect()
try:
    node = network.add_node(options.node, canopen.ObjectDictionary())
    # Until the network is operational, the guard is the only SDO client.
    while node.nmt.wait_for_heartbeat(10) != "OPERATIONAL":
        pass
    sdo = node.sdo
    sdo.RESPONSE_TIMEOUT = 5
    samples = scaled(sdo, record(sdo))
    period_ms = 1e3 * options.decimation / read(sdo, 0x2061, 3, "I")
    trigger = read(sdo, 0x2061, 2, "H")
except (can.CanError, canopen.SdoAbortedError, canopen.SdoCommunicationError,
        canopen.nmt.NmtError, OSError) as error:
    sys.exit(f"no recording: {error}")
finally:
    network.disconnect()

rows = [((index - trigger) * period_ms, *values) for index, values in enumerate(samples)]
if options.csv:
    with open(options.csv, "w") as file:
        print("time ms", *names, sep=",", file=file)
        for row in rows:
            print(*(f"{value:.4f}" for value in row), sep=",", file=file)
print("{:>9}".format("ms"), *(f"{name:>10}" for name in names))
for row in rows[::16]:
    print(f"{row[0]:9.2f}", *(f"{value:10.3f}" for value in row[1:]))
print(f"{len(rows)} samples, one every {period_ms:.2f} ms")

"""Runs a table of exchanges against node 5 on the bus of a simulation, and prints each difference.

Usage: conformance.py ADDRESS TABLE

The port passes two frames of a client in a millisecond of the run. So the program sends a tick and
a request, or a tick and an idle frame, and is always ahead of the run: 10 ms are 10 idle frames. A
second connection listens. There, the ticks are the clock.
"""

import json
import sys
import threading
from collections import deque
from queue import SimpleQueue

import canopen

# Their identifiers are restricted: no node receives them, and they wait for no other frame.
TICK, IDLE = (0x001, b""), (0x002, b"")
# Commands of the network management to node 5, and its boot-up message. A drive that has been
# enabled comes to rest before it restarts. The reset of the communication sets the phase of the
# heartbeat.
RESET_NODE, RESET_COMMUNICATION = (0x000, b"\x81\x05"), (0x000, b"\x82\x05")
RESTART_MS = 90
BOOT_UP = (0x705, b"\x00")
# An answer arrives in the millisecond after its request, or in the next one.
LATEST_MS = 2


def join(listen_only, listener):
    network = canopen.Network()
    network.listeners.append(listener)
    channel = "socket://" + sys.argv[1]
    options = {"bitrate": 1_000_000, "sleep_after_open": 0, "listen_only": listen_only}
    return network.connect(interface="slcan", channel=channel, **options)


def plan(rows):
    """Returns the frame of each millisecond. Each row gets the millisecond of its reset, its first
    one, and its last one. Each step gets its last millisecond, and the first one in which an answer
    may arrive: a node may answer a request in its next tick, during the requests after it."""
    frames = []
    for row in rows:
        row["reset"] = len(frames)
        frames += [RESET_NODE] + [IDLE] * RESTART_MS + [RESET_COMMUNICATION, IDLE]
        row["begin"] = begin = len(frames)
        for step in row["steps"]:
            step["begin"] = begin
            frames += [(request["id"], bytes(request["data"])) for request in step["send"]]
            frames += [IDLE] * step["wait_ms"]
            step["end"] = len(frames) - 1
            if step["wait_ms"]:
                begin = len(frames)
        frames += [IDLE] * LATEST_MS
        row["end"] = len(frames)
    return frames


def send(network, frames):
    for frame in frames:
        network.send_message(*TICK)
        network.send_message(*frame)


def receive(arrivals, frames):
    """Returns what the node sends, with the milliseconds in which it arrives."""
    own = deque(frame for frame in frames if frame != IDLE)
    received, now = [], -1
    while now < len(frames):
        message = arrivals.get(timeout=60)
        frame = message.arbitration_id, bytes(message.data)
        if frame == TICK:
            now += 1
        elif own and frame == own[0]:
            own.popleft()
        elif frame != IDLE:
            received.append((now, *frame))
    return received


def text(id, data):
    return f"{id:03x}: " + " ".join(".." if byte is None else f"{byte:02x}" for byte in data)


def difference(row, received):
    """Returns the first difference to the row, or None."""
    before = [frame[1:] for frame in received if row["reset"] < frame[0] <= row["begin"]]
    if before.count(BOOT_UP) != 2:
        return "it does not restart"
    rest = deque(frame for frame in received if row["begin"] < frame[0] <= row["end"])
    for step in row["steps"]:
        for expected in step["answers"]:
            id, pattern = expected["id"], expected["data"]
            wanted = f"{step['text']}: {text(id, pattern)}"
            if not rest:
                return f"{wanted} is missing"
            now, got, data = rest.popleft()
            fits = len(data) == len(pattern) and all(
                byte in (None, other) for byte, other in zip(pattern, data)
            )
            if got != id or not fits:
                return f"{wanted}, but {text(got, data)} arrives"
            if not step["begin"] <= now <= step["end"] + LATEST_MS:
                late = now - step["begin"]
                return f"{wanted} arrives {late} ms after the begin of this step"
    return f"{text(*rest[0][1:])} arrives, too" if rest else None


with open(sys.argv[2], encoding="utf-8") as file:
    rows = json.load(file)
frames = plan(rows)
arrivals = SimpleQueue()
listener = join(listen_only=True, listener=arrivals.put)
client = join(listen_only=False, listener=lambda _: None)
ahead = frames + [IDLE] * 200
threading.Thread(target=send, args=(client, ahead), daemon=True).start()
received = receive(arrivals, frames)
for row in rows:
    if why := difference(row, received):
        print(f"{row['name']}: {why}")

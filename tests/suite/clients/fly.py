"""A small SPI client: it turns the vehicle, and then lets it fly a line.

usage: fly.py HOST PORT SPEED    (SPEED: how many times faster than real time the vehicle runs)

It uses no code of this project: it formats and checks the sentences itself. It prints each success, and exits with 0.
"""

import socket
import sys
import time

HOST, PORT, SPEED = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
PATIENCE_S = 60.0


def xor(body):
    total = 0
    for character in body:
        total ^= ord(character)
    return total


class Vehicle:
    def __init__(self):
        self.socket = socket.create_connection((HOST, PORT), timeout=10)
        self.socket.settimeout(0.02)
        self.buffer = b""
        self.come = []
        self.heading = None
        self.control = False
        self.mission = ""

    def say(self, body):
        self.socket.sendall(f"${body}*{xor(body):02X}\r\n".encode())

    def sentence(self):
        """Returns the fields of the next sentence, after checking its checksum; None if none has arrived."""
        if not self.come:
            self.read()
        return self.come.pop(0) if self.come else None

    def read(self):
        try:
            read = self.socket.recv(65536)
            if not read:
                sys.exit("the vehicle closed the connection")
            self.buffer += read
        except TimeoutError:
            pass
        *whole, self.buffer = self.buffer.split(b"\r\n")
        for line in whole:
            body, checksum = line.decode("ascii").lstrip("$").split("*")
            assert int(checksum, 16) == xor(body), line
            fields = body.split(",")
            if fields[0] == "BFNVG":
                self.heading = float(fields[9])
            elif fields[0] == "BFCTL":
                self.control = fields[2] == "1"
            elif fields[0] == "BFMIS":
                self.mission = fields[3]
            self.come.append(fields)

    def wait(self, what, holds, each=None, every_s=0.0):
        """Reads until `holds(fields)` is true for a sentence. Calls `each()` every `every_s` of the vehicle's seconds."""
        start, said = time.monotonic(), 0.0
        while time.monotonic() - start < PATIENCE_S:
            if each and time.monotonic() - said >= every_s / SPEED:
                said = time.monotonic()
                each()
            fields = self.sentence()
            if fields and holds(fields):
                return fields
        sys.exit(f"not within {PATIENCE_S} s: {what}")

    def acknowledged(self, name, status):
        return lambda f: f[0] == "BFACK" and f[2] == name and f[5] == status


vehicle = Vehicle()
vehicle.wait("the version", lambda f: f[0] == "BFVER")
for message in ("ACK", "CTL", "MIS", "NVG", "MBS", "MBE"):
    vehicle.say(f"BPLOG,{message},ON")
vehicle.wait("control", lambda f: vehicle.control and vehicle.mission.startswith("Running"))
vehicle.wait("navigation", lambda f: f[0] == "BFNVG")
print(f"control at heading {vehicle.heading:.0f}")

# A modify, refreshed each second: the vehicle turns to it (SPI 7.12).
modify = lambda: vehicle.say("BPRMB,120000.000,20,3,0,1.5,1,0")
vehicle.wait("the modify accepted", vehicle.acknowledged("RMB", "2"), modify, 1.0)
turned = lambda f: f[0] == "BFNVG" and abs(float(f[9]) - 20) < 5
vehicle.wait("heading 20", turned, modify, 1.0)
vehicle.say("BPEMB,120001.000")
vehicle.wait("the modify ended", vehicle.acknowledged("EMB", "2"))
print(f"modified to heading {vehicle.heading:.0f}")

# A trackline that interrupts the current behavior (SPI 7.5), from its acknowledgement to its end.
vehicle.say("BPRTK,120002.000,41,4221.03,N,07042.10,W,4221.06,N,07042.05,W,0,8,1.5,0,4")
vehicle.wait("the trackline accepted", vehicle.acknowledged("RTK", "2"))
vehicle.wait("the trackline begun", lambda f: f[0] == "BFMBS" and f[4] == "41")
vehicle.wait("the trackline ended", lambda f: f[0] == "BFMBE" and f[4] == "41")
print("trackline 41 flown")

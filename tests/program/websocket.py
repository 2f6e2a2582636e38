"""A WebSocket client (RFC 6455) of the window's server, on the standard library alone."""

import base64
import json
import os
import socket
import struct
import time
import urllib.parse


class Window:
    """A page as the server sees one. `address` is the one that `view` prints."""

    def __init__(self, address, timeout=20):
        url = urllib.parse.urlparse(address)
        self.socket = socket.create_connection((url.hostname, url.port), timeout)
        key = base64.b64encode(os.urandom(16)).decode()
        self.write(f"GET {url.path}live HTTP/1.1\r\nHost: {url.netloc}\r\n"
                   f"Origin: http://{url.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                   f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        self.bytes = b""
        while b"\r\n\r\n" not in self.bytes:
            self.more()
        head, self.bytes = self.bytes.split(b"\r\n\r\n", 1)
        if not head.startswith(b"HTTP/1.1 101"):
            raise ConnectionError(head)
        self.columns = {}

    def write(self, data):
        self.socket.sendall(data)

    def more(self):
        data = self.socket.recv(1 << 16)
        if not data:
            raise EOFError
        self.bytes += data

    def take(self, count):
        while len(self.bytes) < count:
            self.more()
        data, self.bytes = self.bytes[:count], self.bytes[count:]
        return data

    @staticmethod
    def frame(data, kind=1):
        size = len(data)
        head = bytes([0x80 | kind])
        head += bytes([0x80 | size]) if size < 126 else b"\xfe" + struct.pack(">H", size)
        mask = os.urandom(4)
        return head + mask + bytes(c ^ mask[i % 4] for i, c in enumerate(data))

    def say(self, **message):
        self.write(self.frame(json.dumps(message).encode()))

    def hear(self):
        """A dictionary, or (kind, reserved, rows): rows are tuples in the order of the columns."""
        while True:
            kind, size = self.take(2)
            size &= 127
            if size == 126:
                size = struct.unpack(">H", self.take(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self.take(8))[0]
            data = self.take(size)
            kind &= 15
            if kind == 9:
                self.write(self.frame(data, 10))
            elif kind == 8:
                raise EOFError(struct.unpack(">H", data[:2])[0])
            elif kind == 1:
                message = json.loads(data)
                if message["type"] == "hello":
                    self.columns = {name: i for i, name in enumerate(message["columns"])}
                return message
            elif kind == 2:
                what, rows, columns, reserved = struct.unpack("<4I", data[:16])
                numbers = struct.unpack(f"<{rows * columns}f", data[16:])
                return what, reserved, [numbers[i * columns:(i + 1) * columns]
                                        for i in range(rows)]

    def hear_the_end(self):
        """The texts until then, and the code of RFC 6455 with which it ends, or None."""
        texts = []
        try:
            while True:
                heard = self.hear()
                if isinstance(heard, dict):
                    texts.append(heard)
        except EOFError as end:
            return texts, *(end.args or [None])
        except ConnectionResetError:
            return texts, None

    def hear_of(self, kind, **values):
        """The next text of that type with these values."""
        until = time.monotonic() + 60
        while time.monotonic() < until:
            message = self.hear()
            if isinstance(message, dict) and message["type"] == kind and all(
                    message.get(k) == v for k, v in values.items()):
                return message
        raise TimeoutError((kind, values))

    def close(self):
        self.socket.close()

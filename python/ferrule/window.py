"""A page in the browser that shows pictures as they come: the window of render_mode "human"."""

from __future__ import annotations

import os
import secrets
import struct
import sys
import threading
import webbrowser
import zlib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np

_PAGE = b"""<!doctype html><meta charset="utf-8"><title>ferrule</title>
<style>body{margin:0;background:#fafaf8}img{display:block;width:100vw;height:100vh;object-fit:contain}</style>
<img src="pictures" alt="fibre and bore">
"""


def png(image: np.ndarray) -> bytes:
    """RGB (rows, columns, 3), uint8, as a PNG file."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows, columns = image.shape[:2]
    lines = np.zeros((rows, 1 + 3 * columns), dtype=np.uint8)  # each begins with the filter: none
    lines[:, 1:] = image.reshape(rows, -1)
    head = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(lines.tobytes(), 1))
        + chunk(b"IEND", b"")
    )


class Window:
    """Served at ``address``, 127.0.0.1 alone, under a name that nobody guesses.

    Opened in the browser where there is a display, or the variable BROWSER names one; the address
    is on stderr. Who opens it later sees what is newest.
    """

    def __init__(self) -> None:
        self._newest: np.ndarray | None = None
        self._number = 0
        self._open = True
        self._changed = threading.Condition()
        self._token = secrets.token_hex(16)
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        print(f"the window: {self.address}", file=sys.stderr)
        if any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")):
            webbrowser.open(self.address)

    def show(self, image: np.ndarray) -> None:
        """RGB (rows, columns, 3), uint8."""
        with self._changed:
            self._newest, self._number = image, self._number + 1
            self._changed.notify_all()

    def close(self) -> None:
        with self._changed:
            self._open = False
            self._changed.notify_all()
        self._server.shutdown()
        self._server.server_close()

    def _after(self, number: int) -> tuple[int, np.ndarray | None]:
        """The newest picture, when it is another than that number; none where none comes any more."""
        with self._changed:
            self._changed.wait_for(lambda: not self._open or self._number != number)
            return self._number, self._newest if self._number != number else None

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        window = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                hosts = [f"{name}:{window._server.server_port}" for name in ("127.0.0.1", "localhost")]
                if self.headers.get("Host") not in hosts:
                    self.send_error(403)
                elif self.path == f"/{window._token}/":
                    self._head("text/html")
                    self.wfile.write(_PAGE)
                elif self.path == f"/{window._token}/pictures":
                    self._head("multipart/x-mixed-replace; boundary=next")
                    self._pictures()
                else:
                    self.send_error(404)

            def _head(self, kind: str) -> None:
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.send_header("Cache-Control", "no-store")
                self.end_headers()

            def _pictures(self) -> None:
                try:
                    self.wfile.write(b"--next\r\n")
                    number, image = window._after(0)
                    while image is not None:
                        data = png(image)
                        head = f"Content-Type: image/png\r\nContent-Length: {len(data)}\r\n\r\n"
                        # The boundary to the next at once: only then is this one shown.
                        self.wfile.write(head.encode() + data + b"\r\n--next\r\n")
                        number, image = window._after(number)
                except OSError:
                    pass  # the page was closed

            def log_message(self, *ignored: object) -> None:
                pass

        return Handler

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self._server.server_port}/{self._token}/"

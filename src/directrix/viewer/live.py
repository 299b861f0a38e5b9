"""The page of a run that goes on: a small server on this machine hands it the saved instants as they come.

The run does not wait for it and is not changed by it: instants are copied, everything else happens in other threads.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING, Any, Literal
from urllib.parse import parse_qs, urlsplit

import numpy as np
from numpy.typing import NDArray

from directrix.audit import Audit
from directrix.errors import ModelError
from directrix.result import Energy, Momentum, Result, Status
from directrix.telling import time_left
from directrix.viewer import page_data, page_text

if TYPE_CHECKING:
    from directrix.discretisation import Discretisation

Array = NDArray[np.float64]

__all__ = ["Live"]

PATIENCE = 8.0  # seconds that open pages have to fetch the end
INSTANTS_AT_MOST = 240  # then every other one is dropped, and from there on every other one is kept
WAITING = (
    "<!doctype html><html lang='en'><meta charset='utf-8'><meta http-equiv='refresh' content='1'>"
    "<meta name='color-scheme' content='light dark'><title>directrix</title>"
    "<p style='font: 16px system-ui, sans-serif; margin: 3em'>The run is being prepared …</p></html>"
)


class Live:
    """A ``progress`` of a run that others can look at in a browser, at ``url``, until it is closed.

    Parameters
    ----------
    port
        Of this machine; 0 takes one that is free.
    then
        Another ``progress`` that is told the same.

    Raises ModelError when the port is taken. A context manager: what leaves it waits up to some seconds until open
    pages have the end of the run, then closes the server.
    """

    every_step = False

    def __init__(self, port: int = 0, then: Callable[[float, str], None] | None = None) -> None:
        self.then, self.started = then, time.monotonic()
        self.lock = threading.Lock()
        self.instants: list[dict[str, Array]] = []
        self.stride, self.seen, self.count = 1, 0, 0
        self.about: tuple[Discretisation, Literal["static", "dynamic"]] | None = None
        self.said: tuple[float, str] = 0.0, "the run is being prepared"
        self.final: Result | None = None
        self.over = False
        self.waiting: dict[str, float] = {}  # pages that have not seen the end, and when they last asked
        handler = type("Handler", (_Handler,), {"live": self})
        try:
            self.server = _Server(("127.0.0.1", port), handler)
        except (OSError, OverflowError) as error:
            raise ModelError(f"port {port} cannot be used: {error}", "name another port, or 0 for a free one") from None
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}/"
        self.thread = threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True)
        self.thread.start()

    def __call__(self, done: float, text: str) -> None:
        """What a run says after a step."""
        self.said = done, text
        if self.then is not None:
            self.then(done, text)

    def keep(self, disc: Discretisation, kind: Literal["static", "dynamic"], instant: Mapping[str, Array]) -> None:
        """A saved instant; copied, and sometimes left out."""
        self.seen += 1
        if (self.seen - 1) % self.stride:
            return
        copied = {name: np.array(values) for name, values in instant.items()}
        with self.lock:
            self.about = disc, kind
            self.instants.append(copied)
            self.count += 1
            if len(self.instants) > INSTANTS_AT_MOST:
                self.instants, self.stride = self.instants[::2], 2 * self.stride

    def finish(self, result: Result) -> None:
        """The run has ended with this."""
        with self.lock:
            self.final, self.over = result, True
            self.count += 1

    def __enter__(self) -> Live:
        return self

    def __exit__(self, *_: object) -> None:
        self.over = True
        now = time.monotonic()
        while time.monotonic() < now + PATIENCE and any(
            now - asked < PATIENCE for asked in list(self.waiting.values())
        ):
            time.sleep(0.02)
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()

    def page(self) -> tuple[int, dict[str, Any]] | None:
        """How much there is, and the data of a page that shows it; None before the first instant."""
        with self.lock:
            count, final, about, instants = self.count, self.final, self.about, list(self.instants)
        if final is None and about is None:
            return None
        result = _so_far(*about, instants) if final is None and about is not None else final
        assert result is not None
        try:
            data: dict[str, Any] = {**page_data((result,), (result.name,)), "live": count}
        except ModelError:  # numbers that are not finite: the run will say so itself
            return None
        if final is None:
            data["runs"][0] |= {"verdict": "", "notes": [], "instants": self.seen}
        return count, data

    def state(self, after: int, who: str) -> dict[str, Any]:
        """What a page that has ``after`` does not know."""
        over, (done, line) = self.over, self.said
        left = time_left(done, time.monotonic() - self.started)
        said: dict[str, Any] = {
            "done": done,
            "line": f"{done:.0%}, {line}" + (f", {left}" if left else ""),
            "over": over,
        }
        if self.count > after:
            found = self.page()
            if found is not None:
                said |= {"count": found[0], "page": found[1]}
        self.waiting[who] = time.monotonic()
        if over:
            self.waiting.pop(who)
        return said


def _so_far(disc: Discretisation, kind: Literal["static", "dynamic"], instants: list[dict[str, Array]]) -> Result:
    """A result of what there is, for pictures alone."""
    t, r, R, v, strain, totals, work = (np.stack([i[k] for i in instants]) for k in instants[0])
    stressed = strain
    if disc.model.actuations:
        factors = t if kind == "static" else np.ones_like(t)
        stressed = strain - np.array([disc.intrinsic(*at) for at in zip(t.tolist(), factors.tolist(), strict=True)])
    none, n = np.zeros_like(t), r.shape[1]
    return Result(
        kind=kind, name=disc.model.name, mesh=disc.mesh, t=t, load_factor=t if kind == "static" else none + 1.0,
        r=r, R=R, v=v, Rdot=np.zeros((0, n, 3, 3)), reaction=np.zeros((0, n, 6)), strain=strain,
        force=disc.section_force(stressed), density=disc.stored_density(stressed),
        energy=Energy(totals[:, 1], totals[:, 0], work, none, none),
        momentum=Momentum(totals[:, 2:5], totals[:, 5:8]), iterations=np.zeros(0, np.int64),
        status=Status("done", "The run goes on."), audit=Audit(()),
    )  # fmt: skip


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A page that was closed while it was answered is nobody's concern."""


class _Handler(BaseHTTPRequestHandler):
    live: Live

    def do_GET(self) -> None:
        where = urlsplit(self.path)
        # a page of elsewhere must not read along under a name of its own for this machine
        if (self.headers.get("Host") or "").rsplit(":", 1)[0] not in ("127.0.0.1", "localhost"):
            self.send_error(403)
        elif where.path == "/":
            found = self.live.page()
            self._send("text/html", WAITING if found is None else page_text(found[1]))
        elif where.path == "/favicon.ico":  # every browser asks
            self.send_response(204)
            self.end_headers()
        elif where.path == "/state":
            after = parse_qs(where.query).get("after", ["0"])[0]
            who = f"{self.client_address[0]} {self.headers.get('User-Agent')}"
            known = int(after) if after.isdecimal() and len(after) < 12 else 0
            self._send("application/json", json.dumps(self.live.state(known, who), allow_nan=False))
        else:
            self.send_error(404)

    def _send(self, kind: str, text: str) -> None:
        body = text.encode("utf-8")
        self.send_response(200)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Says nothing: the terminal belongs to the run."""

"""A headless Chromium that a test drives over its debugging port: opens pages, presses keys, reads, takes pictures."""

from __future__ import annotations

import base64
import itertools
import json
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

CHROMIUM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
)
try:
    import websocket
except ModuleNotFoundError:
    websocket = None
MISSING = "" if CHROMIUM and websocket else "needs a chromium and websocket-client"


class Page:
    """One page: what it says on its console and what breaks in it is kept in ``errors``."""

    def __init__(
        self, port: int, url: str, *, width: int, height: int, dark: bool, files: Path | None, first: str
    ) -> None:
        target = Request(f"http://127.0.0.1:{port}/json/new?about:blank", method="PUT")
        address = json.load(urlopen(target, timeout=20))["webSocketDebuggerUrl"]
        self.socket = websocket.create_connection(address, timeout=60, suppress_origin=True)
        self.numbers, self.errors = itertools.count(1), list[str]()
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.theme(dark)
        if files is not None:
            self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(files))
        self.call("Page.addScriptToEvaluateOnNewDocument", source=first)
        self.call("Page.navigate", url=url)
        self.wait("document.documentElement?.dataset.state === 'ready'")

    def call(self, method: str, **options: Any) -> dict[str, Any]:
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": options}))
        while True:
            said = json.loads(self.socket.recv())
            kind, about = said.get("method"), said.get("params", {})
            if kind == "Runtime.exceptionThrown":
                self.errors.append(json.dumps(about["exceptionDetails"])[:600])
            elif kind == "Log.entryAdded" and about["entry"]["level"] in ("error", "warning"):
                self.errors.append(about["entry"]["text"])
            elif kind == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning", "assert"):
                self.errors.append(json.dumps(about["args"]))
            if said.get("id") == number:
                assert "error" not in said, said["error"]
                return said["result"]

    def theme(self, dark: bool) -> None:
        feature = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[feature])

    def run(self, code: str) -> Any:
        """The value of an expression in the page; a promise is waited for."""
        done = self.call("Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in done, done["exceptionDetails"]
        return done["result"].get("value")

    def wait(self, code: str, seconds: float = 60.0) -> None:
        """Until an expression is true."""
        end = time.monotonic() + seconds
        while not self.run(code):
            assert time.monotonic() < end, f"never came true: {code}; {self.errors}"
            time.sleep(0.05)

    def press(self, key: str) -> None:
        pressed = f"new KeyboardEvent('keydown', {{ key: {json.dumps(key)}, bubbles: true }})"
        self.run(f"document.body.dispatchEvent({pressed})")

    def choose(self, name: str, value: str) -> None:
        """Take an entry of a list."""
        at = f"document.getElementById({json.dumps(name)})"
        self.run(f"{at}.value = {json.dumps(value)}; {at}.dispatchEvent(new Event('change'))")

    def settle(self) -> None:
        """Until what was asked for is drawn."""
        self.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def picture(self, path: Path | None = None) -> bytes:
        """The page as PNG."""
        self.settle()
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        if path is not None:
            path.write_bytes(data)
        return data

    def close(self) -> None:
        self.socket.close()


class Browser:
    def __init__(self, port: int) -> None:
        self.port = port

    @contextmanager
    def open(
        self,
        url: str,
        *,
        width: int = 1200,
        height: int = 800,
        dark: bool = False,
        files: Path | None = None,
        first: str = "",
    ) -> Iterator[Page]:
        """``files`` is the folder for what the page saves, ``first`` a script that runs before its own."""
        page = Page(self.port, url, width=width, height=height, dark=dark, files=files, first=first)
        try:
            yield page
        finally:
            page.close()


@contextmanager
def browser(profile: Path, *flags: str) -> Iterator[Browser]:
    """Start one and end it."""
    process = subprocess.Popen(
        [
            CHROMIUM, "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader", "--disable-background-networking", "--no-first-run", "--hide-scrollbars",
            "--remote-debugging-port=0", f"--user-data-dir={profile}", *flags, "about:blank",
        ],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        told, end = profile / "DevToolsActivePort", time.monotonic() + 60
        while not (told.is_file() and told.read_text().count("\n")):
            assert process.poll() is None and time.monotonic() < end, "the browser does not start"
            time.sleep(0.05)
        yield Browser(int(told.read_text().split()[0]))
    finally:
        process.terminate()
        process.wait(30)

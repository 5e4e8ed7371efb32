"""A headless Chromium for tests, spoken to through two pipes (DevTools protocol)."""

import base64
import io
import json
import os
import select
import shutil
import subprocess
import time

import numpy as np
from PIL import Image

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
_PATIENCE = 60.0


class Browser:
    """One page in a browser without window; use it in a ``with`` block."""

    def __init__(self, profile, *, webgl=True, size=(1200, 1000)):
        to_browser, from_browser = os.pipe(), os.pipe()
        command = [
            CHROMIUM, "--headless=new", "--no-sandbox", "--no-first-run", "--disable-extensions",
            "--disable-background-networking", "--disable-component-update", "--disable-sync",
            "--disable-default-apps", "--mute-audio", "--hide-scrollbars",
            f"--user-data-dir={profile}",
            "--remote-debugging-pipe",
            *(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
              if webgl else ["--disable-gpu", "--disable-3d-apis"]),
        ]  # fmt: skip
        words = 'exec "$@" 3<&"$0" 4>&"$SINK"'
        self._process = subprocess.Popen(
            ["bash", "-c", words, str(to_browser[0]), *command],
            pass_fds=(to_browser[0], from_browser[1]),
            env={**os.environ, "SINK": str(from_browser[1])},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser[0])
        os.close(from_browser[1])
        self._sink, self._source = to_browser[1], from_browser[0]
        self._buffer, self._number, self._session = b"", 0, None
        self._size = size
        self.events = []

    def __enter__(self):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.resize(*self._size)
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        os.close(self._sink)
        os.close(self._source)

    def call(self, method, **parameters):
        """Send a command and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._sink, json.dumps(message).encode() + b"\0")
        number = self._number
        while True:
            answer = self._read()
            if answer.get("id") == number:
                assert "error" not in answer, answer["error"]
                return answer["result"]

    def open(self, address):
        """Load a page; return the seconds until it is there and has answered."""
        begin, seen = time.monotonic(), len(self.events)
        self.call("Page.navigate", url=address)
        while not any(event["method"] == "Page.loadEventFired" for event in self.events[seen:]):
            self._read()
        frames = "requestAnimationFrame(() => requestAnimationFrame(done))"
        self.run(f"new Promise((done) => {frames}).then(() => true)")
        return time.monotonic() - begin

    def resize(self, width, height, **more):
        """Give the window a size, CSS px."""
        device = {"deviceScaleFactor": 1, "mobile": False, **more}
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, **device)
        self._size = width, height

    def run(self, script):
        """Value of an expression of JavaScript in the page."""
        answer = self.call(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def mouse(self, kind, x, y, **more):
        """Do something with the mouse at px of the window."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def click(self, x, y):
        """Press and release the left button."""
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", clickCount=1)

    def settle(self):
        """Wait until what was asked for is drawn."""
        self.run("new Promise((done) => setTimeout(() => requestAnimationFrame(done), 50))")

    def screenshot(self, **clip):
        """What is seen, (H, W, 3) uint8; of `clip` (x, y, width, height) beyond the window too."""
        more = {"clip": {**clip, "scale": 1}, "captureBeyondViewport": True} if clip else {}
        data = base64.b64decode(self.call("Page.captureScreenshot", **more)["data"])
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))

    @property
    def complaints(self):
        """Errors and warnings of the page and its console."""
        kinds = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
        return [event["params"] for event in self.events if event["method"] in kinds]

    @property
    def requests(self):
        """Addresses that were asked for."""
        sent = [e for e in self.events if e["method"] == "Network.requestWillBeSent"]
        return [event["params"]["request"]["url"] for event in sent]

    def _read(self):
        """Next message; events are kept."""
        deadline = time.monotonic() + _PATIENCE
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._source], [], [], deadline - time.monotonic())
            assert ready, "the browser does not answer"
            part = os.read(self._source, 1 << 20)
            assert part, "the browser has ended"
            self._buffer += part
        text, _, self._buffer = self._buffer.partition(b"\0")
        message = json.loads(text)
        if "method" in message:
            self.events.append(message)
        return message

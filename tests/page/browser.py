"""A page in headless Chromium: opened, queried and photographed through the DevTools protocol over a pipe, without
other dependencies."""

import base64
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

SECONDS = 120
STARTS = 4


def program():
    """The path of the browser, or None."""
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Browser:
    """One page of `size` pixels. `trouble` contains errors and warnings of the console."""

    def __init__(self, size=(1200, 800), scheme="light"):
        for _ in range(STARTS):
            self.start(size, scheme)
            if self.evaluate("document.createElement('canvas').getContext('webgl2') !== null"):
                return
            self.__exit__()  # on a loaded machine the GPU process sometimes ends permanently
        raise RuntimeError(f"Chromium draws nothing (WebGL 2 is off) in {STARTS} starts")

    def start(self, size, scheme):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_browser, self.out = os.pipe()
        self.answers, from_browser = os.pipe()

        def pipes():  # the protocol uses file descriptors 3 and 4
            os.dup2(to_browser, 13)
            os.dup2(from_browser, 14)
            os.dup2(13, 3)
            os.dup2(14, 4)
            os.set_inheritable(3, True)
            os.set_inheritable(4, True)

        self.process = subprocess.Popen(
            [program(), "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--disable-gpu-sandbox", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-first-run", "--disable-extensions", "--disable-background-networking",
             "--disable-component-update", "--hide-scrollbars", f"--user-data-dir={self.profile.name}", "about:blank"],
            preexec_fn=pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        os.close(to_browser)
        os.close(from_browser)
        self.buffer, self.number, self.trouble = b"", 0, []
        self.session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
        self.scheme(scheme)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.out)
        os.close(self.answers)
        self.profile.cleanup()

    def scheme(self, scheme):
        """Sets the preferred colour scheme of the system, light or dark."""
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.next_message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def next_message(self):
        while b"\0" not in self.buffer:
            part = os.read(self.answers, 1 << 20)
            if not part:
                raise RuntimeError("the browser is gone")
            self.buffer += part
        text, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(text)
        self.listen(message)
        return message

    def listen(self, message):
        parameters = message.get("params", {})
        method = message.get("method")
        if method == "Runtime.exceptionThrown":
            self.trouble.append(json.dumps(parameters["exceptionDetails"])[:2000])
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            self.trouble.append(" ".join(str(a.get("value", a.get("description"))) for a in parameters["args"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning"):
            self.trouble.append(parameters["entry"]["text"])
        elif method == "Network.requestWillBeSent" and parameters["request"]["url"].startswith(("http", "ws")):
            self.trouble.append("asks for " + parameters["request"]["url"])

    def open(self, path):
        """Opens a page of Camber, waits until it is drawn, and returns the milliseconds that the page measured."""
        self.call("Page.navigate", url=pathlib.Path(path).resolve().as_uri())
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            state = self.evaluate("document.documentElement?.dataset.state ?? ''")
            if state == "failed":
                raise RuntimeError("the page failed: " + self.evaluate("document.getElementById('trouble').textContent"))
            if state == "drawn":
                return int(self.evaluate("document.documentElement.dataset.firstFrame"))
            time.sleep(0.05)
        raise TimeoutError(f"{path} is not drawn after {SECONDS} s; {self.trouble}")

    def evaluate(self, expression):
        """Returns the value of a JavaScript expression; waits for promises."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(json.dumps(answer["exceptionDetails"])[:2000])
        return answer["result"].get("value")

    def press(self, key):
        self.evaluate(f"document.dispatchEvent(new KeyboardEvent('keydown', {{key: {json.dumps(key)}, bubbles: true}}))")
        self.settle()

    def settle(self):
        """Waits until pending changes are drawn."""
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30))))")

    def picture(self, path=None):
        """Returns a PNG of the window in base64; writes it to `path` if set."""
        data = self.call("Page.captureScreenshot", format="png")["data"]
        if path:
            pathlib.Path(path).write_bytes(base64.b64decode(data))
        return data

    def silhouette(self):
        """Returns the number of pixels of the mesh and the width and height of their bounding box."""
        self.evaluate("""(() => { const s = document.createElement('style'); s.id = 'bare';
            s.textContent = '#stage{background:#0f0!important}.card,#pin{display:none!important}canvas{box-shadow:none!important}';
            document.head.append(s); })()""")
        self.settle()
        data = self.picture()
        counts = self.evaluate(f"""(async () => {{
            const image = await createImageBitmap(await (await fetch('data:image/png;base64,{data}')).blob());
            const box = document.getElementById('canvas').getBoundingClientRect();
            const paper = new OffscreenCanvas(box.width, box.height).getContext('2d');
            paper.drawImage(image, -box.left, -box.top);
            const p = paper.getImageData(0, 0, box.width, box.height).data;
            let area = 0, left = 1e9, right = -1, top = 1e9, bottom = -1;
            for (let y = 0, i = 0; y < box.height; ++y) for (let x = 0; x < box.width; ++x, i += 4) {{
                const cover = 1 - Math.max(p[i + 1] - Math.max(p[i], p[i + 2]), 0) / 255;
                area += cover;
                if (cover > 0.5) {{ left = Math.min(left, x); right = Math.max(right, x); top = Math.min(top, y); bottom = Math.max(bottom, y); }}
            }}
            return [area, right - left + 1, bottom - top + 1];
        }})()""")
        self.evaluate("document.getElementById('bare').remove()")
        return counts

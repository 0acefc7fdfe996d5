"""Chromium without a window, controlled through its debugging pipe (the DevTools protocol)."""
import atexit
import base64
import json
import os
import shutil
import subprocess
import tempfile
from functools import cache

PROGRAM = shutil.which("chromium")


class Chromium:
    """The process of the browser, started once for all pages of a test and ended with it."""

    def __init__(self):
        self.profile = tempfile.TemporaryDirectory(prefix="chromium-", ignore_cleanup_errors=True)
        options = ["--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
                   "--disable-background-networking", "--remote-debugging-pipe", "--window-size=1200,800",
                   f"--user-data-dir={self.profile.name}", "about:blank"]  # fmt: skip
        to_read, self.write_end = os.pipe()
        read_end, to_write = os.pipe()
        # The protocol uses the descriptors 3 and 4.
        shell = ["bash", "-c", f'exec "$@" 3<&{to_read} 4>&{to_write}', "bash", PROGRAM, *options]
        quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(shell, pass_fds=(to_read, to_write), **quiet)
        os.close(to_read), os.close(to_write)
        self.answers = os.fdopen(read_end, "rb")
        self.calls = 0
        atexit.register(self.end)

    def end(self):
        self.process.terminate()
        self.process.wait()
        os.close(self.write_end)
        self.answers.close()
        self.profile.cleanup()


started = cache(Chromium)


class Browser:
    """One page, open during the `with` block. `complaints` are the console's errors, warnings and exceptions."""

    def __init__(self, path):
        self.address = "file://" + os.path.abspath(path)
        self.complaints = []

    def __enter__(self):
        self.chromium = started()
        self.open_page()
        return self

    def __exit__(self, *_):
        self.session = None
        self.call("Target.closeTarget", targetId=self.target)

    def open_page(self):
        self.session = None
        self.target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=self.target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        self.call("Page.navigate", url=self.address)
        self.wait_for("document.body && document.body.dataset.ready")

    def call(self, method, **parameters):
        self.chromium.calls += 1
        message = {"id": self.chromium.calls, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.chromium.write_end, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read_message()
            if answer.get("id") == message["id"]:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.note(answer)

    def read_message(self):
        text = bytearray()
        while (byte := self.chromium.answers.read(1)) != b"\0":
            if not byte:
                raise RuntimeError("chromium has ended")
            text += byte
        return json.loads(text)

    def note(self, event):
        if event.get("sessionId") != self.session:  # of a page that was closed
            return
        kind, details = event.get("method"), event.get("params", {})
        if kind == "Runtime.exceptionThrown":
            self.complaints.append(details["exceptionDetails"]["exception"]["description"])
        if kind == "Runtime.consoleAPICalled" and details["type"] in ("error", "warning"):
            self.complaints.append(str([entry.get("value") for entry in details["args"]]))
        if kind == "Log.entryAdded" and details["entry"]["level"] in ("error", "warning"):
            self.complaints.append(details["entry"]["text"])

    def value(self, expression):
        """Value of a JavaScript expression in the page, after a `Promise` if it is one."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"]["exception"].get("description", expression))
        return answer["result"].get("value")

    def wait_for(self, expression):
        """Waits until the expression is true, for at most ten minutes."""
        for _ in range(6000):
            if self.value(expression):
                return
            self.value("new Promise(done => setTimeout(done, 100))")
        raise RuntimeError(f"{expression} did not come true; the console says {self.complaints}")

    def choose(self, control, value):
        """Sets a slider or a list by its id, as a user does."""
        self.value(f"""{{ const control = document.getElementById({json.dumps(control)});
            if (control.type === "checkbox") control.checked = {json.dumps(value)};
            else control.value = {json.dumps(value)};
            control.dispatchEvent(new Event("input")), control.dispatchEvent(new Event("change")); }}""")

    def picture(self):
        """Picture of the page as PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot")["data"])

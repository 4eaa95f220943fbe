"""A headless Chromium to test pages, by the DevTools protocol on a pipe: no port, no driver."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

BROWSER = shutil.which('chromium') or shutil.which('chromium-browser')
DEADLINE_S = 300.0


class Browser:
    """A page in a browser that has no network but this machine's.

    Args:
        folder: for the profile.
    """

    def __init__(self, folder: Path) -> None:
        assert BROWSER is not None
        to_read, self._out = os.pipe()
        self._in, to_write = os.pipe()
        # Chromium reads commands from descriptor 3 and answers on 4
        command = f'exec "$0" "$@" 3<&{to_read} 4>&{to_write}'
        self._process = subprocess.Popen(
            [
                *('bash', '-c', command, BROWSER, '--headless=new', '--no-sandbox'),
                *('--disable-gpu', '--remote-debugging-pipe', f'--user-data-dir={folder}'),
                *('--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1', 'about:blank'),
            ],
            pass_fds=(to_read, to_write),
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self._buffer, self._last, self._session = b'', 0, ''
        self.faults: list[str] = []
        target = self.ask('Target.createTarget', url='about:blank')['targetId']
        attached = self.ask('Target.attachToTarget', targetId=target, flatten=True)
        self._session = attached['sessionId']
        for domain in ('Page', 'Runtime', 'Log'):
            self.ask(f'{domain}.enable')

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait()
        os.close(self._out)
        os.close(self._in)

    def ask(self, method: str, **parameters: Any) -> Any:
        """Send a command and return its result; note errors of the console on the way."""
        self._last += 1
        message: dict[str, Any] = {'id': self._last, 'method': method, 'params': parameters}
        if self._session:
            message['sessionId'] = self._session
        os.write(self._out, json.dumps(message).encode() + b'\0')
        while True:
            said = self._next()
            if said.get('id') == self._last:
                assert 'error' not in said, said['error']
                return said['result']

    def show(self, page: Path, width: int, *, dark: bool) -> None:
        """Open a page at a width [pixels] and wait until an expression finds it drawn."""
        self.ask(
            'Emulation.setDeviceMetricsOverride',
            width=width,
            height=1000,
            deviceScaleFactor=1,
            mobile=width < 600,
        )
        scheme = {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}
        self.ask('Emulation.setEmulatedMedia', features=[scheme])
        self.faults.clear()
        self.ask('Page.navigate', url=page.as_uri())
        deadline = time.monotonic() + DEADLINE_S
        while not self.run('document.readyState === "complete"'):
            assert time.monotonic() < deadline, f'{page}: was not drawn'
            time.sleep(0.1)

    def run(self, script: str) -> Any:
        """Return the value of an expression."""
        found = self.ask('Runtime.evaluate', expression=script, returnByValue=True)
        assert 'exceptionDetails' not in found, found
        return found['result'].get('value')

    def press(self, key: str, code: int, text: str = '') -> None:
        """Press and release a key, as a hand would."""
        keys = {'key': key, 'windowsVirtualKeyCode': code}
        self.ask('Input.dispatchKeyEvent', type='keyDown', text=text, **keys)
        self.ask('Input.dispatchKeyEvent', type='keyUp', **keys)

    def screenshot(self, file: Path) -> None:
        """Write a screenshot as PNG."""
        file.write_bytes(base64.b64decode(self.ask('Page.captureScreenshot')['data']))

    def _next(self) -> dict[str, Any]:
        while b'\0' not in self._buffer:
            ready, _, _ = select.select([self._in], [], [], DEADLINE_S)
            assert ready, 'the browser is silent'
            chunk = os.read(self._in, 1 << 20)
            assert chunk, 'the browser has ended'
            self._buffer += chunk
        line, _, self._buffer = self._buffer.partition(b'\0')
        said: dict[str, Any] = json.loads(line)
        if said.get('method') == 'Runtime.exceptionThrown' or (
            said.get('method') == 'Log.entryAdded' and said['params']['entry']['level'] == 'error'
        ):
            self.faults.append(json.dumps(said['params']))
        if said.get('method') == 'Runtime.consoleAPICalled' and said['params']['type'] == 'error':
            self.faults.append(json.dumps(said['params']['args']))
        return said

"""Links to try out: a web server on loopback, qs-fetch's daemon with a slow link in it, and a relay that is as slow for
other programs."""
import asyncio
import contextlib
import json
import os
import shutil
import socket
import subprocess
import threading
import time

from .programs import read

RATES = {"384 kbit/s": ("384k", 384e3 / 8), "8 Mbit/s": ("8M", 8e6 / 8), "100 Mbit/s": ("100M", 100e6 / 8)}
ROUND_TRIPS_MS = [5, 40, 150]
NGINX = """
daemon off; worker_processes 1; pid {folder}/nginx.pid; error_log {folder}/nginx.log; {user}
events {{}}
http {{
    access_log off; sendfile on; tcp_nopush off; keepalive_requests 100000;
    client_body_temp_path {folder}/t1; proxy_temp_path {folder}/t2; fastcgi_temp_path {folder}/t3;
    uwsgi_temp_path {folder}/t4; scgi_temp_path {folder}/t5;
    server {{ listen 127.0.0.1:{port}; root {root}; }}
}}
"""


class Link:
    def __init__(self, rate_name, round_trip_ms):
        self.rate_name, self.round_trip_ms = rate_name, round_trip_ms
        self.rate, self.bytes_per_s = RATES[rate_name]
        self.round_trip_s = round_trip_ms / 1000
        self.name = f"{rate_name} {round_trip_ms} ms"

    def daemon_options(self):
        return ["--limit-rate", self.rate, "--delay", f"{self.round_trip_ms}ms"]


LINKS = [Link(rate, ms) for rate in RATES for ms in ROUND_TRIPS_MS]


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for(condition, what):
    for _ in range(500):
        if condition():
            return
        time.sleep(0.02)
    raise SystemExit(f"bench: {what} does not start")


def answers(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@contextlib.contextmanager
def ended(process):
    """Ends it in any case."""
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


@contextlib.contextmanager
def web_server(folder, root):
    """nginx, which serves a folder; gives its port."""
    port = free_port()
    user = "user root;" if os.geteuid() == 0 else ""
    (folder / "nginx.conf").write_text(NGINX.format(folder=folder, root=root, port=port, user=user))
    process = subprocess.Popen([nginx_program(), "-c", folder / "nginx.conf"], stderr=subprocess.DEVNULL)
    with ended(process):
        wait_for(lambda: answers(port), "nginx")
        yield port


def nginx_program():
    return shutil.which("nginx", path="/usr/sbin:/usr/bin:/usr/local/sbin:/usr/local/bin")


@contextlib.contextmanager
def daemon(bench, cache, link=None, keep=False):
    """qs-fetch's daemon, with an empty cache unless `keep`; gives its process."""
    if not keep:
        shutil.rmtree(cache, ignore_errors=True)
    program = bench.program("qs-fetch")
    options = link.daemon_options() if link else []
    process = subprocess.Popen([program, "serve", "--cache", cache, "--quiet", *options], stderr=subprocess.DEVNULL)
    with ended(process):
        wait_for(lambda: (cache / "socket").exists(), "qs-fetch")
        yield process


def status(bench, cache):
    return json.loads(read(bench.program("qs-fetch"), "status", "--json", "--cache", cache))


class Relay(threading.Thread):
    """Carries TCP connections to a port, their answers as slowly as a link: at its rate, a round trip late, and a new
    connection's another round trip."""

    def __init__(self, link, port):
        super().__init__(daemon=True)
        self.link, self.to, self.port = link, port, free_port()
        self.free_at = 0.0
        self.is_ready = threading.Event()

    def run(self):
        with contextlib.suppress(asyncio.CancelledError):
            asyncio.run(self.serve())

    async def serve(self):
        self.loop = asyncio.get_running_loop()
        self.serving = asyncio.current_task()
        async with await asyncio.start_server(self.carry, "127.0.0.1", self.port) as server:
            self.is_ready.set()
            await server.serve_forever()

    def end(self):
        self.loop.call_soon_threadsafe(self.serving.cancel)
        self.join()

    async def carry(self, reader, writer):
        up_reader, up_writer = await asyncio.open_connection("127.0.0.1", self.to)
        opened = time.monotonic() + self.link.round_trip_s
        waiting = asyncio.Queue()
        # Held, or they could be collected while they run.
        up, down = (asyncio.create_task(task) for task in (self.pass_up(reader, up_writer), self.pass_down(waiting, writer)))
        while chunk := await up_reader.read(16384):
            waiting.put_nowait((max(time.monotonic(), opened) + self.link.round_trip_s, chunk))
        waiting.put_nowait((0, b""))
        await down
        up.cancel()

    @staticmethod
    async def pass_up(reader, writer):
        while chunk := await reader.read(16384):
            writer.write(chunk)

    async def pass_down(self, waiting, writer):
        while True:
            ready, chunk = await waiting.get()
            if not chunk:
                break
            self.free_at = max(self.free_at, ready) + len(chunk) / self.link.bytes_per_s
            await asyncio.sleep(self.free_at - time.monotonic())
            writer.write(chunk)
            with contextlib.suppress(ConnectionError):
                await writer.drain()
        writer.close()


@contextlib.contextmanager
def relay(link, port):
    carrier = Relay(link, port)
    carrier.start()
    carrier.is_ready.wait()
    try:
        yield carrier.port
    finally:
        carrier.end()

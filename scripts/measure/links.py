"""Links to try out: a web server on loopback, qs-fetch's daemon with a slow link in it, and a relay that is as slow for
other programs."""
import contextlib
import json
import os
import queue
import shutil
import socket
import subprocess
import threading
import time

from .programs import read

RATES = {"384 kbit/s": ("384k", 384e3 / 8), "8 Mbit/s": ("8M", 8e6 / 8), "100 Mbit/s": ("100M", 100e6 / 8)}
ROUND_TRIPS_MS = [5, 40, 150]
FIRST_WINDOW = 10 * 1460  # bytes of a TCP connection's first round trip (RFC 6928)
NGINX = """
daemon off; worker_processes 1; pid {folder}/nginx.pid; error_log {folder}/nginx.log; {user}
events {{}}
http {{
    access_log off; sendfile on; tcp_nopush off; keepalive_requests 100000;
    client_body_temp_path {folder}/t1; proxy_temp_path {folder}/t2; fastcgi_temp_path {folder}/t3;
    uwsgi_temp_path {folder}/t4; scgi_temp_path {folder}/t5;
    server {{ listen 127.0.0.1:{port}{tls}; root {root}; }}
}}
"""
TLS = " ssl http2; ssl_certificate {certificate}; ssl_certificate_key {certificate}"


class Link:
    def __init__(self, rate_name, round_trip_ms):
        self.rate_name, self.round_trip_ms = rate_name, round_trip_ms
        self.rate, self.bytes_per_s = RATES[rate_name]
        self.round_trip_s = round_trip_ms / 1000
        self.name = f"{rate_name} {round_trip_ms} ms"

    def seconds_for(self, size):
        """To carry so many bytes on one new connection, as TCP begins."""
        seconds, window = 2 * self.round_trip_s, FIRST_WINDOW
        while size > window and window < self.bytes_per_s * self.round_trip_s:
            size -= window
            seconds += self.round_trip_s
            window *= 2
        return seconds + size / self.bytes_per_s

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


def make_certificate(file):
    """Of a server at 127.0.0.1, that vouches for itself, and its key."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost",
                    "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", file, "-out", file.with_suffix(".only")],
                   check=True, stderr=subprocess.DEVNULL)
    with open(file, "ab") as both:
        both.write(file.with_suffix(".only").read_bytes())


@contextlib.contextmanager
def web_server(folder, root, certificate=None):
    """nginx, which serves a folder, over TLS where it has a certificate; gives its port."""
    port = free_port()
    user = "user root;" if os.geteuid() == 0 else ""
    tls = TLS.format(certificate=certificate) if certificate else ""
    (folder / "nginx.conf").write_text(NGINX.format(folder=folder, root=root, port=port, user=user, tls=tls))
    process = subprocess.Popen([nginx_program(), "-c", folder / "nginx.conf"], stderr=subprocess.DEVNULL)
    with ended(process):
        wait_for(lambda: answers(port), "nginx")
        yield port


def nginx_program():
    return shutil.which("nginx", path="/usr/sbin:/usr/bin:/usr/local/sbin:/usr/local/bin")


@contextlib.contextmanager
def daemon(bench, cache, link=None, keep=False, certificate=None):
    """qs-fetch's daemon, with an empty cache unless `keep`, that trusts a certificate; gives its process."""
    if not keep:
        shutil.rmtree(cache, ignore_errors=True)
    program = bench.program("qs-fetch")
    options = link.daemon_options() if link else []
    if certificate:
        options += ["--cacert", certificate]
    process = subprocess.Popen([program, "serve", "--cache", cache, "--quiet", *options], stderr=subprocess.DEVNULL)
    with ended(process):
        wait_for(lambda: (cache / "socket").exists(), "qs-fetch")
        yield process


def status(bench, cache):
    return json.loads(read(bench.program("qs-fetch"), "status", "--json", "--cache", cache))


class Relay:
    """Carries TCP connections to a port, their answers as slowly as a link: at its rate, a round trip late, and a new
    connection's another round trip; it begins as slowly as over the link in qs-fetch (slow_link.h)."""

    def __init__(self, link, port):
        self.link, self.to = link, port
        self.free_at, self.lock = 0.0, threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        with contextlib.suppress(OSError):  # it was closed
            while True:
                client, _ = self.listener.accept()
                threading.Thread(target=self.carry, args=[client], daemon=True).start()

    def carry(self, client):
        opened = time.monotonic() + self.link.round_trip_s
        with contextlib.suppress(OSError), client, socket.create_connection(("127.0.0.1", self.to)) as server:
            threading.Thread(target=pass_on, args=[client, server], daemon=True).start()
            waiting = queue.SimpleQueue()
            threading.Thread(target=self.read, args=[server, opened, waiting], daemon=True).start()
            while chunk := waiting.get():
                ready, data = chunk
                with self.lock:
                    self.free_at = max(self.free_at, ready) + len(data) / self.link.bytes_per_s
                    due = self.free_at
                time.sleep(max(0, due - time.monotonic()))
                client.sendall(data)

    def read(self, server, opened, waiting):
        window, in_round, round_began, ready = FIRST_WINDOW, 0, 0.0, 0.0
        with contextlib.suppress(OSError):
            while data := server.recv(1460):
                ready = max(max(time.monotonic(), opened) + self.link.round_trip_s, ready)
                next_round = round_began + self.link.round_trip_s
                if ready >= next_round or in_round + len(data) > window:
                    ready = max(ready, next_round)
                    if 2 * (in_round + len(data)) > window:
                        window *= 2
                    round_began, in_round = ready, 0
                in_round += len(data)
                waiting.put((ready, data))
        waiting.put(None)


def pass_on(source, sink):
    with contextlib.suppress(OSError):
        while data := source.recv(16384):
            sink.sendall(data)


@contextlib.contextmanager
def relay(link, port):
    carrier = Relay(link, port)
    try:
        yield carrier.port
    finally:
        carrier.listener.close()

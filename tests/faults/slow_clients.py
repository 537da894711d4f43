"""Slow clients, held by nginx with deploy/nginx.conf in front."""

import re
import shutil
import subprocess
import time

from harness import Server, check, percentile
from recalls import latencies_ms, store_sites

CONFIGURATION = """daemon off; pid {work}/pid; error_log {work}/error.log; worker_processes 1;
worker_rlimit_nofile 16384;
events {{ worker_connections 8192; }}
http {{
  access_log off;
  client_body_temp_path {work}/body; proxy_temp_path {work}/proxy;
  fastcgi_temp_path {work}/fastcgi; uwsgi_temp_path {work}/uwsgi; scgi_temp_path {work}/scgi;
  include {work}/freelsd.conf;
}}
"""


def missing(tools):
    """Programs that the row needs and are not there."""
    return [name for name in ("nginx", "slowhttptest", "openssl")
            if not (getattr(tools, name, None) or shutil.which(name))]


def configure(tools, work, server, port):
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout",
                    work / "key.pem", "-out", work / "certificate.pem", "-days", "2", "-subj",
                    "/CN=localhost"], check=True, capture_output=True)
    text = (tools.root / "deploy/nginx.conf").read_text()
    text = text.replace("/etc/freelsd/tls", str(work))
    text = text.replace("listen 443 ssl", f"listen 127.0.0.1:{port} ssl")
    text = re.sub(r"(?m)^.*listen \[::\].*$", "", text)
    text = text.replace("127.0.0.1:8080", f"127.0.0.1:{server.port}")
    text = text.replace("127.0.0.1:8081", f"127.0.0.1:{server.emergency_port}")
    (work / "freelsd.conf").write_text(text)
    (work / "nginx.conf").write_text(CONFIGURATION.format(work=work))


def attacks(url, seconds):
    """As the issue counts them: slow heads, slow bodies, slow readers."""
    common = ["slowhttptest", "-r", "200", "-l", str(seconds), "-u"]
    yield common + [url + "/healthz", "-c", "1000", "-H", "-i", "10"]
    yield common + [url + "/v1/flights", "-c", "500", "-B", "-i", "5", "-s", "8192"]
    yield common + [url + "/openapi.json", "-c", "500", "-X", "-w", "1", "-y", "1", "-n", "5"]


def free_port():
    import socket
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def run(tools, folder, flight_files, seconds):
    work = folder / "nginx"
    work.mkdir()
    server = Server(tools, folder / "data")
    store_sites(server, folder)
    with server:
        port = free_port()
        configure(tools, work, server, port)
        children = [subprocess.Popen(["nginx", "-c", work / "nginx.conf"])]
        try:
            time.sleep(1)
            calm_ms = latencies_ms(server, 3)
            before_mib = server.resident_mib()
            for command in attacks(f"https://127.0.0.1:{port}", seconds):
                children.append(subprocess.Popen(
                    command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
            times_ms = latencies_ms(server, seconds)
            grown_mib = server.resident_mib() - before_mib
            check(children[0].poll() is None, "nginx ended")
        finally:
            for child in children:
                child.terminate()
                child.wait()
    p99_ms = percentile(times_ms, 0.99)
    return (f"1000 slow heads, 500 slow bodies and 500 slow readers for {seconds} s: recall p50 "
            f"{percentile(times_ms, 0.5):.1f} ms, p99 {p99_ms:.1f} ms (alone p99 "
            f"{percentile(calm_ms, 0.99):.1f} ms), memory {grown_mib:+.1f} MiB"), \
        p99_ms <= 50 and grown_mib < 64

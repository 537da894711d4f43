"""compose.fleet.yaml against the server's options, the Dockerfile and nginx' template; it starts no container.

    python3 tests/deploy/compose_fleet.py FREELSD_SERVER
"""

import re
import subprocess
import sys
from pathlib import Path

try:
    import yaml
except ImportError:
    print("skipped: compose.fleet.yaml is not checked, there is no python3-yaml")
    sys.exit()

deploy = Path(__file__).resolve().parents[2] / "deploy"
services = yaml.safe_load((deploy / "compose.fleet.yaml").read_text())["services"]
options = set(re.findall(r"--[a-z-]+", subprocess.run(
    [sys.argv[1], "--help"], capture_output=True, text=True, check=True).stdout))
for name in ("api-1", "api-2", "worker"):
    service = services[name]
    given = [word.partition("=")[0] for word in service["command"]]
    assert set(given) <= options and len(given) == len(set(given)), (name, given)
    assert (deploy / service["build"]["context"] / service["build"]["dockerfile"]).is_file()
    inside = {mount.split(":")[-2] for mount in service["volumes"]}
    for word in service["command"]:
        path = word.partition("=")[2]
        if path.startswith("/etc/"):
            assert path in inside, (name, path)
words = set(re.findall(r"\$\{(FREELSD_[A-Z_0-9]+)\}", (deploy / "fleet/nginx.conf.template").read_text()))
assert words == set(services["nginx"]["environment"]), words
for mount in services["nginx"]["volumes"]:
    source = mount.split(":")[0]
    assert not source.startswith("./") or (deploy / source).exists(), source
print("compose.fleet.yaml names existing options, files and words; no container was started")

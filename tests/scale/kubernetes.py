"""Checks the environment of the Kubernetes manifests: every REVPRIO_… variable is a setting with a valid value.

Usage: kubernetes.py MANIFESTS PROGRAM. The schemas are checked by `kubernetes-validate`.
"""

import os
import subprocess
import sys
from pathlib import Path

import yaml


def main(manifests: str, program: str) -> None:
    documents = list(yaml.safe_load_all(Path(manifests).read_text()))
    by_kind = {document["kind"]: document for document in documents}
    pod = by_kind["Deployment"]["spec"]["template"]
    labels = pod["metadata"]["labels"].items()
    for kind in ("Service", "PodDisruptionBudget"):
        selector = by_kind[kind]["spec"]["selector"]
        assert selector.get("matchLabels", selector).items() <= labels, f"{kind} selects no pod"
    environment = {entry["name"]: entry["value"] for entry in pod["spec"]["containers"][0]["env"]}
    output = subprocess.run([program, "config"], env=os.environ | environment, capture_output=True, text=True)
    assert output.returncode == 0, output.stderr
    for name in environment:
        assert f"# environment, {name}\n" in output.stdout, f"{name} is not a setting"
    drain_s = float(environment["REVPRIO_DRAIN_DELAY_S"])
    assert pod["spec"]["terminationGracePeriodSeconds"] > drain_s + 1, "pods are killed while they drain"
    print(f"{len(environment)} settings are valid")


if __name__ == "__main__":
    main(*sys.argv[1:])

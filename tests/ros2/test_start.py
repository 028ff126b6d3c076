"""Wrong parameters are refused with a sentence, and the launch file fits the node."""

import json
import xml.etree.ElementTree as xml

import pytest
from harness import PACKAGE, free_port

PUSH = PACKAGE / "config/wall.json"


@pytest.fixture
def push(lab, scenario):
    """Returns the path of a good controller."""
    return lab.file("push.json", json.dumps(scenario["controller"]))


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"controller": "''"}, "parameter `controller` is empty; set it to a preset"),
        ({"controller": "/none.json"}, "parameter `controller`: cannot read the file /none.json"),
        ({"controller": str(PUSH)}, "parameter `controller`: /"),
        ({"controller": "push panda z"}, "parameter `controller`: 'push panda z' lacks a word; write push ROBOT AXIS"),
        ({"controller": "'{]'"}, "parameter `controller` is not valid JSON"),
        ({"max_age_s": "5.0"}, "parameter `max_age_s`: 5.0 must be a value of type double from 0.002 to 0.1"),
        ({"max_age_s": "soon"}, "parameter `max_age_s`: 'soon' must be a value of type double"),
        ({"period_s": "0.0001"}, "parameter `period_s`: 0.0001 is shorter than 0.001 s"),
        ({"output": "torque"}, "parameter `output`: 'torque' is not one of velocity, trajectory, both"),
        ({"sensor_pose": "[0.0, 1.0]"}, "parameter `sensor_pose`: [0.0, 1.0] must be seven numbers"),
        ({"wrench_convention": "up"}, "parameter `controller`: /wrench_convention"),
        ({"token_file": "/none"}, "parameter `token_file`: cannot read the file /none"),
        ({"url": "http://"}, "is not the address of a service"),
    ],
)
def test_wrong_parameters_are_refused_at_the_start(lab, push, parameters, sentence):
    process = lab.node("controller", **({"controller": push} | parameters))
    assert process.wait() == 1
    assert sentence in process.output()
    assert "Traceback" not in process.output()


@pytest.mark.parametrize("place", ["in this process", "at a service"])
def test_a_refused_controller_ends_the_node_with_the_reason(lab, scenario, place):
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    url = lab.service(free_port())[1] if place == "at a service" else ""
    controller = lab.file("bad.json", json.dumps(scenario["controller"] | {"robot": "nobody"}))
    process = lab.node("controller", controller=controller, url=url)
    assert process.wait() == 1
    assert "nobody" in process.output()
    assert "Traceback" not in process.output()


def test_a_service_with_a_token(lab, arm, scenario, push):
    token = lab.file("token", "s" * 32)
    token.chmod(0o600)
    port = free_port()
    lab.service(port, "--token-file", str(token))
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    url = f"http://127.0.0.1:{port}"
    refused = lab.node("controller", controller=push, url=url)
    assert refused.wait() == 1
    assert "token" in refused.output()
    lab.node("controller", controller=push, url=url, token_file=token)
    arm.wait_for("controls the arm")


def test_wrong_command_joints_are_refused(lab, scenario, push):
    lab.node("simulator", scenario=lab.file("wall.json", json.dumps(scenario)))
    process = lab.node("controller", controller=push, command_joints="[right_j0, elbow]")
    assert process.wait() == 1
    assert "parameter `command_joints`: give the joints right_j0, right_j1" in process.output()
    assert "Traceback" not in process.output()


def test_the_launch_file_sets_declared_parameters_of_existing_nodes():
    from importlib.metadata import entry_points

    from revprio_ros.parameters import PARAMETERS

    commands = {entry.name for entry in entry_points(group="console_scripts") if entry.value.startswith("revprio_ros.")}
    launch = xml.parse(PACKAGE / "launch/revprio.launch.xml").getroot()
    arguments = {argument.get("name") for argument in launch.findall("arg")}
    nodes = launch.findall(".//node")
    assert nodes
    for node in nodes:
        assert node.get("pkg") == "revprio_ros"
        assert node.get("exec") in commands
        for parameter in node.findall("param"):
            assert parameter.get("name") in PARAMETERS
            value = parameter.get("value")
            assert value.startswith("$(var ") and value[6:-1] in arguments


def test_the_parameters_are_read_only_and_described():
    from types import SimpleNamespace

    from revprio_ros import parameters

    descriptors = {}

    def declare(name, default, descriptor):
        descriptors[name] = descriptor
        return SimpleNamespace(value=default)

    for name in parameters.PARAMETERS:
        parameters.declare(SimpleNamespace(declare_parameter=declare), name)
        assert descriptors[name].read_only
        assert descriptors[name].description

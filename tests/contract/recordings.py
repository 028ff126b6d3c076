"""Reads a recording as MCAP, Parquet, CSV and JSON lines with standard libraries; all must have the same content."""

import csv
import json
import sys

import pyarrow.parquet
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

stem = sys.argv[1]

with open(f"{stem}.csv", newline="") as file:
    rows = list(csv.DictReader(file))
with open(f"{stem}.jsonl") as file:
    samples = [json.loads(line) for line in file]
table = pyarrow.parquet.read_table(f"{stem}.parquet")
with open(f"{stem}.recording.json") as file:
    run = json.load(file)
# Text files have no other sign of lines that got lost.
assert run.pop("periods") == len(rows) == len(samples) == table.num_rows > 0
joints = run["joint_names"]

# Parquet and CSV have the same columns and exactly the same numbers.
assert table.column_names == list(rows[0])
assert json.loads(table.schema.metadata[b"revprio"]) == run
for name in table.column_names:
    for row, value in zip(rows, table[name].to_pylist(), strict=True):
        if isinstance(value, bool):
            assert row[name] == str(value).lower(), name
        elif isinstance(value, float):
            assert float(row[name]) == value, name
        else:
            assert row[name] == ("" if value is None else str(value)), name

# The MCAP file is complete, has checksums and an index, and its messages can be decoded with its own schemas.
SCHEMAS = {
    "/sample": ("revprio.Sample", "jsonschema"),
    "/wrench": ("revprio.Wrench", "jsonschema"),
    "/joint_states": ("foxglove.JointStates", "protobuf"),
    "/tool_pose": ("foxglove.PoseInFrame", "protobuf"),
    "/tf": ("foxglove.FrameTransforms", "protobuf"),
    "/scene": ("foxglove.SceneUpdate", "protobuf"),
}


def has_types(schema):
    parts = [*schema.get("properties", {}).values(), *([schema["items"]] if "items" in schema else [])]
    return "type" in schema and all(map(has_types, parts))


with open(f"{stem}.mcap", "rb") as file:
    reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
    summary = reader.get_summary()
    topics = {channel.topic: summary.schemas[channel.schema_id] for channel in summary.channels.values()}
    assert {topic: (schema.name, schema.encoding) for topic, schema in topics.items()} == SCHEMAS
    # Foxglove refuses a field without a type.
    assert all(has_types(json.loads(schema.data)) for schema in topics.values() if schema.encoding == "jsonschema")
    assert summary.statistics.message_count > 0 and summary.chunk_indexes
    (record,) = [record for record in reader.iter_metadata() if record.name == "revprio"]
    assert json.loads(record.metadata["recording"]) == run
    seen = {topic: [] for topic in SCHEMAS}
    for schema, channel, message in reader.iter_messages():
        if channel.message_encoding == "json":
            seen[channel.topic].append((message.log_time, json.loads(message.data)))
    for schema, channel, message, decoded in reader.iter_decoded_messages(
        topics=[topic for topic, (_, encoding) in SCHEMAS.items() if encoding == "protobuf"]
    ):
        seen[channel.topic].append((message.log_time, decoded))

assert [sample for _, sample in seen["/sample"]] == samples
for topic in ["/wrench", "/joint_states", "/tool_pose"]:
    assert len(seen[topic]) == len(samples), topic
for sample, (time, wrench), (_, states), (_, pose) in zip(
    samples, seen["/wrench"], seen["/joint_states"], seen["/tool_pose"], strict=True
):
    assert time == round(sample["time_s"] * 1e9)
    assert list(wrench["force"].values()) == sample["force"]
    assert [joint.name for joint in states.joints] == joints
    assert [joint.position for joint in states.joints] == sample["joint_position"]
    assert [joint.velocity for joint in states.joints] == sample["actual_velocity"]
    point, rotation = pose.pose.position, pose.pose.orientation
    assert [point.x, point.y, point.z] == sample["position"]
    assert [rotation.w, rotation.x, rotation.y, rotation.z] == sample["orientation"]
_, transforms = seen["/tf"][0]
assert [frame.child_frame_id for frame in transforms.transforms] == [*joints, "tool"]
_, scene = seen["/scene"][-1]
arm, walls, force = scene.entities
assert len(arm.lines[0].points) == len(joints) + 2 and len(walls.cubes) == 1 and len(force.arrows) == 1
print(f"{len(samples)} periods are equal in four formats")

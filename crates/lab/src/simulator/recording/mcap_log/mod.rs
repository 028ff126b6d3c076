//! Recordings as MCAP: each period as JSON, and Foxglove messages for viewers. docs/recordings.md lists the topics.

mod messages;
mod scene;
mod schema;
mod shapes;

use std::io::Write;
use std::ops::Range;

use foxglove::Encode;
use foxglove::messages::{FrameTransforms, JointStates, PoseInFrame, SceneUpdate};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::{NoSeek, WriteOptions};
use mcap::{MessageStream, Summary};
use revprio_api::wire;

use self::messages::{Wrench, nanoseconds};
use self::scene::SceneBuilder;
use super::error::{ReadError, WriteError};
use super::json_lines::{read_object, write_object};
use super::writer::Writer;
use super::{Contacts, Recording, Sample, description};

/// Period of the topics `/tf` and `/scene`, s.
const SCENE_PERIOD_S: f64 = 0.02;

/// Topic from which a recording is read.
const SAMPLES: &str = "/sample";

/// Key of the description of the run.
const DESCRIPTION: &str = "recording";

/// Writes an MCAP file.
pub struct McapWriter<W: Write + Send> {
    timed: bool,
    scene: SceneBuilder,
    out: mcap::Writer<NoSeek<W>>,
    channels: Channels,
    buffer: Vec<u8>,
}

/// Identifiers of the channels.
struct Channels {
    sample: u16,
    wrench: u16,
    contact: Option<u16>,
    joint_states: u16,
    tool_pose: u16,
    transforms: u16,
    scene: u16,
}

impl<W: Write + Send> McapWriter<W> {
    /// Begins the file.
    pub fn begin(recording: &Recording, timed: bool, out: W) -> Result<Self, WriteError> {
        let options = WriteOptions::new()
            .library(concat!("revprio ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .disable_seeking(true);
        let mut out = options.create(NoSeek::new(out))?;
        let run = [(DESCRIPTION.to_owned(), description::to_json(recording, timed)?)];
        out.write_metadata(&Metadata { name: description::KEY.to_owned(), metadata: run.into() })?;
        let follows = recording.samples.last().is_some_and(|sample| sample.contacts.surface.is_followed());
        let example = Sample { contacts: Contacts::approaching(1, usize::from(follows)), ..Sample::at_rest() };
        let channels = Channels {
            sample: json_channel(&mut out, SAMPLES, "revprio.Sample", &schema::of_sample(recording, timed)?)?,
            wrench: json_channel(&mut out, "/wrench", "revprio.Wrench", &schema::of(&Wrench::default())?)?,
            contact: if has_contacts(recording) {
                Some(json_channel(
                    &mut out,
                    "/contact",
                    "revprio.Contacts",
                    &schema::of(&messages::contacts(&example))?,
                )?)
            } else {
                None
            },
            joint_states: channel::<JointStates, _>(&mut out, "/joint_states")?,
            tool_pose: channel::<PoseInFrame, _>(&mut out, "/tool_pose")?,
            transforms: channel::<FrameTransforms, _>(&mut out, "/tf")?,
            scene: channel::<SceneUpdate, _>(&mut out, "/scene")?,
        };
        Ok(Self { timed, scene: SceneBuilder::new(recording), out, channels, buffer: Vec::new() })
    }

    fn write_row(&mut self, recording: &Recording, row: usize) -> Result<(), WriteError> {
        let sample = &recording.samples[row];
        let time = MessageTime { row, nanoseconds: nanoseconds(sample.time_s) };
        self.buffer.clear();
        write_object(recording, row, self.timed, &mut self.buffer)?;
        self.send(self.channels.sample, time)?;
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, &messages::wrench(sample))?;
        self.send(self.channels.wrench, time)?;
        if let Some(channel) = self.channels.contact {
            self.buffer.clear();
            serde_json::to_writer(&mut self.buffer, &messages::contacts(sample))?;
            self.send(channel, time)?;
        }
        self.encode(self.channels.joint_states, time, &messages::joint_states(recording, sample))?;
        self.encode(self.channels.tool_pose, time, &messages::tool_pose(sample))?;
        if row.is_multiple_of(periods(SCENE_PERIOD_S, recording.period_s)) {
            let links = self.scene.links(sample);
            self.encode(self.channels.transforms, time, &messages::transforms(recording, sample, &links))?;
            let scene = self.scene.scene(sample, &links);
            self.encode(self.channels.scene, time, &scene)?;
        }
        Ok(())
    }

    fn encode<M: Encode>(&mut self, channel: u16, time: MessageTime, message: &M) -> Result<(), WriteError> {
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|_| WriteError::Message)?;
        self.send(channel, time)
    }

    fn send(&mut self, channel_id: u16, time: MessageTime) -> Result<(), WriteError> {
        let header = MessageHeader {
            channel_id,
            sequence: u32::try_from(time.row).unwrap_or(u32::MAX),
            log_time: time.nanoseconds,
            publish_time: time.nanoseconds,
        };
        Ok(self.out.write_to_known_channel(&header, &self.buffer)?)
    }
}

/// Returns whether a task of the run has the law `contact`.
fn has_contacts(recording: &Recording) -> bool {
    let has_law = |task: &wire::ControllerTask| matches!(task.law, Some(wire::Law::Contact { .. }));
    recording.setup.as_ref().is_some_and(|setup| setup.controller.tasks.iter().any(has_law))
}

/// The time of a message.
#[derive(Clone, Copy)]
struct MessageTime {
    row: usize,
    nanoseconds: u64,
}

/// Returns the number of control periods in `interval` seconds, at least 1.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
fn periods(interval: f64, period: f64) -> usize {
    ((interval / period).round() as usize).max(1)
}

fn channel<M: Encode, W: Write>(out: &mut mcap::Writer<NoSeek<W>>, topic: &str) -> Result<u16, WriteError> {
    let schema = M::get_schema().ok_or(WriteError::Message)?;
    let schema = out.add_schema(&schema.name, &schema.encoding, &schema.data)?;
    Ok(out.add_channel(schema, topic, &M::get_message_encoding(), &[].into())?)
}

fn json_channel<W: Write>(
    out: &mut mcap::Writer<NoSeek<W>>,
    topic: &str,
    name: &str,
    schema: &str,
) -> Result<u16, WriteError> {
    let schema = out.add_schema(name, "jsonschema", schema.as_bytes())?;
    Ok(out.add_channel(schema, topic, "json", &[].into())?)
}

impl<W: Write + Send> Writer for McapWriter<W> {
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError> {
        rows.into_iter().try_for_each(|row| self.write_row(recording, row))
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        self.out.finish()?;
        // The writer of the caller may be buffered.
        Ok(self.out.into_inner().into_inner().flush()?)
    }
}

/// Reads a recording from the content of an MCAP file.
pub fn read(file: &[u8]) -> Result<Recording, ReadError> {
    let summary = Summary::read(file)?.ok_or(ReadError::NoDescription)?;
    let place =
        summary.metadata_indexes.iter().find(|index| index.name == description::KEY).ok_or(ReadError::NoDescription)?;
    let run = mcap::read::metadata(file, place)?;
    let mut recording = description::from_json(run.metadata.get(DESCRIPTION).ok_or(ReadError::NoDescription)?)?;
    let mut line = 0;
    for message in MessageStream::new(file)? {
        let message = message?;
        if message.channel.topic == SAMPLES {
            line += 1;
            read_object(&mut recording, &message.data).map_err(|source| ReadError::Line { line, source })?;
        }
    }
    Ok(recording)
}

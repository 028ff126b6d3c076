//! Recordings as MCAP: each period whole as JSON, and what viewers draw as Foxglove messages.
//!
//! | topic | schema | how often |
//! |---|---|---|
//! | `/sample` | `revprio.Sample`, JSON | each period |
//! | `/wrench` | `revprio.Wrench`, JSON | each period |
//! | `/joint_states` | `foxglove.JointStates`, protobuf | each period |
//! | `/tool_pose` | `foxglove.PoseInFrame`, protobuf | each period |
//! | `/tf` | `foxglove.FrameTransforms`, protobuf | 50 Hz |
//! | `/scene` | `foxglove.SceneUpdate`, protobuf | 50 Hz |

mod messages;
mod scene;
mod schema;

use std::io::Write;
use std::ops::Range;

use foxglove::Encode;
use foxglove::messages::{FrameTransforms, JointStates, PoseInFrame, SceneUpdate};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::{NoSeek, WriteOptions};
use mcap::{MessageStream, Summary};

use self::messages::Wrench;
use self::scene::Stage;
use super::error::{ReadError, WriteError};
use super::format::Writer;
use super::json_lines::{read_object, write_object};
use super::{Recording, head};

/// Between two pictures of the arm, s.
const PICTURE_PERIOD_S: f64 = 0.02;

/// Topic that a recording is read back from.
const SAMPLES: &str = "/sample";

/// Key of the description of the run.
const HEAD: &str = "recording";

/// A file that is being written.
pub struct Log<W: Write + Send> {
    timed: bool,
    stage: Stage,
    out: mcap::Writer<NoSeek<W>>,
    channels: Channels,
    buffer: Vec<u8>,
}

/// Numbers of the channels.
struct Channels {
    sample: u16,
    wrench: u16,
    joint_states: u16,
    tool_pose: u16,
    transforms: u16,
    scene: u16,
}

impl<W: Write + Send> Log<W> {
    /// Begins the file.
    pub fn begin(recording: &Recording, timed: bool, out: W) -> Result<Self, WriteError> {
        let options = WriteOptions::new()
            .library(concat!("revprio ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .disable_seeking(true);
        let mut out = options.create(NoSeek::new(out))?;
        let run = [(HEAD.to_owned(), head::to_json(recording, timed)?)];
        out.write_metadata(&Metadata { name: head::KEY.to_owned(), metadata: run.into() })?;
        let channels = Channels {
            sample: json_channel(&mut out, SAMPLES, "revprio.Sample", &schema::of_sample(recording, timed)?)?,
            wrench: json_channel(&mut out, "/wrench", "revprio.Wrench", &schema::of(&Wrench::default())?)?,
            joint_states: channel::<JointStates, _>(&mut out, "/joint_states")?,
            tool_pose: channel::<PoseInFrame, _>(&mut out, "/tool_pose")?,
            transforms: channel::<FrameTransforms, _>(&mut out, "/tf")?,
            scene: channel::<SceneUpdate, _>(&mut out, "/scene")?,
        };
        Ok(Self { timed, stage: Stage::of(recording), out, channels, buffer: Vec::new() })
    }

    fn write_row(&mut self, recording: &Recording, row: usize) -> Result<(), WriteError> {
        let sample = &recording.samples[row];
        let moment = Moment { row, nanoseconds: nanoseconds(sample.time_s) };
        self.buffer.clear();
        write_object(recording, row, self.timed, &mut self.buffer)?;
        self.send(self.channels.sample, moment)?;
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, &messages::wrench(sample))?;
        self.send(self.channels.wrench, moment)?;
        self.encode(self.channels.joint_states, moment, &messages::joint_states(recording, sample))?;
        self.encode(self.channels.tool_pose, moment, &messages::tool_pose(sample))?;
        if row.is_multiple_of(every(PICTURE_PERIOD_S, recording.period_s)) {
            let links = self.stage.links(sample);
            self.encode(self.channels.transforms, moment, &messages::transforms(recording, sample, &links))?;
            let scene = self.stage.scene(sample, &links);
            self.encode(self.channels.scene, moment, &scene)?;
        }
        Ok(())
    }

    fn encode<M: Encode>(&mut self, channel: u16, moment: Moment, message: &M) -> Result<(), WriteError> {
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|_| WriteError::Message)?;
        self.send(channel, moment)
    }

    fn send(&mut self, channel_id: u16, moment: Moment) -> Result<(), WriteError> {
        let header = MessageHeader {
            channel_id,
            sequence: u32::try_from(moment.row).unwrap_or(u32::MAX),
            log_time: moment.nanoseconds,
            publish_time: moment.nanoseconds,
        };
        Ok(self.out.write_to_known_channel(&header, &self.buffer)?)
    }
}

/// When a message is from.
#[derive(Clone, Copy)]
struct Moment {
    row: usize,
    nanoseconds: u64,
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

/// Every which period something is due that is due every `due` seconds.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
fn every(due: f64, period: f64) -> usize {
    ((due / period).round() as usize).max(1)
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

impl<W: Write + Send> Writer for Log<W> {
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError> {
        rows.into_iter().try_for_each(|row| self.write_row(recording, row))
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        self.out.finish()?;
        // What the caller gave may have a buffer of its own.
        Ok(self.out.into_inner().into_inner().flush()?)
    }
}

/// Reads a recording from the content of a file.
pub fn read(file: &[u8]) -> Result<Recording, ReadError> {
    let summary = Summary::read(file)?.ok_or(ReadError::NoHead)?;
    let place = summary.metadata_indexes.iter().find(|index| index.name == head::KEY).ok_or(ReadError::NoHead)?;
    let run = mcap::read::metadata(file, place)?;
    let mut recording = head::from_json(run.metadata.get(HEAD).ok_or(ReadError::NoHead)?)?;
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

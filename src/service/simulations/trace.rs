//! Traces as answers, written piece by piece as the client reads them.

use std::io::{self, Write};
use std::sync::{Arc, Weak};

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use futures_util::stream;

use crate::service::accept;
use crate::service::background::background;
use crate::service::problem::Problem;
use crate::simulator::recording::{Recording, write_csv_rows};

/// Samples of one piece: some 300 kB, written in about a millisecond.
const PIECE: usize = 500;

/// How a trace can be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TraceFormat {
    /// A table, units in the names of the columns.
    Csv,
    /// One object per line and period.
    JsonLines,
    /// One object with what is common to all periods and the list `samples`.
    Json,
}

/// Media types of traces, the preferred one first.
pub const TRACE_FORMATS: [(&str, TraceFormat); 3] = [
    ("text/csv", TraceFormat::Csv),
    ("application/x-ndjson", TraceFormat::JsonLines),
    ("application/json", TraceFormat::Json),
];

/// The trace in the format that the client prefers, compressed if it likes.
///
/// The pieces are written in other threads and only when the client wants them. A recording that is forgotten while a
/// client reads breaks the connection off: a slow reader must not keep what makes room for others.
pub fn trace(recording: &Arc<Recording>, headers: &HeaderMap) -> Result<Response, Problem> {
    let offered = || TRACE_FORMATS.map(|(media_type, _)| format!("`{media_type}`")).join(", ");
    let format = accept::preferred(headers, &TRACE_FORMATS).ok_or_else(|| Problem::not_acceptable(&offered()))?;
    let media_type = TRACE_FORMATS.iter().find(|(_, known)| *known == format).map_or("", |(media_type, _)| media_type);
    let gzip = accept::gzip(headers);
    let out = if gzip { Out::Gzip(GzEncoder::new(Vec::new(), Compression::fast())) } else { Out::Plain(Vec::new()) };
    let pieces = Pieces { recording: Arc::downgrade(recording), format, next: 0, out };
    let pieces = stream::unfold(Some(pieces), |pieces| async {
        let pieces = pieces?;
        let piece = background(move |_| pieces.advance()).await;
        Some(piece.unwrap_or_else(|_| (Err(io::Error::other("a defect of the service")), None)))
    });
    let mut response = Body::from_stream(pieces).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    headers.insert(header::VARY, HeaderValue::from_static("accept, accept-encoding"));
    if gzip {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    Ok(response)
}

/// Where a trace is written to.
enum Out {
    Plain(Vec<u8>),
    Gzip(GzEncoder<Vec<u8>>),
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Plain(out) => out.write(bytes),
            Self::Gzip(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Out {
    /// What is written so far.
    fn take(&mut self) -> Bytes {
        match self {
            Self::Plain(out) => std::mem::take(out),
            Self::Gzip(out) => std::mem::take(out.get_mut()),
        }
        .into()
    }

    fn finish(self) -> io::Result<Bytes> {
        match self {
            Self::Plain(out) => Ok(out.into()),
            Self::Gzip(out) => out.finish().map(Bytes::from),
        }
    }
}

/// A trace that is written as far as `next`.
struct Pieces {
    recording: Weak<Recording>,
    format: TraceFormat,
    next: usize,
    out: Out,
}

/// A piece, or why the trace breaks off, and the rest, if there is one.
type Piece = (io::Result<Bytes>, Option<Pieces>);

impl Pieces {
    fn advance(mut self) -> Piece {
        let Some(recording) = self.recording.upgrade() else {
            return (Err(io::Error::other("the simulation was forgotten")), None);
        };
        let end = (self.next + PIECE).min(recording.samples.len());
        if let Err(error) = self.write(&recording, end) {
            return (Err(error), None);
        }
        self.next = end;
        if end == recording.samples.len() {
            return (self.out.finish(), None);
        }
        (Ok(self.out.take()), Some(self))
    }

    fn write(&mut self, recording: &Recording, end: usize) -> io::Result<()> {
        let (is_first, is_last) = (self.next == 0, end == recording.samples.len());
        let samples = &recording.samples[self.next..end];
        match self.format {
            TraceFormat::Csv => {
                if is_first {
                    recording.write_csv_header(&mut self.out)?;
                }
                write_csv_rows(samples, &mut self.out)?;
            }
            TraceFormat::JsonLines => {
                for sample in samples {
                    serde_json::to_writer(&mut self.out, sample)?;
                    self.out.write_all(b"\n")?;
                }
            }
            TraceFormat::Json => {
                if is_first {
                    let head = serde_json::to_string(recording)?;
                    write!(self.out, "{},\"samples\":[", head.strip_suffix('}').unwrap_or(&head))?;
                }
                for (i, sample) in samples.iter().enumerate() {
                    let comma: &[u8] = if is_first && i == 0 { b"" } else { b"," };
                    self.out.write_all(comma)?;
                    serde_json::to_writer(&mut self.out, sample)?;
                }
                if is_last {
                    self.out.write_all(b"]}")?;
                }
            }
        }
        Ok(())
    }
}

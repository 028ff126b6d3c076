//! Traces as answers. They are written piece by piece, as fast as the client reads.

use std::io::{self, Write};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use futures_util::stream;
use revprio_lab::simulator::recording::{Format, Recording, WriteError, Writer, recording_description, write_object};

use crate::service::accept;
use crate::service::background::background;
use crate::service::error::ApiError;

/// The format of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TraceFormat {
    /// A format that is also a file format.
    File(Format),
    /// One object with the common fields of all periods and the list `samples`.
    Json,
}

/// Media types of traces, the preferred one first.
const TRACE_FORMATS: [(&str, TraceFormat); 5] = [
    ("text/csv", TraceFormat::File(Format::Csv)),
    ("application/x-ndjson", TraceFormat::File(Format::JsonLines)),
    ("application/json", TraceFormat::Json),
    ("application/vnd.apache.parquet", TraceFormat::File(Format::Parquet)),
    ("application/vnd.mcap", TraceFormat::File(Format::Mcap)),
];

/// Returns the trace in the format that the client prefers, compressed if the client accepts gzip.
///
/// Other threads write the pieces when the client needs them. If the run is deleted meanwhile, the connection breaks:
/// a slow client must not keep memory that other runs need.
pub fn trace_answer(recording: &Arc<Recording>, headers: &HeaderMap) -> Result<Response, ApiError> {
    let offered = || TRACE_FORMATS.map(|(media_type, _)| format!("`{media_type}`")).join(", ");
    let format = accept::preferred(headers, &TRACE_FORMATS).ok_or_else(|| ApiError::not_acceptable(&offered()))?;
    let media_type = TRACE_FORMATS.iter().find(|(_, known)| *known == format).map_or("", |(media_type, _)| media_type);
    let gzip = accept::gzip(headers);
    let pieces = Pieces::new(recording, format, gzip).map_err(|error| {
        tracing::error!(%error, "cannot begin a trace");
        ApiError::internal()
    })?;
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

/// Bytes that are written and not yet sent.
#[derive(Clone, Default)]
struct Written(Arc<Mutex<Vec<u8>>>);

impl Written {
    fn take(&self) -> Bytes {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner)).into()
    }
}

impl Write for Written {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A trace that is written up to the period `next`.
struct Pieces {
    recording: Weak<Recording>,
    /// Number of periods per piece.
    piece: usize,
    next: usize,
    writer: Box<dyn Writer>,
    written: Written,
}

/// A piece or an error, and the rest of the trace, if there is one.
type Piece = (io::Result<Bytes>, Option<Pieces>);

impl Pieces {
    fn new(recording: &Arc<Recording>, format: TraceFormat, gzip: bool) -> Result<Self, WriteError> {
        let written = Written::default();
        let writer = if gzip {
            let out = GzEncoder::new(written.clone(), Compression::fast());
            begin(recording, format, out)?
        } else {
            begin(recording, format, written.clone())?
        };
        let piece = match format {
            TraceFormat::File(format) => format.piece(),
            TraceFormat::Json => Format::JsonLines.piece(),
        };
        Ok(Self { recording: Arc::downgrade(recording), piece, next: 0, writer, written })
    }

    fn advance(mut self) -> Piece {
        let Some(recording) = self.recording.upgrade() else {
            return (Err(io::Error::other("the simulation was deleted")), None);
        };
        let end = (self.next + self.piece).min(recording.samples.len());
        if let Err(error) = self.writer.write(&recording, self.next..end) {
            return (Err(error.into()), None);
        }
        self.next = end;
        if end == recording.samples.len() {
            let Self { writer, written, .. } = self;
            let end = writer.finish().map(|()| written.take());
            return (end.map_err(io::Error::from), None);
        }
        (Ok(self.written.take()), Some(self))
    }
}

fn begin<W: Write + Send + 'static>(
    recording: &Recording,
    format: TraceFormat,
    out: W,
) -> Result<Box<dyn Writer>, WriteError> {
    match format {
        TraceFormat::File(format) => format.writer(recording, false, out),
        TraceFormat::Json => Ok(Box::new(OneObject { is_first: true, out })),
    }
}

/// Writes one object with the common fields and the list `samples`.
struct OneObject<W> {
    is_first: bool,
    out: W,
}

impl<W: Write + Send> Writer for OneObject<W> {
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError> {
        if self.is_first {
            let head = recording_description(recording, false)?;
            write!(self.out, "{},\"samples\":[", head.strip_suffix('}').unwrap_or(&head))?;
        }
        for row in rows {
            let comma: &[u8] = if self.is_first { b"" } else { b"," };
            self.is_first = false;
            self.out.write_all(comma)?;
            write_object(recording, row, false, &mut self.out)?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        self.out.write_all(b"]}")?;
        Ok(self.out.flush()?)
    }
}

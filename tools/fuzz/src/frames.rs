//! The target `stream`: messages or bytes on the WebSocket of a session.

use revprio_api::wire::{CreatedController, Problem, StepAnswer};

use crate::Defect;
use crate::answers::{command, decode, value};
use crate::budget::Work;
use crate::limits::{SpeedLimits, of_controller};
use crate::target::split_line;
use crate::timed_service::TimedService;

/// The controller of the session.
const CONTROLLER: &str = include_str!("../../../api/examples/controller.json");

/// Maximum number of messages of one input. Each may use as much time as a request the size of an arm.
const MAX_MESSAGES: usize = 16;

/// Codes with which the service may close a stream. 1011 is a defect.
const CLOSE_CODES: [u16; 4] = [1000, 1001, 1002, 4404];

/// Masked frames of a client, final.
const TEXT: u8 = 0x81;
const BINARY: u8 = 0x82;
const CLOSE: [u8; 8] = [0x88, 0x82, 0, 0, 0, 0, 0x03, 0xe8];

/// Opens a session, sends the messages of an input, checks every answer, and ends the session.
///
/// The first line is `json` with a message per line after it, `msgpack` with messages of a 16-bit length each, or `bytes`
/// with the bytes themselves.
pub fn check(service: &TimedService, input: &[u8]) -> Result<(), Defect> {
    let Some((kind, rest)) = split_line(input) else { return Ok(()) };
    let (protocol, media_type, frames, count) = match kind {
        b"json" => {
            let messages: Vec<&[u8]> = rest.split(|byte| *byte == b'\n').take(MAX_MESSAGES).collect();
            // The bytes of a text frame must be UTF-8.
            ("revprio.json", "application/json", frames(TEXT, &messages), Some(messages.len()))
        }
        b"msgpack" => {
            let messages = split_lengths(rest);
            ("revprio.msgpack", "application/msgpack", frames(BINARY, &messages), Some(messages.len()))
        }
        b"bytes" => ("revprio.json", "application/json", rest.to_vec(), None),
        _ => return Ok(()),
    };
    let answer = service.untimed().post("/v1/controllers", "application/json", CONTROLLER.as_bytes())?;
    let Some(created) = value::<CreatedController>(&answer, false)? else {
        return Err(Defect::Wrong("the example is refused".to_owned()));
    };
    let path = format!("/v1/controllers/{}", created.id);
    let arms = u32::try_from(count.unwrap_or(MAX_MESSAGES)).unwrap_or(u32::MAX).max(1);
    let budget = Work { bytes: rest.len(), ..Work::default() }.budget() * arms;
    let sent = service.timed(budget, || service.untimed().web_socket(&format!("{path}/stream"), protocol, &frames));
    let ended = service.untimed().delete(&path)?;
    let bytes = sent?.ok_or_else(|| Defect::Wrong("the handshake is refused".to_owned()))?;
    let answers = answers(&bytes, media_type)?;
    let is_text = kind != b"json" || std::str::from_utf8(rest).is_ok();
    if is_text && count.is_some_and(|count| count != answers) {
        return Err(Defect::Wrong(format!("{answers} answers to {count:?} messages")));
    }
    if ended.status == 204 { Ok(()) } else { Err(Defect::Wrong(format!("ended with {}", ended.status))) }
}

/// Splits bytes into messages with 16-bit lengths, big-endian.
fn split_lengths(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut messages = Vec::new();
    while let [high, low, rest @ ..] = bytes
        && messages.len() < MAX_MESSAGES
    {
        let length = usize::from(u16::from_be_bytes([*high, *low])).min(rest.len());
        let (message, after) = rest.split_at(length);
        messages.push(message);
        bytes = after;
    }
    messages
}

/// Returns one frame per message, and a close frame.
fn frames(opcode: u8, messages: &[&[u8]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for message in messages {
        bytes.push(opcode);
        match u16::try_from(message.len()) {
            Ok(length) if length < 126 => bytes.push(0x80 | length.to_be_bytes()[1]),
            Ok(length) => {
                bytes.push(0x80 | 0x7e);
                bytes.extend(length.to_be_bytes());
            }
            Err(_) => {
                bytes.push(0x80 | 0x7f);
                bytes.extend((message.len() as u64).to_be_bytes());
            }
        }
        // A mask of zeros leaves the message as it is.
        bytes.extend([0; 4]);
        bytes.extend(*message);
    }
    bytes.extend(CLOSE);
    bytes
}

/// Checks the frames of the service, and returns the number of answers among them.
fn answers(mut bytes: &[u8], media_type: &str) -> Result<usize, Defect> {
    let wrong = |what: &str, bytes: &[u8]| Defect::Wrong(format!("{what}: {}", String::from_utf8_lossy(bytes)));
    let limits = serde_json::from_str(CONTROLLER).ok().and_then(|controller| of_controller(&controller));
    let mut count = 0;
    while !bytes.is_empty() {
        let (opcode, payload, rest) = frame(bytes).ok_or_else(|| wrong("a broken frame", bytes))?;
        match opcode {
            TEXT | BINARY => {
                count += 1;
                answer(payload, media_type, limits.as_ref())?;
            }
            0x88 => {
                let code = payload.get(..2).map(|code| u16::from_be_bytes([code[0], code[1]]));
                // A client may close with any code, which the service repeats.
                if code == Some(1011) || (payload.len() > 2 && !code.is_some_and(|code| CLOSE_CODES.contains(&code))) {
                    return Err(wrong("closed", payload));
                }
            }
            0x89 | 0x8a => {}
            _ => return Err(wrong("an unknown frame", bytes)),
        }
        bytes = rest;
    }
    Ok(count)
}

/// Returns opcode, payload and the bytes after the first frame.
fn frame(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (&[opcode, length], rest) = bytes.split_first_chunk::<2>()?;
    let (length, rest) = match length {
        126 => {
            let (length, rest) = rest.split_first_chunk::<2>()?;
            (usize::from(u16::from_be_bytes(*length)), rest)
        }
        127 => {
            let (length, rest) = rest.split_first_chunk::<8>()?;
            (usize::try_from(u64::from_be_bytes(*length)).ok()?, rest)
        }
        length => (usize::from(length), rest),
    };
    let (payload, rest) = rest.split_at_checked(length)?;
    Some((opcode, payload, rest))
}

/// Checks one message of the service: an answer to a step, or a problem.
fn answer(payload: &[u8], media_type: &str, limits: Option<&SpeedLimits>) -> Result<(), Defect> {
    if let Ok(problem) = decode::<Problem>(media_type, payload) {
        if problem.status >= 500 || problem.detail.is_empty() {
            return Err(Defect::Wrong(format!("a message is answered {problem:?}")));
        }
        return Ok(());
    }
    command(&decode::<StepAnswer>(media_type, payload)?, limits)
}

//! The exported functions. The host writes a request into a buffer and reads the answer from one.
//!
//! A buffer is the pointer to its first byte and its length. The host is the only caller, on one thread.
#![allow(unsafe_code, reason = "exports, and buffers that the host fills, cannot be written in safe Rust")]

use std::cell::RefCell;
use std::time::Duration;

use revprio_api::clock;

use crate::service::BrowserService;

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Returns the monotonic time of the host, ms.
    safe fn now_ms() -> f64;
}

/// The buffers of one call: the request, and the answer until the next call.
#[derive(Default)]
struct Buffers {
    request: Vec<u8>,
    answer: Vec<u8>,
}

thread_local! {
    static BUFFERS: RefCell<Buffers> = RefCell::default();
    static SERVICE: RefCell<BrowserService> = RefCell::new(start());
}

fn start() -> BrowserService {
    clock::set(|| Duration::from_secs_f64(now_ms().max(0.0) / 1e3));
    BrowserService::new()
}

/// Makes room for a request of this many bytes and returns the pointer to it.
#[unsafe(no_mangle)]
extern "C" fn request_buffer(length: usize) -> *mut u8 {
    BUFFERS.with_borrow_mut(|buffers| {
        buffers.request.clear();
        buffers.request.resize(length, 0);
        buffers.request.as_mut_ptr()
    })
}

/// Answers the request in the buffer: a JSON object with `method`, `path` and `body`. Returns the length of the answer, a
/// JSON object with `status` and `body`.
#[unsafe(no_mangle)]
extern "C" fn call() -> usize {
    BUFFERS.with_borrow_mut(|Buffers { request, answer }| {
        *answer = SERVICE.with_borrow_mut(|service| service.answer_text(request));
        answer.len()
    })
}

/// Returns the pointer to the answer of the last call.
#[unsafe(no_mangle)]
extern "C" fn answer_buffer() -> *const u8 {
    BUFFERS.with_borrow(|buffers| buffers.answer.as_ptr())
}

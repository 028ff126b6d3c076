//! One exchange: requests on a connection, and their answers, with everything that can happen on the way.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use revprio_api::wire;
use tokio::time::Instant;

use crate::call::{Call, Format};
use crate::http::{self, Answer, Connection, NoAnswer, Request};
use crate::network::Wire;
use crate::oracle::{End, Sent};
use crate::plan::TOKEN;
use crate::random::Random;
use crate::transcript;
use crate::world::{Instance, Phase, World};

/// Longer than every timeout of the service together. Whatever takes longer would wait for ever.
const FOREVER: Duration = Duration::from_mins(5);

/// Number of exchanges after which a connection counts as a control loop, and the longest pause of one.
const LOOP_EXCHANGES: u32 = 10;
const LOOP_PAUSE: Duration = Duration::from_millis(900);

/// A client's connection to one process.
pub struct Link {
    connection: Connection,
    pub instance: Arc<Instance>,
    exchanges: u32,
    last_answer: Instant,
    /// Time when the last request was written completely.
    written: Arc<Mutex<Option<Instant>>>,
    /// Bytes that the network holds in each direction.
    buffer: usize,
    /// Whether the last request was refused before its body was read. The service may then close the connection.
    is_unread: bool,
}

/// What happens to an exchange.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    Undisturbed,
    /// The client dies before it has sent everything.
    DiesSending,
    /// The client dies before it reads the answers.
    DiesWaiting,
    /// The client reads only after a pause.
    ReadsLate(Duration),
}

/// How an exchange began.
#[derive(Debug, Clone, Copy)]
struct Began {
    at: Instant,
    phase: Phase,
    fate: Fate,
}

/// A client: its name and its decisions.
pub struct Client {
    pub world: Arc<World>,
    pub name: String,
    pub random: Random,
}

impl Link {
    /// Returns whether the service has to answer although it was told to stop: the whole request had arrived before.
    fn must_be_answered(&self) -> bool {
        let (Phase::Stopping(at) | Phase::Ended(at)) = self.instance.phase() else { return false };
        let written = *self.written.lock().unwrap();
        written.is_some_and(|written| written + Duration::from_millis(2) < at)
            && at.elapsed() < Duration::from_millis(900)
    }

    /// Returns the bytes of the connection.
    pub fn wire(&self) -> Wire {
        self.connection.wire.clone()
    }

    /// Reads the answer to a request that is no exchange.
    pub async fn answer(&mut self) -> Option<Answer> {
        let read = tokio::time::timeout(FOREVER, self.connection.read("GET")).await;
        read.expect("the service answers in time").ok()
    }
}

impl Client {
    /// Returns a client of the same name that acts at the same time.
    pub fn twin(&mut self) -> Self {
        Self { world: Arc::clone(&self.world), name: self.name.clone(), random: self.random.fork() }
    }

    pub fn note(&self, text: &str) {
        self.world.note(&self.name, text);
    }

    pub async fn pause(&mut self, low_ms: u64, high_ms: u64) {
        let pause = self.random.millis(low_ms, high_ms);
        tokio::time::sleep(pause).await;
    }

    /// Connects to the current process. `None`: nobody listens.
    pub fn connect(&mut self) -> Option<Link> {
        let buffer = self.random.pick(&[64, 700, 8192, 65_536]);
        self.connect_through(buffer)
    }

    /// Connects through a network that holds so many bytes.
    pub fn connect_through(&self, buffer: usize) -> Option<Link> {
        let instance = self.world.instance();
        let connected = instance.port.connect(buffer);
        if connected.is_err() {
            assert!(!instance.is_serving(), "a serving service refuses a connection");
        }
        let connection = Connection::new(connected.ok()?);
        Some(Link {
            connection,
            instance,
            exchanges: 0,
            last_answer: Instant::now(),
            written: Arc::default(),
            buffer,
            is_unread: false,
        })
    }

    /// Makes one call without disturbance, on a connection that may already be open.
    pub async fn call(&mut self, link: &mut Option<Link>, call: Call) -> Option<Answer> {
        self.exchange(link, vec![call], Fate::Undisturbed).await.pop().flatten()
    }

    /// Sends calls one after the other without waiting, and returns their answers. The link is `None` after its end.
    pub async fn exchange(&mut self, link: &mut Option<Link>, calls: Vec<Call>, fate: Fate) -> Vec<Option<Answer>> {
        let mut used = match link.take() {
            Some(link) => link,
            None => match self.connect() {
                Some(link) => link,
                None => return vec![None; calls.len()],
            },
        };
        let name = self.name.clone();
        let exchanged = tokio::time::timeout(FOREVER, self.exchange_on(&mut used, &calls, fate)).await;
        let (answers, is_open) = exchanged.unwrap_or_else(|_| panic!("{name} waits for ever: {calls:?}"));
        *link = is_open.then_some(used);
        answers
    }

    async fn exchange_on(&mut self, link: &mut Link, calls: &[Call], fate: Fate) -> (Vec<Option<Answer>>, bool) {
        let format = Format::random(&mut self.random);
        let began = Began { at: Instant::now(), phase: link.instance.phase(), fate };
        let sent: Vec<(Call, Request, Sent)> = calls.iter().map(|call| self.prepare(call, format, link)).collect();
        let bytes: Vec<u8> = sent.iter().flat_map(|(_, request, _)| request.bytes()).collect();
        let part = if fate == Fate::DiesSending { self.random.below(bytes.len()) } else { bytes.len() };
        let (wire, mut chance, written) = (link.connection.wire.clone(), self.random.fork(), Arc::clone(&link.written));
        *written.lock().unwrap() = None;
        let write = async {
            // A connection that has ended cannot be written to, but an answer may still wait in it.
            let is_whole = http::write(wire, &bytes[..part], &mut chance).await.is_ok();
            *written.lock().unwrap() = (is_whole && calls.len() == 1).then(Instant::now);
        };
        let exchanged = match fate {
            // Answers may arrive before all requests are written.
            Fate::Undisturbed => tokio::join!(write, self.read_all(link, &sent, began)).1,
            Fate::ReadsLate(pause) => {
                write.await;
                tokio::time::sleep(pause).await;
                self.read_all(link, &sent, began).await
            }
            Fate::DiesSending | Fate::DiesWaiting => {
                write.await;
                self.pause(0, 2).await;
                let end = if fate == Fate::DiesSending { End::Incomplete } else { End::Lost };
                for sent in &sent {
                    self.judge(link, sent, &end, began);
                }
                (vec![None; calls.len()], false)
            }
        };
        link.exchanges += 1;
        assert!(!exchanged.1 || !link.connection.has_more(), "{}: more bytes than answers", self.name);
        exchanged
    }

    /// Reads all answers, and returns whether the connection can be used again.
    async fn read_all(
        &mut self,
        link: &mut Link,
        sent: &[(Call, Request, Sent)],
        began: Began,
    ) -> (Vec<Option<Answer>>, bool) {
        let (mut answers, mut is_open) = (Vec::new(), true);
        for sent in sent {
            let answer = if is_open { self.read(link, &sent.1, began).await } else { None };
            self.judge(link, sent, &answer.as_ref().map_or(End::Lost, End::Answered), began);
            is_open = answer.as_ref().is_some_and(|answer| !answer.closes());
            answers.push(answer);
        }
        (answers, is_open)
    }

    /// Prepares a request, and tells the oracle.
    fn prepare(&self, call: &Call, format: Format, link: &Link) -> (Call, Request, Sent) {
        let request = self.request(call, format);
        let sent = self.world.oracle().sent(call, link.instance.number, &self.name);
        (call.clone(), request, sent)
    }

    /// Writes a request, and notes it.
    pub fn request(&self, call: &Call, format: Format) -> Request {
        let mut request = call.request(self.world.request_id(&self.name), format);
        if self.world.plan.needs_token {
            request = request.with("authorization", format!("Bearer {TOKEN}"));
        }
        self.note(&format!("→ {} [{}]", call.text(), request.id));
        request
    }

    /// Reads an answer. `None`: the connection ended, and it may have.
    async fn read(&mut self, link: &mut Link, request: &Request, began: Began) -> Option<Answer> {
        match link.connection.read(request.method).await {
            Ok(answer) if answer.header("x-request-id") == Some(&request.id) => {
                // The order of metrics differs, and some belong to the whole process.
                let is_noted = request.path != "/metrics";
                let hash = if is_noted { transcript::hash(&answer.body) } else { 0 };
                let text = format!("← {} {} [{}] {hash:016x}", answer.status, answer.problem(), request.id);
                self.note(&text);
                if let Fate::ReadsLate(pause) = began.fate {
                    let is_too_late = pause > self.world.plan.config.write_timeout + Duration::from_secs(1);
                    let is_held = answer.body.len() < 2 * link.buffer;
                    assert!(is_held || !is_too_late, "{}: the service waited too long for a reader", self.name);
                }
                // The service may have sent it long ago.
                link.last_answer = if matches!(began.fate, Fate::ReadsLate(_)) { began.at } else { Instant::now() };
                link.is_unread = request.method == "POST" && matches!(answer.status, 415 | 503);
                Some(answer)
            }
            // Only the answer to a connection above the limit has no ID.
            Ok(answer) if self.is_crowded() && answer.status == 503 => {
                self.note("← too many connections");
                assert!(answer.closes());
                None
            }
            Ok(answer) => panic!("{} got the answer to another request: {answer:?}, not {request:?}", self.name),
            Err(end) => {
                self.note(&format!("← {end:?} [{}]", request.id));
                let excuse = self.excuse(link, began);
                assert!(!matches!(end, NoAnswer::Malformed), "{}: {end:?}", self.name);
                assert!(
                    excuse.is_some(),
                    "{} got no answer to {} {}: {end:?}",
                    self.name,
                    request.method,
                    request.path
                );
                None
            }
        }
    }

    /// Returns whether connections may be closed for others.
    fn is_crowded(&self) -> bool {
        self.world.plan.config.max_connections < 100
    }

    /// Returns the reason why the service may have closed the connection.
    fn excuse(&self, link: &Link, began: Began) -> Option<&'static str> {
        let config = &self.world.plan.config;
        let idle = began.at.saturating_duration_since(link.last_answer);
        let is_loop = link.exchanges >= LOOP_EXCHANGES && link.last_answer.elapsed() <= LOOP_PAUSE;
        match began.fate {
            _ if link.is_unread => Some("the body before was not read"),
            _ if idle >= config.header_timeout => Some("the connection was idle"),
            Fate::ReadsLate(pause) if pause >= config.write_timeout => Some("the client did not read"),
            _ if self.is_crowded() && !is_loop => Some("another connection needed the place"),
            _ if link.must_be_answered() => None,
            _ if !link.instance.is_serving() => Some("the service ends"),
            _ => None,
        }
    }

    /// Checks the end of a call.
    fn judge(&self, link: &Link, (call, _, sent): &(Call, Request, Sent), end: &End, began: Began) {
        if let End::Answered(answer) = end {
            check_form(answer);
            check_closing(answer, link, began.phase);
        }
        let judged = self.world.oracle().ended(call, link.instance.number, sent, end);
        if let Err(violation) = judged {
            panic!("{}: {}: {violation}", self.name, call.text());
        }
    }
}

/// Checks what every answer has.
fn check_form(answer: &Answer) {
    assert_ne!(answer.status, 500, "{answer:?}");
    assert_eq!(answer.header("x-content-type-options"), Some("nosniff"), "{answer:?}");
    if answer.status < 400 {
        return;
    }
    let problem: wire::Problem = answer.read().unwrap_or_else(|error| panic!("{error}: {answer:?}"));
    assert_eq!((problem.status, problem.request_id.as_deref()), (answer.status, answer.header("x-request-id")));
    assert!(problem.kind.starts_with("/problems/") && !problem.title.is_empty() && !problem.detail.is_empty());
    assert!(answer.status != 503 || answer.header("retry-after").is_some(), "{answer:?}");
}

/// Checks that an answer closes its connection if the service ends, and only then.
fn check_closing(answer: &Answer, link: &Link, phase: Phase) {
    let is_told = matches!(phase, Phase::Stopping(at) if at.elapsed() > Duration::from_millis(1));
    assert!(!is_told || answer.closes(), "the service ends and keeps its connection: {answer:?}");
    let may_close = answer.status >= 400 || !link.instance.is_serving();
    assert!(may_close || !answer.closes(), "the service closes a connection without a reason: {answer:?}");
}

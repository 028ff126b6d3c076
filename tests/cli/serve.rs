//! `revprio serve`

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, ExitStatus, Stdio};

use crate::program::{Scratch, failure, program};

/// A server process, killed when dropped.
pub struct Server {
    process: Child,
    pub url: String,
}

impl Server {
    /// Starts on a free port and reads the address from the first line.
    pub fn start() -> Self {
        Self::start_with(&[])
    }

    /// Starts at an address.
    pub fn start_at(address: &str) -> Self {
        Self::launch(address, &[])
    }

    /// Starts on a free port with more options.
    pub fn start_with(flags: &[&str]) -> Self {
        Self::launch("127.0.0.1:0", flags)
    }

    fn launch(address: &str, flags: &[&str]) -> Self {
        let mut command = program(&[&["serve", "--listen", address], flags].concat());
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let url = line.trim().strip_prefix("listening on ").unwrap().to_owned();
        Self { process, url }
    }

    fn address(&self) -> &str {
        self.url.trim_start_matches("http://")
    }

    /// Sends SIGTERM.
    #[cfg(unix)]
    fn signal(&self) {
        let signalled = Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status().unwrap();
        assert!(signalled.success());
    }

    #[cfg(unix)]
    fn terminate(mut self) -> ExitStatus {
        self.signal();
        self.process.wait().unwrap()
    }

    /// Sends a GET request and returns the whole answer; the connection is closed.
    pub fn get(&self, path: &str) -> String {
        let mut stream = TcpStream::connect(self.address()).unwrap();
        let request = format!("GET {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn server_prints_its_address_and_answers_there() {
    let server = Server::start();
    let answer = server.get("/healthz");
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with("\r\n\r\nok"), "{answer}");
}

#[test]
#[cfg(unix)]
fn server_ends_with_success_on_sigterm_with_clients_connected() {
    let server = Server::start();
    let _silent = TcpStream::connect(server.address()).unwrap();
    let mut half = TcpStream::connect(server.address()).unwrap();
    half.write_all(b"POST /v1/step HTTP/1.1\r\nho").unwrap();
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
#[cfg(unix)]
fn stopping_server_is_not_ready_and_finishes_requests_in_progress() {
    let mut server = Server::start_with(&["--drain-delay-s", "2", "--drain-timeout-s", "20"]);
    let body = include_str!("../../api/examples/resolve.json");
    let (first, rest) = body.split_at(20);
    let mut in_flight = TcpStream::connect(server.address()).unwrap();
    let head = format!(
        "POST /v1/resolve HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n",
        body.len()
    );
    in_flight.write_all((head + first).as_bytes()).unwrap();
    assert!(server.get("/readyz").starts_with("HTTP/1.1 200 "));
    server.signal();
    // The signal may arrive after the next requests, so an answer may still be "ready".
    let not_ready = (0..100).map(|_| server.get("/readyz")).find(|answer| answer.starts_with("HTTP/1.1 503 ")).unwrap();
    assert!(not_ready.contains("/problems/draining") && not_ready.contains("retry-after: 1"), "{not_ready}");
    assert!(server.get("/healthz").starts_with("HTTP/1.1 200 "));
    while TcpStream::connect(server.address()).is_ok() {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    in_flight.write_all(rest.as_bytes()).unwrap();
    let mut answer = String::new();
    in_flight.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200 ") && answer.contains("connection: close"), "{answer}");
    assert_eq!(server.process.wait().unwrap().code(), Some(0));
}

#[test]
fn json_log_lines_contain_the_request_id() {
    let scratch = Scratch::new("log");
    let token = scratch.write("token", "secret");
    let flags = ["--log-format", "json", "--log-level", "debug", "--token-file", &token];
    let mut command = program(&[&["serve", "--listen", "127.0.0.1:0"], &flags[..]].concat());
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let url = line.trim().strip_prefix("listening on ").unwrap().to_owned();
    let log = process.stderr.take().unwrap();
    let server = Server { process, url };
    assert!(server.get("/v1/robots").starts_with("HTTP/1.1 401 "));
    // Another thread writes the log, so the answer may come first.
    let mut lines: Vec<serde_json::Value> = Vec::new();
    for line in BufReader::new(log).lines() {
        lines.push(serde_json::from_str(&line.unwrap()).unwrap());
        if lines.last().is_some_and(|line| line["fields"]["message"] == "GET /v1/robots") {
            break;
        }
    }
    drop(server);
    let line = lines.last().unwrap();
    assert_eq!((line["level"].as_str(), line["fields"]["status"].as_u64()), (Some("DEBUG"), Some(401)));
    assert!(line["fields"]["request_id"].as_str().is_some_and(|id| !id.is_empty()), "{line}");
    let readable = |line: &serde_json::Value| line["fields"]["message"].as_str().unwrap().contains("chmod 600");
    assert_eq!(lines.iter().any(readable), cfg!(unix), "a token file that others can read causes a warning: {lines:?}");
}

#[test]
fn commands_send_the_token_to_a_server_that_requires_one() {
    let scratch = Scratch::new("client_token");
    let token = scratch.write("token", "secret");
    let server = Server::start_with(&["--token-file", &token]);
    let arguments = ["resolve", "api/examples/resolve.json", "--server", &server.url];
    assert!(failure(&arguments).contains("(401)"));
    assert!(program(&arguments).env("REVPRIO_TOKEN_FILE", &token).output().unwrap().status.success());
}

#[test]
fn error_of_an_address_in_use_names_the_remedy() {
    let server = Server::start();
    let message = failure(&["serve", "--listen", server.address()]);
    assert!(
        message.contains(&format!("cannot listen on {}", server.address())) && message.contains("--listen"),
        "{message}"
    );
}

/// Waits for the end of a process; fails after 20 s.
#[cfg(unix)]
fn ended(server: &mut Server) -> ExitStatus {
    for _ in 0..400 {
        if let Some(status) = server.process.try_wait().unwrap() {
            return status;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    panic!("the server has not ended");
}

#[test]
#[cfg(unix)]
fn second_signal_ends_the_server_at_once() {
    use std::os::unix::process::ExitStatusExt;
    let mut server = Server::start_with(&["--drain-delay-s", "300"]);
    server.signal();
    assert!((0..100).any(|_| server.get("/readyz").starts_with("HTTP/1.1 503 ")));
    assert!(server.process.try_wait().unwrap().is_none());
    server.signal();
    assert_eq!(ended(&mut server).signal(), Some(15));
}

#[test]
#[cfg(unix)]
fn stopping_server_closes_connections_after_their_answers() {
    let server = Server::start_with(&["--drain-delay-s", "300"]);
    let mut stream = TcpStream::connect(server.address()).unwrap();
    let mut call = || {
        stream.write_all(b"GET /readyz HTTP/1.1\r\nhost: localhost\r\n\r\n").unwrap();
        let mut answer = [0; 4096];
        let length = stream.read(&mut answer).unwrap();
        String::from_utf8_lossy(&answer[..length]).into_owned()
    };
    assert!(!call().contains("connection: close"));
    server.signal();
    let last = (0..1000).map(|_| call()).find(|answer| answer.starts_with("HTTP/1.1 503 ")).unwrap();
    assert!(last.contains("connection: close\r\n"), "{last}");
    assert_eq!(stream.read(&mut [0]).unwrap(), 0);
}

/// Returns the value of the metric for dropped lines.
fn dropped_lines(server: &Server) -> u64 {
    let metrics = server.get("/metrics");
    let value = metrics.lines().find_map(|line| line.strip_prefix("revprio_log_lines_dropped_total "));
    value.unwrap_or_else(|| panic!("{metrics}")).parse().unwrap()
}

/// Asserts that a server that logs every request continues although its log cannot be written, and counts the lines.
#[cfg(unix)]
fn assert_survives(mut server: Server) {
    for _ in 0..100 {
        assert!(server.get("/v1/robots").starts_with("HTTP/1.1 200 "));
    }
    assert!((0..1000).any(|_| dropped_lines(&server) >= 100), "{} lines", dropped_lines(&server));
    server.signal();
    assert_eq!(ended(&mut server).code(), Some(0));
}

#[cfg(unix)]
fn start_with_log(log: impl Into<Stdio>) -> (Server, Option<std::process::ChildStderr>) {
    let mut command = program(&["serve", "--listen", "127.0.0.1:0", "--log-level", "trace"]);
    let mut process = command.stdout(Stdio::piped()).stderr(log).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let url = line.trim().strip_prefix("listening on ").unwrap().to_owned();
    let log = process.stderr.take();
    (Server { process, url }, log)
}

#[test]
#[cfg(target_os = "linux")]
fn server_continues_when_the_log_is_on_a_full_disk() {
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    assert_survives(start_with_log(full).0);
}

#[test]
#[cfg(unix)]
fn server_continues_when_the_reader_of_the_log_has_ended() {
    let (server, log) = start_with_log(Stdio::piped());
    drop(log);
    assert_survives(server);
}

#[test]
#[cfg(unix)]
fn server_continues_when_the_reader_of_the_log_does_not_read() {
    let (mut server, log) = start_with_log(Stdio::piped());
    // The pipe holds 64 KiB, the queue some thousand lines.
    let robots = "GET /v1/robots/panda HTTP/1.1\r\nhost: localhost\r\n\r\n".repeat(2000);
    let last = "GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
    for _ in 0..4 {
        let mut stream = TcpStream::connect(server.address()).unwrap();
        let mut writer = stream.try_clone().unwrap();
        let requests = robots.clone() + last;
        let writing = std::thread::spawn(move || writer.write_all(requests.as_bytes()).unwrap());
        let mut answers = Vec::new();
        stream.read_to_end(&mut answers).unwrap();
        writing.join().unwrap();
    }
    assert!(dropped_lines(&server) > 0);
    server.signal();
    assert_eq!(ended(&mut server).code(), Some(0));
    drop(log);
}

#[test]
#[cfg(target_os = "linux")]
fn start_error_on_a_full_disk_is_an_exit_status() {
    let full = || std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = program(&["serve", "--listen", "0.0.0.0:0"]);
    let status = command.stdout(full()).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(1));
}

#[test]
#[cfg(target_os = "linux")]
fn systemd_is_told_that_the_server_is_ready_alive_and_stopping() {
    use std::os::unix::net::UnixDatagram;
    // The path of a socket has at most 107 characters.
    let path = std::env::temp_dir().join(format!("revprio-{}.sock", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let socket = UnixDatagram::bind(&path).unwrap();
    socket.set_read_timeout(Some(std::time::Duration::from_secs(20))).unwrap();
    let mut command = program(&["serve", "--listen", "127.0.0.1:0"]);
    command.env("NOTIFY_SOCKET", &path).stdout(Stdio::null()).stderr(Stdio::null());
    let mut server = Server { process: command.spawn().unwrap(), url: String::new() };
    let receive = || {
        let mut message = [0; 256];
        let length = socket.recv(&mut message).unwrap();
        String::from_utf8_lossy(&message[..length]).trim().to_owned()
    };
    assert_eq!(receive(), "READY=1");
    assert!((0..5).all(|_| receive() == "WATCHDOG=1"));
    server.signal();
    assert!((0..100).any(|_| receive() == "STOPPING=1"));
    assert_eq!(ended(&mut server).code(), Some(0));
    std::fs::remove_file(&path).unwrap();
}

//! What a seed decides before the run: the settings of the service and the clients.

use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use revprio::service::{ServiceConfig, Token};

use crate::random::Random;

/// The token of services that require one.
pub const TOKEN: &str = "0123456789abcdef0123456789abcdef";

/// What a client does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Controls an arm with requests.
    Loop,
    /// Controls an arm over WebSocket.
    Stream,
    /// Steps, shows and deletes the sessions of others.
    Intruder,
    /// Sends what is no request, sends slowly, does not read, opens many connections.
    Nuisance,
    /// Steps without a session.
    Stateless,
    /// Stops, kills and restarts the service, and pauses its machine.
    Operator,
}

/// The decisions of a seed.
#[derive(Debug)]
pub struct Plan {
    pub config: ServiceConfig,
    pub needs_token: bool,
    /// Maximum time for which work waits for a thread.
    pub max_wait: Duration,
    pub roles: Vec<Role>,
    /// Whether every line of the log fails to be written.
    pub log_fails: bool,
}

impl Plan {
    pub fn random(random: &mut Random) -> Self {
        let needs_token = random.one_in(8);
        let defaults = ServiceConfig::default();
        let config = ServiceConfig {
            token: needs_token.then(token),
            max_sessions: random.weighted(&[(4, 1024), (1, 1), (1, 2), (1, 4)]),
            session_idle: random.weighted(&[(4, defaults.session_idle), (1, Duration::from_secs(2))]),
            max_connections: random.weighted(&[(5, 1000), (1, 4)]),
            work_timeout: random.weighted(&[(3, defaults.work_timeout), (1, Duration::from_millis(30))]),
            header_timeout: random.pick(&[defaults.header_timeout, Duration::from_secs(5)]),
            write_timeout: random.pick(&[defaults.write_timeout, Duration::from_secs(1)]),
            drain_delay: random.pick(&[Duration::ZERO, Duration::from_millis(50), Duration::from_secs(2)]),
            ..defaults
        };
        let role = |random: &mut Random| {
            random.weighted(&[
                (6, Role::Loop),
                (3, Role::Stream),
                (3, Role::Intruder),
                (1, Role::Nuisance),
                (1, Role::Stateless),
            ])
        };
        let mut roles = vec![if random.one_in(4) { Role::Stream } else { Role::Loop }];
        roles.extend((0..random.below(4)).map(|_| role(random)));
        if random.one_in(3) {
            roles.push(Role::Operator);
        }
        let max_wait =
            random.weighted(&[(2, Duration::ZERO), (2, Duration::from_millis(5)), (1, Duration::from_millis(60))]);
        Self { config, needs_token, max_wait, roles, log_fails: random.one_in(16) }
    }
}

/// Returns the token as the service reads it.
fn token() -> Token {
    static READ: OnceLock<Token> = OnceLock::new();
    let read = || {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("simulation-token");
        std::fs::write(&file, TOKEN).unwrap();
        Token::read(&file).unwrap()
    };
    READ.get_or_init(read).clone()
}

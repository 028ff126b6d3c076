//! What the service is told by flags, environment and file.

use std::fmt;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, Parser, ValueEnum};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::robot::RobotArgument;
use crate::service::{ServiceConfig, Tls, TlsError, Token, TokenError};

/// Everything that can be set; the name of a field is its key in the file and, as `REVPRIO_…`, in the environment.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Address and port to listen on; port 0 takes a free one [default: 127.0.0.1:8080]
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<SocketAddr>,
    /// An arm of your own beside the built-in ones; may be repeated
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<Vec<RobotArgument>>,
    /// File with the token that requests must show; needed on any address but a loopback one
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Certificate chain in PEM; HTTPS instead of HTTP
    #[arg(long, value_name = "FILE")]
    tls_cert: Option<PathBuf>,
    /// Key of the certificate in PEM
    #[arg(long, value_name = "FILE")]
    tls_key: Option<PathBuf>,
    /// Origin of web pages that may call, such as https://panel.example; may be repeated
    #[arg(long, value_name = "ORIGIN", value_delimiter = ',')]
    allow_origin: Option<Vec<String>>,
    /// How log lines on standard error look [default: text]
    #[arg(long, value_enum)]
    log_format: Option<LogFormat>,
    /// What is logged: error, warn, info, debug (every request), or as in `info,revprio=debug` [default: info]
    #[arg(long, value_name = "LEVEL")]
    log_level: Option<String>,
    /// Largest body, bytes [default: 1048576]
    #[arg(long, value_name = "COUNT")]
    max_body_bytes: Option<usize>,
    /// Largest body of a batch, bytes [default: 16777216]
    #[arg(long, value_name = "COUNT")]
    max_batch_bytes: Option<usize>,
    /// Bodies of more than 64 KiB that are read at a time; one of several MiB counts as so many [default: 64]
    #[arg(long, value_name = "COUNT")]
    max_large_bodies: Option<usize>,
    /// Controllers open at a time [default: 1024]
    #[arg(long, value_name = "COUNT")]
    max_sessions: Option<usize>,
    /// A controller that gets no state for this long ends, and a registered robot that is not used, s [default: 900]
    #[arg(long, value_name = "SECONDS")]
    session_idle_s: Option<f64>,
    /// Connections at a time; for one more, the one without an answer for the longest time is closed [default: 1000]
    #[arg(long, value_name = "COUNT")]
    max_connections: Option<usize>,
    /// Longest line of waiting requests; those further back get 503 at once, ms [default: 10]
    #[arg(long, value_name = "MILLISECONDS")]
    max_lag_ms: Option<f64>,
    /// Time for a request's headers, and for an idle connection, s [default: 30]
    #[arg(long, value_name = "SECONDS")]
    header_timeout_s: Option<f64>,
    /// Time for a body, s [default: 10]
    #[arg(long, value_name = "SECONDS")]
    body_timeout_s: Option<f64>,
    /// Time after which a client that does not read its answer is dropped, s [default: 10]
    #[arg(long, value_name = "SECONDS")]
    write_timeout_s: Option<f64>,
    /// Time for the TLS handshake, s [default: 10]
    #[arg(long, value_name = "SECONDS")]
    handshake_timeout_s: Option<f64>,
    /// Time between the signal to end and the end of listening, in which /readyz says no, s [default: 0]
    #[arg(long, value_name = "SECONDS")]
    drain_delay_s: Option<f64>,
    /// Time for requests in flight at the end, s [default: 1]
    #[arg(long, value_name = "SECONDS")]
    drain_timeout_s: Option<f64>,
}

/// How log lines look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// For people.
    #[default]
    Text,
    /// One JSON object a line.
    Json,
}

/// Flags of the service, and where the file is.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// File with settings (TOML); flags and REVPRIO_… variables go before it [env: REVPRIO_CONFIG]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    flags: Settings,
}

/// Why the settings are refused.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is no TOML, or has a key or value that there is not.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: Box<toml::de::Error>,
    },
    /// A variable has a value that cannot be.
    #[error("{variable}: {problem}")]
    Environment {
        /// Name of the variable.
        variable: String,
        /// What is wrong.
        problem: String,
    },
    /// A setting makes no sense.
    #[error("{key}, set by {origin}: {problem}")]
    Value {
        /// The setting.
        key: String,
        /// Who set it.
        origin: Origin,
        /// What is wrong.
        problem: &'static str,
    },
    /// The settings cannot be written down.
    #[error(transparent)]
    Write(#[from] toml::ser::Error),
    /// The token is no token.
    #[error(transparent)]
    Token(#[from] TokenError),
    /// Certificate or key are wrong.
    #[error(transparent)]
    Tls(#[from] TlsError),
}

/// Who set a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// A flag of the command.
    Flag,
    /// A variable of the environment.
    Environment(String),
    /// The file.
    File(PathBuf),
    /// Nobody.
    Default,
}

impl fmt::Display for Origin {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Flag => formatter.write_str("flag"),
            Self::Environment(variable) => write!(formatter, "environment, {variable}"),
            Self::File(path) => write!(formatter, "file, {}", path.display()),
            Self::Default => formatter.write_str("default"),
        }
    }
}

/// The settings in force, each with its origin.
pub struct InForce {
    /// In the order of the help.
    values: Vec<(String, Option<(Value, Origin)>)>,
    settings: Settings,
}

impl InForce {
    /// Flags before environment before file before defaults; `variable` reads the environment.
    pub fn of(options: &Options, variable: impl Fn(&str) -> Option<String>) -> Result<Self, SettingsError> {
        let variable = |name: &str| variable(name).filter(|value| !value.is_empty());
        let path = options.config.clone().or_else(|| variable("REVPRIO_CONFIG").map(PathBuf::from));
        let flags = Table::try_from(&options.flags)?;
        let file = path.as_deref().map(read).transpose()?.unwrap_or_default();
        let defaults = Table::try_from(Settings::defaults())?;
        let (mut values, mut table) = (Vec::new(), Table::new());
        for (key, flag) in keys() {
            let name = format!("REVPRIO_{}", key.to_uppercase());
            let set = if let Some(value) = flags.get(&key) {
                Some((value.clone(), Origin::Flag))
            } else if let Some(text) = variable(&name) {
                Some((from_text(&key, &flag, &text, &name)?, Origin::Environment(name)))
            } else if let (Some(value), Some(path)) = (file.get(&key), &path) {
                Some((value.clone(), Origin::File(path.clone())))
            } else {
                defaults.get(&key).map(|value| (value.clone(), Origin::Default))
            };
            if let Some((value, origin)) = &set {
                check(&key, value, origin)?;
                table.insert(key.clone(), value.clone());
            }
            values.push((key, set));
        }
        let settings = table
            .try_into()
            .map_err(|source| SettingsError::File { path: path.unwrap_or_default(), source: Box::new(source) })?;
        Ok(Self { values, settings })
    }

    /// Where to listen.
    pub fn listen(&self) -> SocketAddr {
        self.settings.listen.unwrap_or_else(default_address)
    }

    /// Robots beside the built-in ones.
    pub fn robots(&self) -> &[RobotArgument] {
        self.settings.robot.as_deref().unwrap_or_default()
    }

    /// How log lines look.
    pub fn log_format(&self) -> LogFormat {
        self.settings.log_format.unwrap_or_default()
    }

    /// What is logged.
    pub fn log_level(&self) -> &str {
        self.settings.log_level.as_deref().unwrap_or("info")
    }

    /// What the service needs; reads token, certificate and key.
    pub fn service(&self) -> Result<ServiceConfig, SettingsError> {
        let (settings, default) = (&self.settings, ServiceConfig::default());
        // Checked when the settings were put together.
        let seconds = |value: Option<f64>, default: Duration| value.map_or(default, Duration::from_secs_f64);
        let tls = match (&settings.tls_cert, &settings.tls_key) {
            (Some(cert), Some(key)) => Some(Tls::read(cert, key)?),
            (None, None) => None,
            (Some(_), None) => return Err(self.refused("tls_cert", "needs tls_key, too")),
            (None, Some(_)) => return Err(self.refused("tls_key", "needs tls_cert, too")),
        };
        Ok(ServiceConfig {
            token: settings.token_file.as_deref().map(Token::read).transpose()?,
            tls,
            allowed_origins: settings.allow_origin.clone().unwrap_or_default(),
            max_body_bytes: settings.max_body_bytes.unwrap_or(default.max_body_bytes),
            max_batch_bytes: settings.max_batch_bytes.unwrap_or(default.max_batch_bytes),
            max_large_bodies: settings.max_large_bodies.unwrap_or(default.max_large_bodies),
            max_sessions: settings.max_sessions.unwrap_or(default.max_sessions),
            session_idle: seconds(settings.session_idle_s, default.session_idle),
            max_connections: settings.max_connections.unwrap_or(default.max_connections),
            max_lag: seconds(settings.max_lag_ms.map(|ms| ms / 1e3), default.max_lag),
            header_timeout: seconds(settings.header_timeout_s, default.header_timeout),
            body_timeout: seconds(settings.body_timeout_s, default.body_timeout),
            write_timeout: seconds(settings.write_timeout_s, default.write_timeout),
            handshake_timeout: seconds(settings.handshake_timeout_s, default.handshake_timeout),
            drain_delay: seconds(settings.drain_delay_s, default.drain_delay),
            drain_timeout: seconds(settings.drain_timeout_s, default.drain_timeout),
        })
    }

    /// The refusal of a setting.
    pub fn refused(&self, key: &str, problem: &'static str) -> SettingsError {
        let set = self.values.iter().find(|(name, _)| name == key).and_then(|(_, set)| set.as_ref());
        let origin = set.map_or(Origin::Default, |(_, origin)| origin.clone());
        SettingsError::Value { key: key.to_owned(), origin, problem }
    }
}

/// As a file that sets the same.
impl fmt::Display for InForce {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        for (key, set) in &self.values {
            match set {
                Some((value, origin)) => writeln!(formatter, "{:<42} # {origin}", format!("{key} = {value}"))?,
                None => writeln!(formatter, "{:<42} # default", format!("# {key} is not set"))?,
            }
        }
        Ok(())
    }
}

impl Settings {
    fn defaults() -> Self {
        let service = ServiceConfig::default();
        let seconds = |duration: Duration| Some(duration.as_secs_f64());
        Self {
            listen: Some(default_address()),
            log_format: Some(LogFormat::Text),
            log_level: Some("info".to_owned()),
            max_body_bytes: Some(service.max_body_bytes),
            max_batch_bytes: Some(service.max_batch_bytes),
            max_large_bodies: Some(service.max_large_bodies),
            max_sessions: Some(service.max_sessions),
            session_idle_s: seconds(service.session_idle),
            max_connections: Some(service.max_connections),
            max_lag_ms: Some(service.max_lag.as_secs_f64() * 1e3),
            header_timeout_s: seconds(service.header_timeout),
            body_timeout_s: seconds(service.body_timeout),
            write_timeout_s: seconds(service.write_timeout),
            handshake_timeout_s: seconds(service.handshake_timeout),
            drain_delay_s: seconds(service.drain_delay),
            drain_timeout_s: seconds(service.drain_timeout),
            ..Self::default()
        }
    }
}

fn default_address() -> SocketAddr {
    SocketAddr::from(([127, 0, 0, 1], 8080))
}

/// Settings by key, with the flag of each.
fn keys() -> Vec<(String, String)> {
    let command = Settings::augment_args(clap::Command::new("settings"));
    let key =
        |argument: &clap::Arg| (argument.get_id().to_string(), argument.get_long().unwrap_or_default().to_owned());
    command.get_arguments().map(key).collect()
}

/// A file's settings; those that there are not are refused.
fn read(path: &Path) -> Result<Table, SettingsError> {
    let text = std::fs::read_to_string(path).map_err(|source| SettingsError::Read { path: path.to_owned(), source })?;
    let settings: Settings = toml::from_str(&text)
        .map_err(|source| SettingsError::File { path: path.to_owned(), source: Box::new(source) })?;
    Ok(Table::try_from(settings)?)
}

/// A setting from a text, read as the flag of that name would be.
fn from_text(key: &str, flag: &str, text: &str, variable: &str) -> Result<Value, SettingsError> {
    #[derive(Parser)]
    #[command(no_binary_name = true)]
    struct Flags {
        #[command(flatten)]
        settings: Settings,
    }
    let refused = |problem: String| SettingsError::Environment { variable: variable.to_owned(), problem };
    let flags = Flags::try_parse_from([format!("--{flag}={text}")]).map_err(|error| {
        let message = error.to_string();
        refused(message.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned())
    })?;
    let table = Table::try_from(flags.settings)?;
    table.get(key).cloned().ok_or_else(|| refused("has no value".to_owned()))
}

/// Refuses numbers and origins that make no sense.
fn check(key: &str, value: &Value, origin: &Origin) -> Result<(), SettingsError> {
    /// Longest time in any unit: some weeks in seconds.
    const LONGEST: f64 = 1e7;
    let may_be_zero = matches!(key, "drain_delay_s" | "max_lag_ms");
    let problem = match value {
        Value::Integer(count) if *count < 1 => "must be at least 1",
        Value::Float(time) if !(0.0..=LONGEST).contains(time) => "must be between 0 and 10000000",
        Value::Float(time) if *time == 0.0 && !may_be_zero => "must be positive",
        Value::Array(origins)
            if key == "allow_origin" && !origins.iter().all(|origin| origin.as_str().is_some_and(is_origin)) =>
        {
            "an origin is scheme, host and port, such as https://panel.example:8443, without a path"
        }
        _ => return Ok(()),
    };
    Err(SettingsError::Value { key: key.to_owned(), origin: origin.clone(), problem })
}

fn is_origin(text: &str) -> bool {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://")).unwrap_or_default();
    !host.is_empty() && host.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-.:[]_".contains(&byte))
}

//! Settings of the service from options, environment and file.

use std::fmt;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, Parser, ValueEnum};
use revprio_api::wire::read_error::in_plain_words;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};
use tracing_subscriber::filter::{LevelFilter, Targets};

use super::log_filter::log_filter;
use super::robot::RobotArgument;
use crate::service::{ServiceConfig, Tls, TlsError, Token, TokenError, is_host_name};

/// All settings. The name of a field is its key in the file and, as `REVPRIO_…`, in the environment.
#[derive(Debug, Clone, Default, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Address and port to listen on; port 0 selects a free one [default: 127.0.0.1:8080]
    #[arg(long, value_name = "ADDRESS", value_parser = listen_address)]
    listen: Option<SocketAddr>,
    /// Your own robot, in addition to the built-in ones; may be repeated
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<Vec<RobotArgument>>,
    /// Directory of robot files (.urdf, .toml, .json); each robot has the name of its file, without the extension
    #[arg(long, value_name = "DIRECTORY")]
    robots_dir: Option<PathBuf>,
    /// File with the token that requests must contain; required on all addresses except loopback
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Certificate chain in PEM; enables HTTPS instead of HTTP
    #[arg(long, value_name = "FILE")]
    tls_cert: Option<PathBuf>,
    /// Private key of the certificate in PEM
    #[arg(long, value_name = "FILE")]
    tls_key: Option<PathBuf>,
    /// Origin of web pages that may call the service, for example https://panel.example; may be repeated
    #[arg(long, value_name = "ORIGIN", value_delimiter = ',')]
    allow_origin: Option<Vec<String>>,
    /// Name of the service in the header `Host`, in addition to its address and localhost; may be repeated
    #[arg(long, value_name = "HOST", value_delimiter = ',')]
    allow_host: Option<Vec<String>>,
    /// Format of log lines on standard error [default: text]
    #[arg(long, value_enum)]
    log_format: Option<LogFormat>,
    /// Log level: off, error, warn, info, debug (every request), trace, or a filter like `info,revprio=debug` [default: info]
    #[arg(long, value_name = "LEVEL")]
    log_level: Option<String>,
    /// Largest request body, bytes [default: 4194304]
    #[arg(long, value_name = "COUNT")]
    max_body_bytes: Option<usize>,
    /// Largest request body of a batch, bytes [default: 16777216]
    #[arg(long, value_name = "COUNT")]
    max_batch_bytes: Option<usize>,
    /// Largest number of concurrent bodies above 64 KiB; a body of N MiB counts N times [default: 64]
    #[arg(long, value_name = "COUNT")]
    max_large_bodies: Option<usize>,
    /// Largest number of open sessions [default: 1024]
    #[arg(long, value_name = "COUNT")]
    max_sessions: Option<usize>,
    /// Time after which an unused session or registered robot is removed, s [default: 900]
    #[arg(long, value_name = "SECONDS")]
    session_idle_s: Option<f64>,
    /// Largest number of connections; a further one closes the one that is idle for longest; a stream only after 30 s without a state [default: 1000]
    #[arg(long, value_name = "COUNT")]
    max_connections: Option<usize>,
    /// Largest waiting time of a request; later requests get 503 at once, ms [default: 10]
    #[arg(long, value_name = "MILLISECONDS")]
    max_lag_ms: Option<f64>,
    /// Deadline of long work, waiting included, s; batches have ten times as long [default: 60]
    #[arg(long, value_name = "SECONDS")]
    work_timeout_s: Option<f64>,
    /// Time after which a service that does not answer ends itself with status 70, s [default: 5]
    #[arg(long, value_name = "SECONDS")]
    stuck_after_s: Option<f64>,
    /// Timeout for request headers and idle connections, s [default: 30]
    #[arg(long, value_name = "SECONDS")]
    header_timeout_s: Option<f64>,
    /// Timeout for a request body, s [default: 10]
    #[arg(long, value_name = "SECONDS")]
    body_timeout_s: Option<f64>,
    /// Timeout for a client that does not read its answer, s [default: 10]
    #[arg(long, value_name = "SECONDS")]
    write_timeout_s: Option<f64>,
    /// Timeout for the TLS handshake, s [default: 10]
    #[arg(long, value_name = "SECONDS")]
    handshake_timeout_s: Option<f64>,
    /// Time between the stop signal and the end of listening, during which /readyz returns 503, s [default: 0]
    #[arg(long, value_name = "SECONDS")]
    drain_delay_s: Option<f64>,
    /// Timeout for requests in progress at the end, s [default: 1]
    #[arg(long, value_name = "SECONDS")]
    drain_timeout_s: Option<f64>,
}

/// Format of log lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// Text.
    #[default]
    Text,
    /// One JSON object per line.
    Json,
}

/// Options of the service, and the path of the settings file.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// File with settings (TOML); options and REVPRIO_… variables override it [env: REVPRIO_CONFIG]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    flags: Settings,
}

/// Why the settings are not valid.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is not valid TOML, or has an unknown key or an invalid value.
    #[error("{path}: {}", in_plain_words(&source.to_string()))]
    File {
        /// The file.
        path: PathBuf,
        /// The error, with its line.
        source: Box<toml::de::Error>,
    },
    /// A variable has an invalid value.
    #[error("{variable}: {problem}")]
    Environment {
        /// Name of the variable.
        variable: String,
        /// The error.
        problem: String,
    },
    /// A setting has an invalid value.
    #[error("{key}, set by {origin}: {problem}")]
    Value {
        /// The setting.
        key: String,
        /// Its source.
        origin: Origin,
        /// The error.
        problem: &'static str,
    },
    /// The settings cannot be serialized.
    #[error(transparent)]
    Write(#[from] toml::ser::Error),
    /// The token is not valid.
    #[error(transparent)]
    Token(#[from] TokenError),
    /// The certificate or its key is not valid.
    #[error(transparent)]
    Tls(#[from] TlsError),
}

/// The source of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// An option of the command.
    Flag,
    /// An environment variable.
    Environment(String),
    /// The file.
    File(PathBuf),
    /// The default.
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

/// The effective settings, each with its source.
pub struct EffectiveSettings {
    /// In the order of the help.
    values: Vec<(String, Option<(Value, Origin)>)>,
    settings: Settings,
}

impl EffectiveSettings {
    /// Combines the sources: options override the environment, which overrides the file, which overrides the defaults.
    /// `variable` reads the environment.
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

    /// Returns the address to listen on.
    pub fn listen(&self) -> SocketAddr {
        self.settings.listen.unwrap_or_else(default_address)
    }

    /// Returns the robots in addition to the built-in ones.
    pub fn robots(&self) -> &[RobotArgument] {
        self.settings.robot.as_deref().unwrap_or_default()
    }

    /// Returns the directory of robot files.
    pub fn robots_dir(&self) -> Option<&Path> {
        self.settings.robots_dir.as_deref()
    }

    /// Returns the format of log lines.
    pub fn log_format(&self) -> LogFormat {
        self.settings.log_format.unwrap_or_default()
    }

    /// Returns which log lines are written.
    pub fn log_filter(&self) -> Targets {
        // The text was checked when the settings were combined.
        let stated = self.settings.log_level.as_deref().and_then(log_filter);
        stated.unwrap_or_else(|| Targets::new().with_default(LevelFilter::INFO))
    }

    /// Returns the configuration of the service; reads token, certificate and key.
    pub fn service(&self) -> Result<ServiceConfig, SettingsError> {
        let (settings, default) = (&self.settings, ServiceConfig::default());
        // The values were checked when the settings were combined.
        let seconds = |value: Option<f64>, default: Duration| value.map_or(default, Duration::from_secs_f64);
        let tls = match (&settings.tls_cert, &settings.tls_key) {
            (Some(cert), Some(key)) => Some(Tls::read(cert, key)?),
            (None, None) => None,
            (Some(_), None) => return Err(self.refused("tls_cert", "needs tls_key as well")),
            (None, Some(_)) => return Err(self.refused("tls_key", "needs tls_cert as well")),
        };
        Ok(ServiceConfig {
            token: settings.token_file.as_deref().map(Token::read).transpose()?,
            tls,
            allowed_origins: settings.allow_origin.clone().unwrap_or_default(),
            allowed_hosts: settings.allow_host.clone().unwrap_or_default(),
            max_body_bytes: settings.max_body_bytes.unwrap_or(default.max_body_bytes),
            max_batch_bytes: settings.max_batch_bytes.unwrap_or(default.max_batch_bytes),
            max_large_bodies: settings.max_large_bodies.unwrap_or(default.max_large_bodies),
            max_sessions: settings.max_sessions.unwrap_or(default.max_sessions),
            session_idle: seconds(settings.session_idle_s, default.session_idle),
            max_connections: settings.max_connections.unwrap_or(default.max_connections),
            max_lag: seconds(settings.max_lag_ms.map(|ms| ms / 1e3), default.max_lag),
            work_timeout: seconds(settings.work_timeout_s, default.work_timeout),
            stuck_after: seconds(settings.stuck_after_s, default.stuck_after),
            header_timeout: seconds(settings.header_timeout_s, default.header_timeout),
            body_timeout: seconds(settings.body_timeout_s, default.body_timeout),
            write_timeout: seconds(settings.write_timeout_s, default.write_timeout),
            handshake_timeout: seconds(settings.handshake_timeout_s, default.handshake_timeout),
            drain_delay: seconds(settings.drain_delay_s, default.drain_delay),
            drain_timeout: seconds(settings.drain_timeout_s, default.drain_timeout),
        })
    }

    /// Returns the error of a setting.
    pub fn refused(&self, key: &str, problem: &'static str) -> SettingsError {
        let set = self.values.iter().find(|(name, _)| name == key).and_then(|(_, set)| set.as_ref());
        let origin = set.map_or(Origin::Default, |(_, origin)| origin.clone());
        SettingsError::Value { key: key.to_owned(), origin, problem }
    }
}

/// Formats the settings as a file with the same values.
impl fmt::Display for EffectiveSettings {
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
            work_timeout_s: seconds(service.work_timeout),
            stuck_after_s: seconds(service.stuck_after),
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

fn listen_address(text: &str) -> Result<SocketAddr, &'static str> {
    text.parse().map_err(|_| "give an IP address and a port, for example 127.0.0.1:8080 or [::1]:8080")
}

fn default_address() -> SocketAddr {
    SocketAddr::from(([127, 0, 0, 1], 8080))
}

/// Returns key and option of each setting.
fn keys() -> Vec<(String, String)> {
    let command = Settings::augment_args(clap::Command::new("settings"));
    let key =
        |argument: &clap::Arg| (argument.get_id().to_string(), argument.get_long().unwrap_or_default().to_owned());
    command.get_arguments().map(key).collect()
}

/// Reads the settings of a file; unknown keys are an error.
fn read(path: &Path) -> Result<Table, SettingsError> {
    let text = std::fs::read_to_string(path).map_err(|source| SettingsError::Read { path: path.to_owned(), source })?;
    let settings: Settings = toml::from_str(&text)
        .map_err(|source| SettingsError::File { path: path.to_owned(), source: Box::new(source) })?;
    Ok(Table::try_from(settings)?)
}

/// Parses the value of a setting like the option of the same name.
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

/// Checks numbers, origins, hosts and the log level.
fn check(key: &str, value: &Value, origin: &Origin) -> Result<(), SettingsError> {
    /// Largest time in any unit; some months in seconds.
    const MAX_TIME: f64 = 1e7;
    let may_be_zero = matches!(key, "drain_delay_s" | "max_lag_ms");
    let problem = match value {
        Value::Integer(count) if *count < 1 => "must be at least 1",
        Value::Float(time) if !(0.0..=MAX_TIME).contains(time) => "must be between 0 and 10000000",
        Value::Float(time) if *time == 0.0 && !may_be_zero => "must be positive",
        Value::Array(origins)
            if key == "allow_origin" && !origins.iter().all(|origin| origin.as_str().is_some_and(is_origin)) =>
        {
            "an origin is scheme, host and port without a path, for example https://panel.example:8443"
        }
        Value::Array(hosts)
            if key == "allow_host" && !hosts.iter().all(|host| host.as_str().is_some_and(is_host_name)) =>
        {
            "a host is a name or an address without scheme, port and path, for example cell-4.example"
        }
        Value::String(level) if key == "log_level" && log_filter(level).is_none() => {
            "is not a log level: give off, error, warn, info, debug or trace, or a filter of targets and levels, for \
             example `info,revprio=debug`"
        }
        _ => return Ok(()),
    };
    Err(SettingsError::Value { key: key.to_owned(), origin: origin.clone(), problem })
}

fn is_origin(text: &str) -> bool {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://")).unwrap_or_default();
    !host.is_empty() && host.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-.:[]_".contains(&byte))
}

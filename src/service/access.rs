//! Access checks: the bearer token, and the origin of web pages.

use std::net::IpAddr;

use axum::http::{HeaderMap, header};

use super::config::ServiceConfig;
use super::error::ApiError;

/// Refuses requests that a web page of another site makes.
pub fn check_origin(config: &ServiceConfig, headers: &HeaderMap) -> Result<(), ApiError> {
    let Some(origin) = headers.get(header::ORIGIN) else { return Ok(()) };
    let origin = origin.to_str().unwrap_or_default();
    if config.allowed_origins.iter().any(|allowed| allowed == origin) || is_own(config, origin, headers) {
        Ok(())
    } else {
        Err(ApiError::foreign_origin(origin))
    }
}

/// Refuses requests without the token, if the service has one.
pub fn check_token(config: &ServiceConfig, headers: &HeaderMap) -> Result<(), ApiError> {
    match &config.token {
        Some(token) if !token.is_in(headers) => Err(ApiError::unauthorized()),
        _ => Ok(()),
    }
}

/// Returns whether the page came from this service.
///
/// Another site can let its host name resolve to this machine (DNS rebinding). Its pages then look like pages of this
/// service. Without a token, only pages from an IP address or from `localhost` therefore count as own pages.
fn is_own(config: &ServiceConfig, origin: &str, headers: &HeaderMap) -> bool {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let authority = origin.split_once("://").map_or("", |(_, authority)| authority);
    !host.is_empty() && authority.eq_ignore_ascii_case(host) && (config.token.is_some() || needs_no_dns(host))
}

/// Returns whether the host is an IP address or `localhost`, so that no name server can redirect it.
fn needs_no_dns(host_and_port: &str) -> bool {
    let (host, port) = host_and_port.rsplit_once(':').unwrap_or((host_and_port, ""));
    let host = if port.bytes().all(|byte| byte.is_ascii_digit()) { host } else { host_and_port };
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host.eq_ignore_ascii_case("localhost") || host.parse::<IpAddr>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_addresses_and_localhost_need_no_dns() {
        let addresses =
            ["localhost", "LOCALHOST:8080", "127.0.0.1", "127.0.0.1:80", "[::1]:8080", "[::1]", "192.168.0.7"];
        for host in addresses {
            assert!(needs_no_dns(host), "{host}");
        }
        for host in ["a", "a:80", "localhost.evil.example", "127.0.0.1.evil.example:8080", "", ":80", "1.2.3"] {
            assert!(!needs_no_dns(host), "{host}");
        }
    }
}

//! The header `Host`: which names are names of this service.
//!
//! Another site can let its name resolve to this machine (DNS rebinding). Its pages in a browser of this machine could
//! then read sessions. The browser sends the name of that site as `Host`, so every route refuses it.

use std::net::IpAddr;

use axum::http::{HeaderMap, Uri, header, uri::Authority};

use super::error::ApiError;

/// Refuses a request unless it has exactly one host, and that host is a name of this service: the address `local` that
/// accepted the connection, a loopback address, `localhost`, or one of `allowed`. The port is not compared, because a
/// forwarded port may differ.
pub fn check(headers: &HeaderMap, uri: &Uri, local: Option<IpAddr>, allowed: &[String]) -> Result<(), ApiError> {
    let mut hosts = headers.get_all(header::HOST).iter();
    let host = hosts.next().ok_or_else(|| ApiError::bad_host("the header `Host` is missing; send exactly one"))?;
    if hosts.next().is_some() {
        return Err(ApiError::bad_host("more than one header `Host`; send exactly one"));
    }
    let refused = || ApiError::bad_host("`Host` is not a host with an optional port");
    let text = host.to_str().map_err(|_| refused())?;
    check_name(name(text).ok_or_else(refused)?, local, allowed)?;
    // A target with a host, as for a proxy, has precedence over the header.
    uri.authority().map_or(Ok(()), |target| check_name(name(target.as_str()).ok_or_else(refused)?, local, allowed))
}

/// Returns the host without its port.
fn name(host_and_port: &str) -> Option<&str> {
    let authority: Authority = host_and_port.parse().ok()?;
    let host_length = authority.host().len();
    let port = &host_and_port.get(host_length..)?;
    let is_port =
        port.is_empty() || port.strip_prefix(':').is_some_and(|port| port.is_empty() || port.parse::<u16>().is_ok());
    (is_port && host_length > 0 && !host_and_port.contains('@')).then(|| &host_and_port[..host_length])
}

fn check_name(name: &str, local: Option<IpAddr>, allowed: &[String]) -> Result<(), ApiError> {
    let without_dot = name.strip_suffix('.').unwrap_or(name);
    let is_own = match address(name) {
        Some(address) => address.is_loopback() || local.is_some_and(|local| local.to_canonical() == address),
        None => without_dot.eq_ignore_ascii_case("localhost"),
    };
    if is_own || allowed.iter().any(|allowed| same(allowed, without_dot)) {
        Ok(())
    } else {
        Err(ApiError::foreign_host(name))
    }
}

fn same(allowed: &str, name: &str) -> bool {
    match (address(allowed), address(name)) {
        (Some(allowed), Some(name)) => allowed == name,
        _ => allowed.eq_ignore_ascii_case(name),
    }
}

/// Returns the address that a host is, if it is not a name.
fn address(host: &str) -> Option<IpAddr> {
    let host = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
    host.parse::<IpAddr>().ok().map(|address| address.to_canonical())
}

/// Returns whether a text is a host without scheme, port and path.
pub fn is_host_name(text: &str) -> bool {
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || b"-._".contains(&byte);
    address(text).is_some() || (!text.is_empty() && text.bytes().all(is_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the type of the problem; empty if the request is accepted.
    fn refusal(hosts: &[&str], target: &str) -> &'static str {
        let mut headers = HeaderMap::new();
        for host in hosts {
            headers.append(header::HOST, host.parse().unwrap());
        }
        let allowed = ["cell-4.example".to_owned(), "10.0.0.7".to_owned(), "fe80::7".to_owned()];
        let local = "192.168.0.7".parse().ok();
        check(&headers, &target.parse().unwrap(), local, &allowed).err().map_or("", |error| error.kind())
    }

    #[test]
    fn only_the_own_address_localhost_and_configured_names_are_names_of_the_service() {
        let own = [
            "localhost",
            "LocalHost:8080",
            "localhost.",
            "127.0.0.1",
            "127.8.0.1:1",
            "[::1]:8080",
            "192.168.0.7:8080",
            "[::ffff:192.168.0.7]",
            "cell-4.EXAMPLE:443",
            "cell-4.example.",
            "10.0.0.7",
            "[fe80::7]:1",
            "localhost:",
        ];
        for host in own {
            assert_eq!(refusal(&[host], "/"), "", "{host}");
        }
        let foreign = [
            "evil.example",
            "evil.example:8080",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "192.168.0.8",
            "xcell-4.example",
            "0.0.0.0",
            "[::2]",
            "2130706433",
            "0x7f.1",
        ];
        for host in foreign {
            assert_eq!(refusal(&[host], "/"), "foreign-host", "{host}");
        }
    }

    #[test]
    fn a_request_has_one_host_that_is_a_host() {
        assert_eq!((refusal(&[], "/"), refusal(&["localhost", "localhost"], "/")), ("bad-host", "bad-host"));
        for host in ["", ":80", "localhost:http", "localhost:99999", "a@localhost", "localhost/", "local host", "a,b c"]
        {
            assert_eq!(refusal(&[host], "/"), "bad-host", "{host}");
        }
    }

    #[test]
    fn the_host_of_the_target_counts_too() {
        assert_eq!(refusal(&["localhost"], "http://evil.example/v1/robots"), "foreign-host");
        assert_eq!(refusal(&["localhost"], "http://localhost:1/v1/robots"), "");
    }

    #[test]
    fn a_configured_host_has_no_scheme_port_or_path() {
        assert!(["a", "a-b.example", "10.0.0.7", "::1", "[::1]"].into_iter().all(is_host_name));
        assert!(!["", "a:80", "http://a", "a/b", "a b", "*"].into_iter().any(is_host_name));
    }
}

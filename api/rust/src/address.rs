//! Names of services to IP addresses.

use std::net::IpAddr;

use ureq::config::Config;
use ureq::http::Uri;
use ureq::unversioned::resolver::{DefaultResolver, ResolvedSocketAddrs, Resolver};
use ureq::unversioned::transport::NextTimeout;

/// Looks up names as ureq does, and takes IP addresses as they are.
///
/// For a lookup with a timeout, ureq starts a thread in every request, also for an IP address and an open connection.
#[derive(Debug, Default)]
pub struct AddressResolver(DefaultResolver);

impl Resolver for AddressResolver {
    fn resolve(&self, uri: &Uri, config: &Config, timeout: NextTimeout) -> Result<ResolvedSocketAddrs, ureq::Error> {
        let port = uri.port_u16().or_else(|| default_port(uri));
        let address: Option<IpAddr> = uri.host().and_then(|host| host.trim_matches(['[', ']']).parse().ok());
        let (Some(address), Some(port)) = (address, port) else { return self.0.resolve(uri, config, timeout) };
        let mut addresses = self.empty();
        addresses.push((address, port).into());
        Ok(addresses)
    }
}

fn default_port(uri: &Uri) -> Option<u16> {
    match uri.scheme_str() {
        Some("http") => Some(80),
        Some("https") => Some(443),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use ureq::Timeout;
    use ureq::unversioned::transport::time::Duration;

    use super::*;

    fn resolve(uri: &str) -> Vec<String> {
        let timeout = NextTimeout { after: Duration::from_secs(9), reason: Timeout::Global, ..NextTimeout::default() };
        let addresses = AddressResolver::default().resolve(&uri.parse().unwrap(), &Config::default(), timeout);
        addresses.unwrap().iter().map(ToString::to_string).collect()
    }

    #[test]
    fn addresses_are_taken_as_they_are_with_the_port_of_the_scheme() {
        assert_eq!(resolve("http://127.0.0.1:8080/v1"), ["127.0.0.1:8080"]);
        assert_eq!(resolve("http://10.0.0.7"), ["10.0.0.7:80"]);
        assert_eq!(resolve("https://[::1]/v1"), ["[::1]:443"]);
    }

    #[test]
    fn names_are_looked_up() {
        assert!(resolve("http://localhost:8080").iter().any(|address| address.ends_with(":8080")));
    }
}

//! The headers `Accept` and `Accept-Encoding` (RFC 9110, section 12.5).

use axum::http::{HeaderMap, HeaderName, header};

/// Returns the offered value whose media type has the highest weight, the first one of equals. Returns `None` if the
/// client accepts none of them.
pub fn preferred<T: Copy>(headers: &HeaderMap, offered: &[(&str, T)]) -> Option<T> {
    let entries = weighted(headers, &header::ACCEPT);
    if entries.is_empty() {
        return offered.first().map(|(_, value)| *value);
    }
    let mut best: Option<(f64, T)> = None;
    for (media_type, value) in offered {
        let weight = media_type_weight(&entries, media_type);
        if weight > best.map_or(0.0, |(weight, _)| weight) {
            best = Some((weight, *value));
        }
    }
    best.map(|(_, value)| value)
}

/// Returns whether the client accepts gzip.
pub fn gzip(headers: &HeaderMap) -> bool {
    let entries = weighted(headers, &header::ACCEPT_ENCODING);
    let weight = |name: &str| entries.iter().find(|(known, _)| known == name).map(|(_, weight)| *weight);
    weight("gzip").or_else(|| weight("*")).is_some_and(|weight| weight > 0.0)
}

/// Returns the weight of the most specific matching entry: `a/b`, then `a/*`, then `*/*`.
fn media_type_weight(entries: &[(String, f64)], media_type: &str) -> f64 {
    let family = media_type.split('/').next().unwrap_or_default();
    let patterns = [media_type.to_owned(), format!("{family}/*"), "*/*".to_owned()];
    let matching = patterns.iter().find_map(|pattern| entries.iter().find(|(name, _)| name == pattern));
    matching.map_or(0.0, |(_, weight)| *weight)
}

/// Returns the entries of a header with their weights. The default weight is 1; an unreadable weight counts as 0.
fn weighted(headers: &HeaderMap, name: &HeaderName) -> Vec<(String, f64)> {
    let lists = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
    let entry = |text: &str| {
        let mut parts = text.split(';').map(str::trim);
        let name = parts.next().filter(|name| !name.is_empty())?.to_ascii_lowercase();
        let weight = parts.find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")));
        Some((name, weight.map_or(1.0, |weight| weight.parse().unwrap_or(0.0))))
    };
    lists.flat_map(|list| list.split(',')).filter_map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn accepting(accept: &str) -> Option<char> {
        let headers = HeaderMap::from_iter([(header::ACCEPT, accept.parse().unwrap())]);
        preferred(&headers, &[("text/csv", 'c'), ("application/json", 'j')])
    }

    #[test]
    fn the_highest_weight_wins_and_the_first_of_equals() {
        assert_eq!(preferred(&HeaderMap::new(), &[("text/csv", 'c'), ("application/json", 'j')]), Some('c'));
        for (accept, answer) in [
            ("*/*", Some('c')),
            ("application/json", Some('j')),
            ("Application/JSON;q=0.2", Some('j')),
            ("text/csv;q=0.5, application/*", Some('j')),
            ("*/*, text/csv;q=0", Some('j')),
            ("text/html", None),
            ("text/csv;q=nonsense", None),
        ] {
            assert_eq!(accepting(accept), answer, "{accept}");
        }
    }

    #[test]
    fn gzip_needs_an_entry_with_a_positive_weight() {
        let gzip = |text: &str| gzip(&HeaderMap::from_iter([(header::ACCEPT_ENCODING, text.parse().unwrap())]));
        assert!(gzip("br, gzip") && gzip("gzip;q=0.1") && gzip("*"));
        assert!(!gzip("br") && !gzip("gzip;q=0, *") && !gzip("identity"));
    }
}

//! Errors of reading in plain words, with the possible values and the nearest one.
//!
//! Serde describes an error in the words of Rust: "unknown variant `forse`, expected one of …", "invalid type: map, expected
//! f64". A caller of the interface knows values, fields, lists and objects. The text is all that `serde_json` and `toml` tell
//! about such an error, so this module reads the text. A text that it does not know stays as it is.

/// Maximum length of a value that a text repeats, characters.
const MAX_REPEATED: usize = 60;

/// Words of serde for types, and what a caller gives for them.
const EXPECTED: &[(&str, &str)] = &[
    ("f64", "a number"),
    ("f32", "a number"),
    ("u8", "a whole number, not negative"),
    ("u16", "a whole number, not negative"),
    ("u32", "a whole number, not negative"),
    ("u64", "a whole number, not negative"),
    ("usize", "a whole number, not negative"),
    ("a boolean", "`true` or `false`"),
    ("a sequence", "a list"),
    ("a map", "an object"),
];

/// Words of serde for values without a content.
const GIVEN: &[(&str, &str)] =
    &[("null", "`null`"), ("unit value", "`null`"), ("sequence", "a list"), ("map", "an object")];

/// Words of `serde_json` for text that is not JSON.
const SYNTAX: &[(&str, &str)] = &[
    ("EOF while parsing a value", "the text ends where a value should be"),
    ("EOF while parsing a list", "the text ends within a list"),
    ("EOF while parsing an object", "the text ends within an object"),
    ("EOF while parsing a string", "the text ends within a string"),
    ("expected value", "this is not a JSON value; strings stand in double quotes"),
    ("expected ident", "this is not a JSON value; strings stand in double quotes"),
    ("key must be a string", "the name of a field must stand in double quotes"),
    ("trailing comma", "remove the comma before the closing bracket"),
    ("trailing characters", "more text follows the value; send one value only"),
    ("recursion limit exceeded", "lists and objects are nested too deeply"),
];

/// Returns the text of an error of `serde_json` or `toml` in plain words. Line and column stay.
#[must_use]
pub fn in_plain_words(error: &str) -> String {
    // An error of TOML shows the line in the file, and ends with the text.
    if let Some((shown, text)) = error.trim_end().rsplit_once('\n').filter(|_| error.starts_with("TOML ")) {
        return format!("{shown}\n{}", in_plain_words(text));
    }
    let (text, place) = error.split_at(error.rfind(" at line ").unwrap_or(error.len()));
    let text = unknown(text, "variant", "value")
        .or_else(|| unknown(text, "field", "field"))
        .or_else(|| Some(format!("the field `{}` is missing", name_after(text, "missing field ")?)))
        .or_else(|| Some(format!("give the field `{}` only once", name_after(text, "duplicate field ")?)))
        .or_else(|| wrong_type(text))
        .unwrap_or_else(|| translated(SYNTAX, text).to_owned());
    format!("{text}{place}")
}

/// Returns the text for an unknown value or field; `kind`: the word of serde, `word`: ours.
fn unknown(text: &str, kind: &str, word: &str) -> Option<String> {
    let text = text.strip_prefix("unknown ")?.strip_prefix(kind)?;
    let (given, known) = text.rsplit_once(", expected ").or_else(|| text.rsplit_once(", there are no "))?;
    let given = given.strip_prefix(" `")?.strip_suffix('`')?;
    let known: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
    let guess = nearest(given, &known).map(|name| format!("did you mean `{name}`? ")).unwrap_or_default();
    let known = known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let known = if known.is_empty() { "none is known".to_owned() } else { format!("known: {known}") };
    Some(format!("there is no {word} `{}`; {guess}{known}", shortened(given)))
}

/// Shortest beginning of a name from which the name can be guessed, bytes.
const MIN_BEGINNING: usize = 3;

/// Returns the known name that was probably meant: the one that begins so, or the nearest one, if at most a third of its
/// characters differ.
#[must_use]
pub fn nearest<'a>(given: &str, known: &[&'a str]) -> Option<&'a str> {
    let given = shortened(given).to_lowercase();
    let begins = |name: &&&str| given.len() >= MIN_BEGINNING && name.starts_with(&given);
    if let Some(name) = known.iter().find(begins) {
        return Some(name);
    }
    let distance = |name: &&str| strsim::osa_distance(&given, name);
    let near = known.iter().copied().min_by_key(distance)?;
    (3 * distance(&near) <= near.len().max(3)).then_some(near)
}

/// Returns the text for a value of a wrong type, outside its range, or of a wrong length.
fn wrong_type(text: &str) -> Option<String> {
    let (kind, text) = text.strip_prefix("invalid ")?.split_once(' ')?;
    let (given, expected) = text.rsplit_once(", expected ")?;
    let expected = wanted(expected);
    match kind {
        "type:" | "value:" => Some(format!("give {expected}, not {}", value(given))),
        "length" => Some(format!("give {expected}, not of {given}")),
        _ => None,
    }
}

/// Returns what a caller gives for a type in the words of serde.
fn wanted(expected: &str) -> String {
    let length = ["an array of length ", "a tuple of size "].iter().find_map(|start| expected.strip_prefix(start));
    let is_object = ["struct ", "internally tagged enum "].iter().any(|start| expected.starts_with(start));
    match length {
        Some(length) => format!("a list of {length} entries"),
        None if is_object => "an object".to_owned(),
        None => translated(EXPECTED, expected).to_owned(),
    }
}

/// Returns a given value, from the words of serde.
fn value(given: &str) -> String {
    if let Some(text) = given.strip_prefix("string ") {
        return format!("the string {}", shortened(text));
    }
    let number =
        ["integer `", "floating point `"].iter().find_map(|start| given.strip_prefix(start)?.strip_suffix('`'));
    let word = number.or_else(|| given.strip_prefix("boolean ")).unwrap_or_else(|| translated(GIVEN, given));
    shortened(word)
}

fn name_after<'a>(text: &'a str, start: &str) -> Option<&'a str> {
    text.strip_prefix(start)?.strip_prefix('`')?.strip_suffix('`')
}

fn translated<'a>(words: &[(&str, &'static str)], text: &'a str) -> &'a str {
    words.iter().find(|(word, _)| *word == text).map_or(text, |(_, plain)| plain)
}

fn shortened(text: &str) -> String {
    if text.chars().count() <= MAX_REPEATED {
        return text.to_owned();
    }
    text.chars().take(MAX_REPEATED).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use serde::de::DeserializeOwned;

    use super::in_plain_words;
    use crate::wire::{ControllerTask, Law, Method, Object, ResolveRequest, State};

    /// Returns the error of a text that is no `T`.
    fn refusal<T: DeserializeOwned>(text: &str) -> String {
        in_plain_words(&serde_json::from_str::<T>(text).map(|_| ()).unwrap_err().to_string())
    }

    #[test]
    fn unknown_values_are_listed_with_the_nearest_one() {
        assert_eq!(
            refusal::<Method>("\"reverse_prority\""),
            "there is no value `reverse_prority`; did you mean `reverse_priority`? known: `pseudoinverse`, \
             `damped_least_squares`, `task_priority`, `singularity_robust`, `reverse_priority`, `strict_reverse_priority`"
        );
        let far = refusal::<Method>("\"newton, expected `a`\"");
        assert!(far.starts_with("there is no value `newton, expected `a``; known: `pseudoinverse`, "), "{far}");
        let short = refusal::<Method>("\"reverse\"");
        assert!(short.starts_with("there is no value `reverse`; did you mean `reverse_priority`? known: "), "{short}");
        let law = refusal::<Object<Law>>(r#"{"kind": "Forse"}"#);
        assert!(law.starts_with("there is no value `Forse`; did you mean `force`? known: "), "{law}");
    }

    #[test]
    fn unknown_missing_and_repeated_fields_are_named() {
        let field = refusal::<ControllerTask>(r#"{"name": "a", "axis": ["x"]}"#);
        assert!(field.starts_with("there is no field `axis`; did you mean `axes`? known: `name`, `axes`, "), "{field}");
        let missing = refusal::<ControllerTask>("{}");
        assert!(missing.starts_with("the field `name` is missing at line"), "{missing}");
        let twice = refusal::<ControllerTask>(r#"{"name": "a", "name": "b"}"#);
        assert!(twice.starts_with("give the field `name` only once at line"), "{twice}");
    }

    #[test]
    fn types_are_those_of_json() {
        let state = |field: &str, value: &str| {
            let text = r#"{"sequence": 1, "joint_position": []}"#.replace('}', &format!(", \"{field}\": {value}}}"));
            let text = refusal::<State>(&text);
            text.split(" at line").next().unwrap().to_owned()
        };
        assert_eq!(state("time_s", "\"0.1\""), "give a number, not the string \"0.1\"");
        assert_eq!(state("time_s", "[0.1]"), "give a number, not a list");
        assert_eq!(state("time_s", "null"), "give a number, not `null`");
        assert_eq!(state("wrench", "7"), "give an object, not 7");
        assert_eq!(state("wrench", r#"{"force": [1, 2]}"#), "give a list of 3 entries, not of 2");
        let scale = refusal::<ControllerTask>(r#"{"name": "a", "scale": 1.5}"#);
        assert!(scale.starts_with("give `true` or `false`, not 1.5"), "{scale}");
        let long = refusal::<ResolveRequest>(&format!(r#"{{"period_s": "{}"}}"#, "ü".repeat(1000)));
        assert!(long.chars().count() < 150, "{long}");
    }

    #[test]
    fn text_that_is_not_json_is_explained() {
        assert!(refusal::<State>("{").starts_with("the text ends within an object at line 1"));
        assert!(refusal::<State>("{'a': 1}").starts_with("the name of a field must stand in double quotes at line 1"));
    }

    #[test]
    fn an_error_of_toml_keeps_its_picture() {
        let error =
            "TOML parse error at line 1, column 5\n  |\n1 | a = 1\n  |     ^\nunknown field `a`, expected `b`\n";
        let plain = in_plain_words(error);
        assert!(plain.ends_with("     ^\nthere is no field `a`; did you mean `b`? known: `b`"), "{plain}");
        assert!(plain.starts_with("TOML parse error at line 1, column 5\n  |\n1 | a"), "{plain}");
    }
}
